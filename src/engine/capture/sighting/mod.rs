//! What a camera sees of a point that another one saw.
//!
//! Purpose: the one place where a point is carried into a picture and its depth is compared with what the picture has there. For runs
//! of samples in vectors, see [`crate::preprocess::registration`]. Source: none; a projection and a ratio.

pub mod tolerances;

use glam::{DVec2, DVec3};

use super::camera::{Camera, Intrinsics};
use crate::grid::Grid;

/// What a camera sees where a point is expected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sighting {
    /// The point is behind the camera or beside its picture.
    Outside,
    /// The picture has no depth there, or it is at infinity.
    NoDepth,
    /// Something nearer, which hides the point.
    Nearer,
    /// The surface of the point.
    Same,
    /// Something farther: the point would have been seen.
    Farther,
}

/// Where a point lies in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landing {
    /// Column and row, within the picture.
    pub pixel: (usize, usize),
    /// Position in the image, pixels.
    pub position: DVec2,
    /// Planar depth of the point in the camera, above 0.
    pub depth: f64,
    /// The length that tolerances are shares of, where that is not the depth found: see [`Intrinsics::depth_scale`].
    pub scale: Option<f64>,
}

impl Landing {
    /// A point in world space in the picture of a camera, of `size` pixels; `None` behind the camera and beside the picture.
    #[must_use]
    pub fn of(point_in_world: DVec3, camera: &Camera, size: (usize, usize)) -> Option<Self> {
        let (position, depth) = camera.project(point_in_world)?;
        Self::at(&camera.intrinsics, position, depth, size)
    }

    /// A point in camera space in a picture of `size` pixels behind a lens; `None` behind the camera and beside the picture.
    #[must_use]
    pub fn through(lens: &Intrinsics, point_in_camera: DVec3, size: (usize, usize)) -> Option<Self> {
        Self::at(lens, lens.project(point_in_camera)?, point_in_camera.z, size)
    }

    /// An image position and a planar depth in a picture of `size` pixels behind a lens; `None` beside the picture.
    #[must_use]
    pub fn at(lens: &Intrinsics, position: DVec2, depth: f64, size: (usize, usize)) -> Option<Self> {
        let is_inside = position.x >= 0.0
            && position.y >= 0.0
            && position.x < size.0 as f64
            && position.y < size.1 as f64;
        let pixel = (position.x as usize, position.y as usize);
        let scale = lens.is_orthographic().then(|| lens.depth_scale(depth));
        is_inside.then_some(Self { pixel, position, depth, scale })
    }

    /// What is seen where the picture has an inverse depth: 0 is at infinity, negative is none.
    #[must_use]
    pub fn compare(&self, inverse_depth: f32, tolerance: f64) -> Sighting {
        let Some(scale) = self.scale.filter(|_| inverse_depth > 0.0) else {
            return compare(inverse_depth, self.depth, tolerance);
        };
        let farther = f64::from(inverse_depth).recip() - self.depth;
        if farther.abs() < tolerance * scale {
            Sighting::Same
        } else if farther < 0.0 {
            Sighting::Nearer
        } else {
            Sighting::Farther
        }
    }
}

/// What is seen of a point at the planar depth `depth` where the picture has an inverse depth. Depths of one surface are less than
/// `tolerance` apart, a share of the one that was found.
#[must_use]
pub fn compare(inverse_depth: f32, depth: f64, tolerance: f64) -> Sighting {
    if inverse_depth <= 0.0 {
        return Sighting::NoDepth;
    }
    let ratio = f64::from(inverse_depth) * depth;
    if (ratio - 1.0).abs() < tolerance {
        Sighting::Same
    } else if ratio > 1.0 {
        Sighting::Nearer
    } else {
        Sighting::Farther
    }
}

/// What a camera with these inverse depths sees of a point in world space.
#[must_use]
pub fn look(camera: &Camera, inverse_depth: &Grid<f32>, point_in_world: DVec3, tolerance: f64) -> Sighting {
    let landing = Landing::of(point_in_world, camera, inverse_depth.size());
    landing.map_or(Sighting::Outside, |at| at.compare(inverse_depth[at.pixel], tolerance))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A camera at the origin that looks along z, with a wall at a depth of 2.
    fn wall() -> (Camera, Grid<f32>) {
        let intrinsics = Intrinsics::from_horizontal_angle(8, 6, 1.0);
        let camera = Camera { name: "c".into(), intrinsics, world_from_camera: glam::DAffine3::IDENTITY };
        (camera, Grid::from_fn(8, 6, |x, _| if x == 0 { -1.0 } else { 0.5 }))
    }

    #[test]
    fn tolerances_of_an_orthographic_camera_are_shares_of_the_width_of_its_picture() {
        let intrinsics = Intrinsics::orthographic(8, 6, 2.0);
        let camera = Camera { name: "c".into(), intrinsics, world_from_camera: glam::DAffine3::IDENTITY };
        for depth in [0.5, 800.0] {
            let wall = Grid::filled(8, 6, (1.0 / depth) as f32);
            let seen = |z: f64| look(&camera, &wall, DVec3::new(0.2, 0.1, z), 0.01);
            assert_eq!(seen(depth + 0.015), Sighting::Same, "{depth}");
            assert_eq!(seen(depth + 0.03), Sighting::Nearer, "{depth}");
            assert_eq!(seen(depth - 0.03), Sighting::Farther, "{depth}");
        }
    }

    #[test]
    fn a_point_is_nearer_than_a_wall_on_it_or_behind_it() {
        let (camera, wall) = wall();
        let seen = |x: f64, z: f64| look(&camera, &wall, DVec3::new(x, 0.0, z), 0.01);
        assert_eq!(seen(0.0, 2.01), Sighting::Same);
        assert_eq!(seen(0.0, 1.5), Sighting::Farther);
        assert_eq!(seen(0.0, 2.5), Sighting::Nearer);
        assert_eq!(seen(0.0, -2.0), Sighting::Outside);
        assert_eq!(seen(9.0, 2.0), Sighting::Outside);
        let left = camera.unproject(DVec2::new(0.5, 3.0), 2.0);
        assert_eq!(look(&camera, &wall, left, 0.01), Sighting::NoDepth);
    }
}
