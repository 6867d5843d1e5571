//! The nearest camera, warped.
//!
//! Purpose: the simplest baseline.
//!
//! Source: L. `McMillan` and G. Bishop, *Plenoptic Modeling: An Image-Based Rendering System*, SIGGRAPH 1995, §3.3: every pixel of a
//! picture with depth is carried forward to the new viewpoint by its generalized disparity, and drawn as large as it appears there.
//!
//! What differs: pictures are planar, not cylindrical; a z-buffer decides instead of the order in which pixels are visited, with the
//! same result; a pixel is a square of whole pixels.

use glam::DVec2;

use super::model::{RecordedView, RivalModel};
use super::sky::by_distance;
use super::splat::Splatter;
use overlook_engine::capture::Camera;
use overlook_engine::render::Picture;

/// All views; each viewpoint is shown from one of them.
pub(super) struct NearestCamera(Vec<RecordedView>);

impl NearestCamera {
    pub(super) fn new(views: &[RecordedView]) -> Self {
        Self(views.to_vec())
    }
}

impl RivalModel for NearestCamera {
    fn render(&self, target: &Camera) -> Picture {
        let view = by_distance(&self.0, target)[0];
        let mut splatter = Splatter::new(target);
        let map = splatter.map_from(&view.camera);
        let width = view.frame.size().0;
        let pixels = view.frame.inverse_depth.as_slice().iter().zip(view.frame.color.as_slice()).enumerate();
        for (pixel, (inverse_depth, color)) in pixels {
            if *inverse_depth >= 0.0 {
                let center = DVec2::new((pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5);
                splatter.add(&map, center, *inverse_depth, color.map(half::f16::to_f32));
            }
        }
        splatter.finish()
    }

    fn bytes(&self) -> Option<u64> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::slope;
    use super::*;

    #[test]
    fn from_a_camera_of_its_own_the_picture_is_that_cameras_and_from_beside_it_has_no_cracks() {
        let (left, right) = (slope(-0.3), slope(0.3));
        let both = NearestCamera::new(&[left.clone(), right.clone()]);
        for view in [&left, &right] {
            let picture = both.render(&view.camera);
            let same = picture.color.as_slice().iter().zip(view.frame.color.as_slice());
            assert!(same.clone().all(|(shown, known)| shown[0] == known[0].to_f32()));
        }
        let beside = both.render(&slope(0.2).camera);
        assert!((4..28).all(|y| (8..40).all(|x| beside.image[(x, y)] == 0)));
    }
}
