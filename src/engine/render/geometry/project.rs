//! Projection (the paper, §3.3): from a sample's pixel and depth to its position in the vantage, incrementally along rows.
//!
//! Unprojecting `ray · z`, moving to the target camera and projecting is linear in `(ray, 1/z)` before the division:
//! `P = M·ray + o·w` with `w = 1/z`. `P.xy / P.z` is the position in target pixels and `w / P.z` the target's inverse
//! depth, for points at infinity (`w = 0`) as well. Along a row `M·ray` grows by a constant.
//!
//! Where the source is orthographic `P = (M·pixel + o)·w + a`, with `a` its z axis, and where the target is, positions are `P.xy / w`. The
//! target's inverse depth is `w / P.z` either way.
//!
//! Sums are not contracted (no fused multiply-add): every machine and every vector width gives the same bits.

use glam::{DMat3, DVec2, DVec3, Mat3, Vec3};

use crate::capture::{Camera, Projection, along_axis};
use crate::render::input::focal;
use crate::samples::TILE;

/// Carries pixels of one camera, with their inverse depths, into another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Projector {
    first_pixel: Vec3,
    /// Growth of `M·ray` from one column to the next.
    pub(crate) per_column: Vec3,
    /// Growth of `M·ray` from one row to the next.
    pub(crate) per_row: Vec3,
    /// The source camera's center in the target, before the division; of an orthographic source its z axis.
    pub(crate) origin: Vec3,
    /// Whether the source's lines of sight are parallel: `ray` is a pixel's place in its picture plane, which counts times `w`, and
    /// `origin` does not.
    pub(crate) source_is_orthographic: bool,
    /// Whether the target's lines of sight are parallel: positions are divided by `w`.
    pub(crate) target_is_orthographic: bool,
    /// Focal length of the target over that of the source: target pixels a source pixel covers, seen from equally far.
    pub(crate) focal_ratio: f32,
}

/// Sixteen pixels of a tile in the target.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ProjectedPixels {
    /// Target pixels, centers at +0.5; meaningless where `reciprocal` is not positive.
    pub(crate) u: [f32; TILE],
    /// See `u`.
    pub(crate) v: [f32; TILE],
    /// `1 / P.z`: not positive behind the target camera. Times the source's inverse depth it is the target's; for any
    /// depth it is the distance from the source over that from the target.
    pub(crate) reciprocal: [f32; TILE],
}

/// World-space ray, the same for all pixels of an orthographic camera, of the point `(first, first)` of a picture, and its growth by column and row.
pub(crate) fn rays_in_world(camera: &Camera, first: f64) -> [Vec3; 3] {
    let ray = |x, y| {
        let at = DVec2::new(first + x, first + y);
        camera.world_from_camera.matrix3 * camera.intrinsics.ray_in_camera(at)
    };
    let start = ray(0.0, 0.0);
    [start, ray(1.0, 0.0) - start, ray(0.0, 1.0) - start].map(DVec3::as_vec3)
}

/// What growth of inverse depths in a picture tells of an offset `o` in world space: `N·o`, where the plane `N·P = 1` around the camera
/// has inverse depths that grow by 1 a column (`x`), by 1 a row (`y`), or are 1 (`z`) at the first pixel. `rays` are those of
/// [`rays_in_world`].
pub(crate) fn growth_along(rays: [Vec3; 3], offset_in_world: Vec3) -> Vec3 {
    let [first, across, down] = rays;
    // The inverse depth is N·ray.
    Mat3::from_cols(across, down, first).inverse() * offset_in_world
}

