//! Boxes of pixels and inverse depths of one camera, as other cameras see them: to leave out in one step what is nowhere near.
//!
//! A pixel `(x, y)` of a camera at inverse depth `w` is the point `direction(x, y) + w · position` in homogeneous coordinates, for parallel
//! lines of sight `w · position(x, y) + direction`. Both are linear in each of `x`, `y` and `w`, so that whatever lies in a box of these,
//! `w = 0` for infinity included, is in the hull of the box's eight corners.

use glam::{DAffine3, DVec2, DVec3};

use super::camera::Camera;
use super::intrinsics::Intrinsics;

/// Eight points in homogeneous coordinates whose hull holds all points of some pixels between two inverse depths.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PixelBox {
    camera_position: DVec3,
    /// What comes before the camera's position, and the inverse depth.
    corners: [(DVec3, f64); 8],
}

/// Where in a picture a box may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum BoxInPicture {
    /// All of it is behind the camera.
    Nowhere,
    /// Between two image positions, pixels.
    Between([DVec2; 2]),
    /// Parts of it are behind the camera.
    Anywhere,
}

impl PixelBox {
    /// From the least to the largest image positions, pixels, and from the far to the near inverse depth, 1/unit.
    pub(crate) fn new(camera: &Camera, [low, high]: [DVec2; 2], (far, near): (f32, f32)) -> Self {
        let corner = |index: usize| {
            let side = |bit: usize, low: f64, high: f64| if index >> bit & 1 == 1 { high } else { low };
            let pixel = DVec2::new(side(0, low.x, high.x), side(1, low.y, high.y));
            let inverse_depth = side(2, f64::from(far), f64::from(near));
            let lens = &camera.intrinsics;
            let in_camera = if lens.is_orthographic() {
                lens.point_in_camera(pixel, 0.0) * inverse_depth + DVec3::Z
            } else {
                lens.ray_in_camera(pixel)
            };
            (camera.world_from_camera.matrix3 * in_camera, inverse_depth)
        };
        Self { camera_position: camera.position_in_world(), corners: std::array::from_fn(corner) }
    }

    /// The corners in another space.
    pub(crate) fn corners_in(&self, target_from_world: &DAffine3) -> [(DVec3, f64); 8] {
        let position = target_from_world.transform_point3(self.camera_position);
        self.corners.map(|(before, w)| (target_from_world.matrix3 * before + position * w, w))
    }

    /// Where it may be in a picture.
    pub(crate) fn in_picture(&self, lens: &Intrinsics, camera_from_world: &DAffine3) -> BoxInPicture {
        BoxInPicture::of(&self.corners_in(camera_from_world), lens)
    }
}

impl BoxInPicture {
    /// Holds the hull of eight points in the camera's space, each with its inverse depth in its own camera.
    pub(crate) fn of(corners: &[(DVec3, f64); 8], lens: &Intrinsics) -> Self {
        if corners.iter().all(|(point, _)| point.z <= 0.0) {
            return Self::Nowhere;
        }
        let (mut least, mut most) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for (point, w) in corners {
            let divisor = if lens.is_orthographic() { *w } else { point.z };
            let position =
                DVec2::new(lens.cx + lens.fx * point.x / divisor, lens.cy + lens.fy * point.y / divisor);
            if point.z <= 0.0 || divisor <= 0.0 || !position.is_finite() {
                return Self::Anywhere;
            }
            (least, most) = (least.min(position), most.max(position));
        }
        Self::Between([least, most])
    }

    /// Whether nothing of it is within `margin` pixels of what lies between two image positions.
    pub(crate) fn is_off(self, [low, high]: [DVec2; 2], margin: f64) -> bool {
        match self {
            Self::Nowhere => true,
            Self::Between([least, most]) => {
                most.cmplt(low - margin).any() || least.cmpgt(high + margin).any()
            }
            Self::Anywhere => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::intrinsics::Projection;
    use crate::random::mix;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn whatever_lies_in_a_box_is_where_the_box_is(
            seed in any::<u64>(),
            of_lines in any::<bool>(),
            to_lines in any::<bool>(),
        ) {
            let state = std::cell::Cell::new(seed);
            let within = |low: f64, high: f64| {
                state.set(mix(state.get()));
                low + (high - low) * (state.get() >> 11) as f64 / (1_u64 << 53) as f64
            };
            let camera = |is_parallel: bool| {
                let mut lens = Intrinsics::from_horizontal_angle(64, 48, 0.9);
                if is_parallel {
                    lens = Intrinsics { fx: 12.0, fy: 12.0, projection: Projection::Orthographic, ..lens };
                }
                let eye = DVec3::new(within(-3.0, 3.0), within(-3.0, 3.0), within(-3.0, 3.0));
                Camera::look_at("c", lens, eye, eye + DVec3::new(within(-1.0, 1.0), 1.0, within(-1.0, 1.0)), DVec3::Z)
            };
            let (source, target) = (camera(of_lines), camera(to_lines));
            let low = DVec2::new(within(0.0, 40.0), within(0.0, 30.0));
            let high = low + DVec2::new(within(0.0, 16.0), within(0.0, 16.0));
            let far = within(0.0, 0.4) as f32;
            let near = far + within(0.0, 2.0) as f32;
            let tile = PixelBox::new(&source, [low, high], (far, near));
            let place = tile.in_picture(&target.intrinsics, &target.camera_from_world());
            for _ in 0..40 {
                let pixel = low + (high - low) * DVec2::new(within(0.0, 1.0), within(0.0, 1.0));
                let depth = within(f64::from(far), f64::from(near)).max(1e-9).recip();
                let point = source.world_from_camera.transform_point3(source.intrinsics.point_in_camera(pixel, depth));
                if let Some((position, _)) = target.project(point) {
                    prop_assert!(!place.is_off([position, position], 1e-6), "{position} is not in {place:?}");
                }
            }
        }
    }
}
