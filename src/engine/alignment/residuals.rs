//! How far apart two cameras are about one sample, and how that changes with their poses and exposure.
//!
//! Purpose: the residuals that alignment makes small. Source: point to plane (Y. Chen and G. Medioni, *Object Modelling by
//! Registration of Multiple Range Images*, 1992), and color against color (Q.-Y. Zhou and V. Koltun, *Color Map Optimization for
//! 3D Reconstruction with Consumer Depth Cameras*, SIGGRAPH 2014). What differs: the plane belongs to the carried sample and is
//! fitted once; the point is the other camera's own, unfitted measurement where the sample falls. Distances count in footprints,
//! times the ratio of inverse depths, so that the noise of triangulation is the same everywhere.

use glam::{DAffine3, DVec2, DVec3};

use super::reference_view::ReferenceView;
use super::surface_samples::SurfaceSample;
use crate::capture::Intrinsics;

/// Unknowns of one camera: rotation and translation in camera space, and the logarithm of its gain.
pub(crate) const UNKNOWNS: usize = 7;
/// The gain among them.
pub(crate) const GAIN: usize = 6;

/// A residual and its derivatives by the unknowns of the sample's camera and of the other one.
#[derive(Clone, Copy)]
pub(crate) struct Term {
    pub(crate) residual: f64,
    pub(crate) source: [f64; UNKNOWNS],
    pub(crate) target: [f64; UNKNOWNS],
}

/// How far two cameras are apart about one sample.
pub(crate) struct Terms {
    /// In footprints; `None` where the other camera has no depth there.
    pub(crate) distance: Option<Term>,
    /// In brightness; `None` near the border of the picture, and where either picture shows another surface beside the sample's at
    /// this resolution.
    pub(crate) color: Option<Term>,
}

/// Both cameras of a pair, from where one sample after the other is carried.
pub(crate) struct PairOfViews<'a> {
    target: &'a ReferenceView,
    target_from_source: DAffine3,
    source_lens: Intrinsics,
    /// Gains of source and target.
    gains: [f64; 2],
    scale: ProblemScale,
    /// Whether the target's depth is left out.
    color_alone: bool,
}

/// What makes unknowns and residuals comparable: all cameras are taken to have this.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ProblemScale {
    /// Typical inverse depth, 1/unit.
    pub(crate) inverse_depth: f64,
    /// Typical focal length, pixels.
    pub(crate) focal: f64,
}

/// Samples that the target sees from the side or from behind are left out: cosine of incidence.
const LEAST_COSINE: f64 = 0.15;
/// Bounds of the ratio of inverse depths that distances are multiplied with.
const NEARNESS: [f64; 2] = [0.2, 2.0];