impl Projector {
    pub(crate) fn new(source: &Camera, target: &Camera) -> Self {
        let k = target.intrinsics;
        let image_from_camera = DMat3::from_cols(
            DVec3::new(k.fx, 0.0, 0.0),
            DVec3::new(0.0, k.fy, 0.0),
            DVec3::new(k.cx, k.cy, 1.0),
        );
        let target_from_source = target.camera_from_world() * source.world_from_camera;
        let image_from_source = image_from_camera * target_from_source.matrix3;
        let s = source.intrinsics;
        if s.is_orthographic() || k.is_orthographic() {
            return Self::of_orthographic(source, target);
        }
        Self {
            first_pixel: (image_from_source * s.ray_in_camera(DVec2::splat(0.5))).as_vec3(),
            per_column: (image_from_source.x_axis / s.fx).as_vec3(),
            per_row: (image_from_source.y_axis / s.fy).as_vec3(),
            origin: (image_from_camera * target_from_source.translation).as_vec3(),
            focal_ratio: focal(target) / focal(source),
            source_is_orthographic: false,
            target_is_orthographic: false,
        }
    }

    fn of_orthographic(source: &Camera, target: &Camera) -> Self {
        let (s, k) = (source.intrinsics, target.intrinsics);
        let target_from_source = target.camera_from_world() * source.world_from_camera;
        // The image center comes with what positions are divided by.
        let center = DVec3::new(k.cx, k.cy, 0.0);
        let (in_depth, in_plane) =
            if k.is_orthographic() { (DVec3::ZERO, center) } else { (center, DVec3::ZERO) };
        let image_from_camera = DMat3::from_diagonal(DVec3::new(k.fx, k.fy, 1.0));
        let image = |vector: DVec3| image_from_camera * vector + in_depth * vector.z;
        let axes = target_from_source.matrix3;
        let first = s.point_in_camera(DVec2::splat(0.5), 1.0);
        let (first_pixel, origin) = match s.projection {
            Projection::Perspective => {
                (image(axes * first), image(target_from_source.translation) + in_plane)
            }
            Projection::Orthographic => {
                let place = target_from_source.transform_point3(first.with_z(0.0));
                (image(place) + in_plane, image(along_axis(axes.z_axis)))
            }
        };
        Self {
            first_pixel: first_pixel.as_vec3(),
            per_column: image(axes.x_axis / s.fx).as_vec3(),
            per_row: image(axes.y_axis / s.fy).as_vec3(),
            origin: origin.as_vec3(),
            focal_ratio: focal(target) / focal(source),
            source_is_orthographic: s.is_orthographic(),
            target_is_orthographic: k.is_orthographic(),
        }
    }

    /// Whether either camera is orthographic.
    #[inline(always)]
    pub(crate) fn has_orthographic(&self) -> bool {
        self.source_is_orthographic | self.target_is_orthographic
    }

    /// The target's position of a [`Projector::point`] at inverse depth `w`; no number, or infinite, where there is none.
    #[inline(always)]
    pub(crate) fn position(&self, point: Vec3, w: f32) -> [f32; 2] {
        let divisor = if self.target_is_orthographic { w } else { point.z };
        if w == 0.0 && self.source_is_orthographic && self.target_is_orthographic {
            return [f32::NAN; 2];
        }
        [point.x / divisor, point.y / divisor]
    }

    /// Target pixels along a source pixel at inverse depth `w` whose [`ProjectedPixels::reciprocal`] is this.
    #[inline(always)]
    pub(crate) fn magnification(&self, w: f32, reciprocal: f32) -> f32 {
        self.focal_ratio * self.distance_ratio(w, reciprocal)
    }

    /// The factor of [`Projector::magnification`] that depends on depths: the distance from the source over that from the target, each 1
    /// where it is orthographic.
    #[inline(always)]
    pub(crate) fn distance_ratio(&self, w: f32, reciprocal: f32) -> f32 {
        match (self.source_is_orthographic, self.target_is_orthographic) {
            (false, false) => reciprocal,
            (true, false) => w * reciprocal,
            (false, true) => w.recip(),
            (true, true) => 1.0,
        }
    }

