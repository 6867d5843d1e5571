//! The way from one camera into another, and whether what is behind some of its pixels can be seen there.
//!
//! Purpose: pairs of cameras that cannot see the same are found by rectangles of pixels between two depths. Source: the planes of a
//! view frustum. What differs: all of it is linear in `(ray, w)`, where `w = 1/z`, so that depths reach to infinity.

use glam::{DVec2, Vec3};

use crate::capture::camera::Camera;

/// Carries samples of one camera into another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Registration {
    /// The ray of the source's first pixel, at depth 1, in the target's orientation, …
    pub(crate) first_ray: Vec3,
    /// … its growth from one column to the next, …
    pub(crate) per_column: Vec3,
    /// … and from one row to the next.
    pub(crate) per_row: Vec3,
    /// The source camera's axes and place in target camera space.
    pub(crate) axes: [Vec3; 3],
    pub(crate) translation: Vec3,
    /// Side of a source pixel held perpendicular to the optical axis at depth 1.
    pub(crate) source_side: f32,
    pub(crate) target: PinholeLens,
}

/// A pinhole camera's intrinsics as the loops need them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PinholeLens {
    pub(crate) focal: [f32; 2],
    pub(crate) center: [f32; 2],
    pub(crate) size: [f32; 2],
    /// Side of a pixel held perpendicular to the optical axis at depth 1.
    pub(crate) side: f32,
}

impl PinholeLens {
    fn new(camera: &Camera) -> Self {
        let k = camera.intrinsics;
        Self {
            focal: [k.fx as f32, k.fy as f32],
            center: [k.cx as f32, k.cy as f32],
            size: [k.width as f32, k.height as f32],
            side: (1.0 / (k.fx * k.fy).sqrt()) as f32,
        }
    }
}

impl Registration {
    /// Carries samples of `source` into `target`.
    pub(crate) fn new(source: &Camera, target: &Camera) -> Self {
        let k = source.intrinsics;
        let target_from_source = target.camera_from_world() * source.world_from_camera;
        let axes = target_from_source.matrix3;
        Self {
            first_ray: (axes * k.ray_in_camera(DVec2::splat(0.5))).as_vec3(),
            per_column: (axes.x_axis / k.fx).as_vec3(),
            per_row: (axes.y_axis / k.fy).as_vec3(),
            axes: [axes.x_axis.as_vec3(), axes.y_axis.as_vec3(), axes.z_axis.as_vec3()],
            translation: target_from_source.translation.as_vec3(),
            source_side: PinholeLens::new(source).side,
            target: PinholeLens::new(target),
        }
    }

    /// The corners of what is between two inverse depths (from 0) behind a rectangle of source pixels, given by its first and last
    /// columns and rows: points in target camera space, each times its inverse depth.
    fn corners(&self, columns: [usize; 2], rows: [usize; 2], inverse_depths: [f32; 2]) -> [Vec3; 8] {
        std::array::from_fn(|corner| {
            let [x, y] = [columns[corner & 1] as f32, rows[corner >> 1 & 1] as f32];
            self.first_ray
                + self.per_column * x
                + self.per_row * y
                + self.translation * inverse_depths[corner >> 2]
        })
    }

    /// Whether the target may see anything of what is between two inverse depths (from 0) behind a rectangle of source
    /// pixels, given by its first and last columns and rows. It may wrongly be true, never wrongly false.
    pub(crate) fn may_see(&self, columns: [usize; 2], rows: [usize; 2], inverse_depths: [f32; 2]) -> bool {
        let lens = &self.target;
        // A point is out of view where one of these is negative; they are linear, so it is enough to test the corners.
        let mut largest = [f32::NEG_INFINITY; 5];
        let mut depth = 0.0_f32;
        for q in self.corners(columns, rows, inverse_depths) {
            let [right, bottom] = [lens.size[0] - lens.center[0], lens.size[1] - lens.center[1]];
            let inside = [
                q.x * lens.focal[0] + lens.center[0] * q.z,
                q.y * lens.focal[1] + lens.center[1] * q.z,
                right * q.z - q.x * lens.focal[0],
                bottom * q.z - q.y * lens.focal[1],
                q.z,
            ];
            for (largest, inside) in largest.iter_mut().zip(inside) {
                *largest = largest.max(inside);
            }
            depth = depth.max(q.length());
        }
        // Rounding moves a point by far less than a tenth of a pixel.
        largest.iter().all(|largest| *largest >= -0.1 * depth)
    }
}