impl<'a> PairOfViews<'a> {
    pub(crate) fn new(
        [source, target]: [&'a ReferenceView; 2],
        world_from_cameras: [DAffine3; 2],
        log_gains: [f64; 2],
        scale: ProblemScale,
        color_alone: bool,
    ) -> Self {
        let target_from_source = world_from_cameras[1].inverse() * world_from_cameras[0];
        let source_lens = source.camera.intrinsics;
        // Only the ratio of both gains counts: else all gains would go to zero, where nothing disagrees.
        let louder = log_gains[1] - log_gains[0];
        Self {
            target,
            target_from_source,
            source_lens,
            gains: [(-0.5 * louder).exp(), (0.5 * louder).exp()],
            scale,
            color_alone,
        }
    }

    /// The residuals of a sample of the source in the target; `None` where the target does not see the point, or sees another surface,
    /// farther away than `gate` footprints.
    pub(crate) fn terms(&self, sample: &SurfaceSample, level: usize, gate: f64) -> Option<Terms> {
        let ray = self.source_lens.ray_in_camera(sample.pixel);
        let point = ray / sample.inverse_depth;
        let there = self.target_from_source.transform_point3(point);
        let normal = self.target_from_source.matrix3 * sample.normal_in_camera;
        if normal.dot(there) < LEAST_COSINE * there.length() {
            return None;
        }
        let lens = &self.target.camera.intrinsics;
        let image = lens.project(there)?;
        let distance = if self.color_alone {
            None
        } else {
            let term = self.distance(sample, point, normal, image)?;
            if term.residual.abs() > gate {
                return None;
            }
            Some(term)
        };
        let color = self.color(sample, point, there, image, level);
        Some(Terms { distance, color })
    }

    /// The distance of a sample from the surface that the target saw at `image`; `point` is in the source, `normal` in the target.
    fn distance(&self, sample: &SurfaceSample, point: DVec3, normal: DVec3, image: DVec2) -> Option<Term> {
        let (column, row, here) = self.target.surface_at(image)?;
        let lens = &self.target.camera.intrinsics;
        let found = lens.ray_in_camera(DVec2::new(column as f64 + 0.5, row as f64 + 0.5)) / f64::from(here);
        let nearness = (sample.inverse_depth / self.scale.inverse_depth).clamp(NEARNESS[0], NEARNESS[1]);
        let unit = self.scale.focal * sample.inverse_depth * nearness;
        let in_source = self.target_from_source.inverse().transform_point3(found);
        let touched = self.on_surface(sample, point, in_source).unwrap_or(point);
        let residual = sample.normal_in_camera.dot(in_source - touched) * unit;
        let (n, m) = (sample.normal_in_camera * unit, normal * unit);
        let mut term = Term { residual, source: [0.0; UNKNOWNS], target: [0.0; UNKNOWNS] };
        self.set_pose(&mut term.source, -point.cross(n), -n);
        self.set_pose(&mut term.target, found.cross(m), m);
        Some(term)
    }

    /// Where the source sees the sample's surface when it looks at `in_source`: that bends away from the plane at `point`. `None` where
    /// it sees none.
    fn on_surface(&self, sample: &SurfaceSample, point: DVec3, in_source: DVec3) -> Option<DVec3> {
        let image = self.source_lens.project(in_source)?;
        let ray = in_source / in_source.z;
        let normal = sample.normal_in_camera;
        let inverse_depth = normal.dot(ray) / normal.dot(point) + sample.bend.at(image - sample.pixel);
        (inverse_depth > 0.0).then(|| ray / inverse_depth)
    }

    /// The difference of brightness between a sample and `image`; `point` is in the source, `there` is the same in the target.
    fn color(
        &self,
        sample: &SurfaceSample,
        point: DVec3,
        there: DVec3,
        image: DVec2,
        level: usize,
    ) -> Option<Term> {
        let is_pure = level < sample.pure_levels && level < self.target.pure_levels_at(image);
        let [found, across, down] = self.target.brightness_at(level, image.x, image.y).filter(|_| is_pure)?;
        let lens = &self.target.camera.intrinsics;
        let [own_gain, gain] = self.gains;
        let (across, down) = (across * gain, down * gain);
        let (found, own) = (found * gain, sample.brightness[level] * own_gain);
        let slope = DVec3::new(
            across * lens.fx,
            down * lens.fy,
            -(across * lens.fx * there.x + down * lens.fy * there.y) / there.z,
        ) / there.z;
        let back = self.target_from_source.matrix3.transpose() * slope;
        let mut term = Term { residual: found - own, source: [0.0; UNKNOWNS], target: [0.0; UNKNOWNS] };
        self.set_pose(&mut term.source, point.cross(back), back);
        self.set_pose(&mut term.target, -there.cross(slope), -slope);
        term.target[GAIN] = 0.5 * (found + own);
        term.source[GAIN] = -term.target[GAIN];
        Some(term)
    }

    /// Derivatives by rotation and translation, which count in footprints.
    fn set_pose(&self, unknowns: &mut [f64; UNKNOWNS], rotation: DVec3, translation: DVec3) {
        let rotation = rotation / self.scale.focal;
        let translation = translation / (self.scale.focal * self.scale.inverse_depth);
        unknowns[..3].copy_from_slice(&rotation.to_array());
        unknowns[3..6].copy_from_slice(&translation.to_array());
    }
}