    /// `M·ray` of the center of pixel `(x, y)`, which need not be a whole number.
    #[inline(always)]
    pub(crate) fn ray(&self, x: f32, y: f32) -> Vec3 {
        self.first_pixel + self.per_column * x + self.per_row * y
    }

    /// `P = M·ray + o·w` of the center of pixel `(x, y)` at inverse depth `w`, for a source in perspective, as every vantage is.
    #[inline(always)]
    pub(crate) fn point(&self, x: f32, y: f32, w: f32) -> Vec3 {
        self.ray(x, y) + self.origin * w
    }

    /// `P` for any source.
    #[inline(always)]
    pub(crate) fn point_of_any(&self, x: f32, y: f32, w: f32) -> Vec3 {
        self.carried(self.ray(x, y), w)
    }

    /// `P` of a source of any kind, of a [`Projector::ray`].
    #[inline(always)]
    fn carried(&self, ray: Vec3, w: f32) -> Vec3 {
        if self.source_is_orthographic { ray * w + self.origin } else { ray + self.origin * w }
    }

    /// Sixteen pixels of a row from `ray` on, with their inverse depths.
    #[inline(always)]
    pub(crate) fn row(&self, ray: Vec3, inverse_depth: &[f32; TILE]) -> ProjectedPixels {
        self.pixels(&[[ray.x; TILE], [ray.y; TILE], [ray.z; TILE]], &FIRST_COLUMNS, inverse_depth)
    }

    /// Sixteen pixels with their inverse depths, each some columns to the right of the one that a ray is of: the rays' `x`, `y` and `z`.
    #[inline(always)]
    pub(crate) fn pixels(
        &self,
        rays: &[[f32; TILE]; 3],
        columns: &[f32; TILE],
        inverse_depth: &[f32; TILE],
    ) -> ProjectedPixels {
        if self.has_orthographic() {
            return self.pixels_of_orthographic(rays, columns, inverse_depth);
        }
        let mut pixels = ProjectedPixels { u: [0.0; TILE], v: [0.0; TILE], reciprocal: [0.0; TILE] };
        for i in 0..TILE {
            let (along, w) = (columns[i], inverse_depth[i]);
            let x = rays[0][i] + self.per_column.x * along + self.origin.x * w;
            let y = rays[1][i] + self.per_column.y * along + self.origin.y * w;
            let z = rays[2][i] + self.per_column.z * along + self.origin.z * w;
            let reciprocal = 1.0 / z;
            pixels.u[i] = x * reciprocal;
            pixels.v[i] = y * reciprocal;
            pixels.reciprocal[i] = reciprocal;
        }
        pixels
    }

    /// The same where one of the cameras is orthographic. Apart, so that what is between cameras in perspective stays as fast as it is.
    #[cold]
    #[inline(never)]
    fn pixels_of_orthographic(
        &self,
        rays: &[[f32; TILE]; 3],
        columns: &[f32; TILE],
        inverse_depth: &[f32; TILE],
    ) -> ProjectedPixels {
        let mut pixels = ProjectedPixels { u: [0.0; TILE], v: [0.0; TILE], reciprocal: [0.0; TILE] };
        for (i, &w) in inverse_depth.iter().enumerate() {
            let ray = Vec3::new(rays[0][i], rays[1][i], rays[2][i]) + self.per_column * columns[i];
            let point = self.carried(ray, w);
            let [u, v] = match (self.source_is_orthographic, self.target_is_orthographic) {
                // At infinity what both see along one direction stays where it is.
                (true, true) => [0, 1].map(|axis| {
                    let shift = self.origin[axis];
                    ray[axis] + if shift == 0.0 { 0.0 } else { shift / w }
                }),
                _ => self.position(point, w),
            };
            (pixels.u[i], pixels.v[i]) = (u, v);
            pixels.reciprocal[i] = point.z.recip();
        }
        pixels
    }
}

