//! A color lens that is not the depth lens, and how well pairs of cameras agree under it.
//!
//! Purpose: recordings of depth sensors often claim one lens and one place for color and depth, which come from two sensors beside
//! each other. Source: color is looked up for points of the depth camera, and has to be the same in every camera that sees the point
//! (Q.-Y. Zhou and V. Koltun, *Color Map Optimization for 3D Reconstruction with Consumer Depth Cameras*, SIGGRAPH 2014). What
//! differs: the unknowns are those of one sensor that all cameras share, and brightness is standardized in each pair: neither exposure
//! counts nor contrast, which magnifying lowers.

use glam::{DAffine3, DQuat, DVec2, DVec3};

use super::reference_view::ReferenceView;
use crate::capture::Intrinsics;

/// Unknowns: logarithm of the focal length, rotation, translation, principal point; see [`ColorLens::moved`].
pub(crate) const UNKNOWNS: usize = 9;

/// The lens of color beside the depth camera, for a sensor whose depth has the lens that the capture claims for both.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub(crate) struct ColorLens {
    /// The lens of color.
    pub(crate) intrinsics: Intrinsics,
    /// From the space of the depth camera into that of the color camera; rigid.
    pub(crate) color_from_depth: DAffine3,
}

impl ColorLens {
    /// Color through the lens of depth.
    pub(crate) fn of_depth(intrinsics: Intrinsics) -> Self {
        Self { intrinsics, color_from_depth: DAffine3::IDENTITY }
    }

    /// Focal length times `ratio`.
    pub(crate) fn scaled(mut self, ratio: f64) -> Self {
        self.intrinsics.fx *= ratio;
        self.intrinsics.fy *= ratio;
        self
    }

    /// Moved by a step of the unknowns: translation counts in `distance`, the principal point in focal lengths of `depth`.
    pub(crate) fn moved(&self, step: &[f64; UNKNOWNS], depth: &Intrinsics, distance: f64) -> Self {
        let mut intrinsics = self.scaled(step[0].exp()).intrinsics;
        intrinsics.cx += step[7] * depth.fx;
        intrinsics.cy += step[8] * depth.fx;
        let turn = DQuat::from_scaled_axis(DVec3::from_slice(&step[1..4]));
        let DAffine3 { matrix3, translation } = self.color_from_depth;
        let rotation = (turn * DQuat::from_mat3(&matrix3)).normalize();
        let translation = translation + distance * DVec3::from_slice(&step[4..7]);
        Self { intrinsics, color_from_depth: DAffine3::from_rotation_translation(rotation, translation) }
    }

    /// The unknowns that lead here from the lens of depth.
    pub(crate) fn unknowns(&self, depth: &Intrinsics, distance: f64) -> [f64; UNKNOWNS] {
        let turn = DQuat::from_mat3(&self.color_from_depth.matrix3).to_scaled_axis();
        let shift = self.color_from_depth.translation / distance;
        let center = DVec2::new(self.intrinsics.cx - depth.cx, self.intrinsics.cy - depth.cy) / depth.fx;
        let focal = (self.intrinsics.fx / depth.fx).ln();
        [focal, turn.x, turn.y, turn.z, shift.x, shift.y, shift.z, center.x, center.y]
    }

    /// Position in the color picture of a point in depth camera space; `None` behind the color camera.
    pub(crate) fn image(&self, point_in_depth: DVec3) -> Option<DVec2> {
        self.intrinsics.project(self.color_from_depth.transform_point3(point_in_depth))
    }

    /// Brightness at a point of the depth camera, and its derivatives by the unknowns.
    fn brightness(&self, view: &ReferenceView, point: DVec3, sensing: &Sensing) -> Option<Brightness> {
        let turned = self.color_from_depth.matrix3 * point;
        let there = turned + self.color_from_depth.translation;
        let image = self.intrinsics.project(there)?;
        let [value, across, down] = view.brightness_at(sensing.level, image.x, image.y)?;
        let (across, down) = (across * self.intrinsics.fx, down * self.intrinsics.fy);
        let (x, y) = (there.x / there.z, there.y / there.z);
        let slope = DVec3::new(across, down, -(across * x + down * y)) / there.z;
        let (turn, shift) = (turned.cross(slope), slope * sensing.distance);
        let center = sensing.depth_focal / self.intrinsics.fx;
        let by_unknown = [
            across * x + down * y,
            turn.x,
            turn.y,
            turn.z,
            shift.x,
            shift.y,
            shift.z,
            across * center,
            down * center * self.intrinsics.fx / self.intrinsics.fy,
        ];
        Some(Brightness { value, by_unknown })
    }
}

