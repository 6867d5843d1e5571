//! Samples where they lie in the world: what is exported, whatever the format.

use glam::{DVec2, DVec3};

use super::sample_set::SampleImage;
use super::tile::Sample;
use crate::capture::Camera;

/// World units from the origin up to which single precision holds a tenth of a thousandth of a unit.
const NEAR: f64 = 1e3;

/// A sample that is not at infinity, and its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedSample {
    /// Its pixel, and its index into the planes.
    pub sample: Sample,
    /// The line of sight through the center of the pixel, in camera space, scaled to `z = 1`.
    pub ray_in_camera: DVec3,
    /// Planar z, world units, above 0.
    pub depth: f64,
    /// World units.
    pub point_in_world: DVec3,
}

impl SampleImage {
    /// Every sample that is not at infinity, in storage order; `camera` is the one that saw the image.
    pub fn placed<'a>(&'a self, camera: &'a Camera) -> impl Iterator<Item = PlacedSample> + 'a {
        let depths = self.inverse_depths();
        self.samples().filter_map(move |sample| {
            let inverse_depth = depths[sample.index];
            if inverse_depth <= 0.0 {
                return None;
            }
            let depth = 1.0 / f64::from(inverse_depth);
            let center = DVec2::new(sample.x as f64 + 0.5, sample.y as f64 + 0.5);
            let ray_in_camera = camera.intrinsics.ray_in_camera(center);
            let point_in_world = camera.unproject(center, depth);
            Some(PlacedSample { sample, ray_in_camera, depth, point_in_world })
        })
    }

    /// How many samples are not at infinity.
    #[must_use]
    pub fn placed_count(&self) -> u64 {
        self.inverse_depths().iter().filter(|depth| **depth > 0.0).count() as u64
    }
}

/// Whether cameras stand so far from the origin that world coordinates around them need double precision: single precision holds half a
/// meter in maps' coordinates.
#[must_use]
pub fn are_far_from_origin(cameras: &[Camera]) -> bool {
    cameras.iter().any(|camera| camera.position_in_world().abs().max_element() > NEAR)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::Intrinsics;
    use crate::samples::{DepthPlane, SampleTile, Span, TILE};
    use glam::DAffine3;
    use half::f16;

    fn camera(position: DVec3) -> Camera {
        let intrinsics = Intrinsics::from_horizontal_angle(40, 30, 0.9);
        Camera { name: "c".into(), intrinsics, world_from_camera: DAffine3::from_translation(position) }
    }

    #[test]
    fn samples_at_infinity_have_no_place_and_all_others_project_back_to_their_pixels() {
        let mut rows = [0; TILE];
        (rows[2], rows[9]) = (0b101, 0b1000);
        let tiles = vec![SampleTile { tile_x: 1, tile_y: 0, first: 0, rows }];
        let depth = DepthPlane::pack(&tiles, &[0.5, 0.0, 0.25]);
        let image = SampleImage {
            camera: 0,
            span: Span { start: 0, end: 1 },
            tiles,
            color: vec![[f16::ZERO; 3]; 3],
            depth,
            normal: None,
            doubtful: Vec::new(),
            values: crate::capture::Values::default(),
        };
        let camera = camera(DVec3::new(1.0, -2.0, 5.0));
        let placed: Vec<_> = image.placed(&camera).collect();
        assert_eq!(image.placed_count(), 2);
        assert_eq!(placed.iter().map(|placed| placed.sample.index).collect::<Vec<_>>(), [0, 2]);
        assert_eq!(placed.iter().map(|placed| placed.depth).collect::<Vec<_>>(), [2.0, 4.0]);
        for placed in placed {
            let (pixel, depth) = camera.project(placed.point_in_world).unwrap();
            let expected = DVec2::new(placed.sample.x as f64 + 0.5, placed.sample.y as f64 + 0.5);
            assert!((pixel - expected).length() < 1e-9 && (depth - placed.depth).abs() < 1e-12);
        }
    }

    #[test]
    fn a_camera_in_the_coordinates_of_a_map_is_far_from_the_origin() {
        assert!(!are_far_from_origin(&[camera(DVec3::splat(900.0))]));
        assert!(are_far_from_origin(&[camera(DVec3::ZERO), camera(DVec3::new(0.0, 5e6, 0.0))]));
    }
}