/// The columns of a row, as numbers.
const FIRST_COLUMNS: [f32; TILE] =
    [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::Intrinsics;

    #[test]
    fn projecting_agrees_with_unprojecting_and_projecting_whichever_camera_is_orthographic() {
        let lenses = [
            Intrinsics { cx: 30.25, ..Intrinsics::orthographic(64, 48, 4.0) },
            Intrinsics::from_horizontal_angle(80, 60, 0.7),
        ];
        for (from, to) in [(0, 1), (1, 0), (0, 0)] {
            let source =
                Camera::look_at("a", lenses[from], DVec3::new(1.0, -4.0, 2.0), DVec3::ZERO, DVec3::Z);
            let target = Camera::look_at("b", lenses[to], DVec3::new(-2.0, -3.0, 1.0), DVec3::X, DVec3::Z);
            let projector = Projector::new(&source, &target);
            for y in 0..48 {
                let depths: [f32; TILE] = std::array::from_fn(|i| 1.0 / (3.0 + 0.01 * (i + y) as f32));
                let row = projector.row(projector.ray(16.0, y as f32), &depths);
                for (column, w) in depths.iter().enumerate() {
                    let z = f64::from(*w).recip();
                    let center = DVec2::new(16.5 + column as f64, 0.5 + y as f64);
                    let beside = target.project(source.unproject(center + DVec2::X, z)).unwrap().0;
                    let (pixel, found_z) = target.project(source.unproject(center, z)).unwrap();
                    assert!((pixel - DVec2::new(row.u[column].into(), row.v[column].into())).length() < 1e-3);
                    assert!((found_z as f32 * w * row.reciprocal[column] - 1.0).abs() < 1e-5);
                    let magnification = projector.magnification(*w, row.reciprocal[column]);
                    assert!(((beside - pixel).length() as f32) < 1.3 * magnification);
                }
            }
        }
    }

    #[test]
    fn what_an_orthographic_camera_sees_at_infinity_stays_in_its_pixel() {
        let lens = Intrinsics::orthographic(64, 48, 4.0);
        let camera = Camera::look_at("a", lens, DVec3::new(1.0, -4.0, 2.0), DVec3::ZERO, DVec3::Z);
        let projector = Projector::new(&camera, &camera);
        let row = projector.row(projector.ray(16.0, 7.0), &[0.0; TILE]);
        for column in 0..TILE {
            assert!(
                (row.u[column] - (16.5 + column as f32)).abs() < 1e-4 && (row.v[column] - 7.5).abs() < 1e-4
            );
            assert!(row.reciprocal[column] > 0.0);
        }
    }

    #[test]
    fn projecting_along_rows_agrees_with_unprojecting_and_projecting() {
        let source = Camera::look_at(
            "a",
            Intrinsics::from_horizontal_angle(64, 48, 0.9),
            DVec3::new(1.0, -4.0, 2.0),
            DVec3::ZERO,
            DVec3::Z,
        );
        let target = Camera::look_at(
            "b",
            Intrinsics::from_horizontal_angle(80, 60, 0.7),
            DVec3::new(-2.0, -3.0, 1.0),
            DVec3::ZERO,
            DVec3::Z,
        );
        let projector = Projector::new(&source, &target);
        for y in 0..48 {
            let depths: [f32; TILE] = std::array::from_fn(|i| 1.0 / (3.0 + 0.01 * (i + y) as f32));
            let row = projector.row(projector.ray(16.0, y as f32), &depths);
            for (column, depth) in depths.iter().enumerate() {
                let z = f64::from(*depth).recip();
                let center = DVec2::new(16.5 + column as f64, 0.5 + y as f64);
                let (pixel, found_z) = target.project(source.unproject(center, z)).unwrap();
                assert!((pixel.x as f32 - row.u[column]).abs() < 1e-3);
                assert!((pixel.y as f32 - row.v[column]).abs() < 1e-3);
                assert!((found_z as f32 * depth * row.reciprocal[column] - 1.0).abs() < 1e-5);
            }
        }
    }
}