/// Brightness and its derivatives by the unknowns.
struct Brightness {
    value: f64,
    by_unknown: [f64; UNKNOWNS],
}

/// How brightness is looked up.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sensing {
    /// Resolution.
    pub(crate) level: usize,
    /// One match of this many is looked at.
    pub(crate) stride: usize,
    /// What translation counts in: a typical depth.
    pub(crate) distance: f64,
    /// What the principal point counts in, pixels.
    pub(crate) depth_focal: f64,
}

/// Points that two cameras saw, in the space of the depth camera of each.
pub(crate) struct Matches<'a> {
    pub(crate) views: [&'a ReferenceView; 2],
    pub(crate) points: Vec<[DVec3; 2]>,
    /// For each of them, how many resolutions, the finest first, tell of it in both cameras: what is around it does not spoil them.
    pub(crate) levels: Vec<usize>,
}

/// The difference of standardized brightness at one match, and its derivatives.
pub(crate) struct BrightnessDifference {
    pub(crate) match_index: usize,
    pub(crate) value: f64,
    pub(crate) by_unknown: [f64; UNKNOWNS],
}

/// The least contrast: brightness is taken to vary by this much, so that flat pictures do not count.
const LEAST_CONTRAST: f64 = 0.02;

impl Matches<'_> {
    /// How many matches are looked at.
    pub(crate) fn count(&self, sensing: &Sensing) -> usize {
        self.looked_at(sensing).count()
    }

    /// The matches that are looked at, with their indices.
    fn looked_at(&self, sensing: &Sensing) -> impl Iterator<Item = (usize, &[DVec3; 2])> {
        let level = sensing.level;
        let seen = self.points.iter().enumerate().filter(move |(index, _)| level < self.levels[*index]);
        seen.step_by(sensing.stride)
    }

    /// The differences at all matches that both color pictures show.
    pub(crate) fn differences(&self, lens: &ColorLens, sensing: &Sensing) -> Vec<BrightnessDifference> {
        let seen: Vec<(usize, [Brightness; 2])> = self
            .looked_at(sensing)
            .filter_map(|(index, [own, other])| {
                let own = lens.brightness(self.views[0], *own, sensing)?;
                Some((index, [own, lens.brightness(self.views[1], *other, sensing)?]))
            })
            .collect();
        let count = seen.len().max(1) as f64;
        let [own, other] = [0, 1].map(|side: usize| {
            let mean = seen.iter().map(|(_, both)| both[side].value).sum::<f64>() / count;
            let square = seen.iter().map(|(_, both)| (both[side].value - mean).powi(2)).sum::<f64>();
            (mean, 1.0 / (square / count).sqrt().max(LEAST_CONTRAST))
        });
        let difference = |(match_index, both): &(usize, [Brightness; 2])| BrightnessDifference {
            match_index: *match_index,
            value: (both[1].value - other.0) * other.1 - (both[0].value - own.0) * own.1,
            by_unknown: std::array::from_fn(|unknown| {
                both[1].by_unknown[unknown] * other.1 - both[0].by_unknown[unknown] * own.1
            }),
        };
        seen.iter().map(difference).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unknowns_of_a_lens_lead_back_to_it() {
        let depth = Intrinsics::centered(64, 48, 60.0);
        let step = [-0.1, 0.01, -0.02, 0.03, 0.02, 0.01, -0.01, 0.005, -0.004];
        let lens = ColorLens::of_depth(depth).moved(&step, &depth, 2.0);
        assert!((lens.intrinsics.fx / depth.fx - (-0.1_f64).exp()).abs() < 1e-12);
        let back = lens.unknowns(&depth, 2.0);
        for (value, expected) in back.iter().zip(step) {
            assert!((value - expected).abs() < 1e-9, "{back:?}");
        }
    }
}
