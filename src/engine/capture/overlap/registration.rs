//! The way from one camera into another, and whether what is behind some of its pixels can be seen there.
//!
//! Purpose: pairs of cameras that cannot see the same are found by rectangles of pixels between two depths. Source: the planes of a
//! view frustum. What differs: all of it is linear in `(ray, w)`, where `w = 1/z`, so that depths reach to infinity.
//!
//! ```text
//! q = M·ray + t·w          source in perspective: M·ray is the point at depth 1, t the source's place
//! q = (M·pixel + t)·w + a  orthographic source: M·pixel + t is the pixel's place in its picture plane, a the source's z axis
//! pixel = q.xy / q.z       target in perspective
//! pixel = q.xy / w         orthographic target
//! ```
//!
//! Either way `q` is the point in the target camera times `w`, so that all that follows is the same for both.

use glam::{DVec2, Vec3};

use crate::capture::camera::{Camera, Projection, along_axis};

/// Carries samples of one camera into another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Registration {
    /// The ray of the source's first pixel, at depth 1, in the target's orientation; of an orthographic source the pixel's place in the
    /// picture plane, in target camera space. …
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
    /// Whether the source's lines of sight are parallel.
    pub(crate) source_is_orthographic: bool,
    pub(crate) target: TargetLens,
}

/// A camera's intrinsics as the loops need them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TargetLens {
    pub(crate) focal: [f32; 2],
    pub(crate) center: [f32; 2],
    pub(crate) size: [f32; 2],
    /// Side of a pixel held perpendicular to the optical axis at depth 1.
    pub(crate) side: f32,
    /// Whether its lines of sight are parallel.
    pub(crate) is_orthographic: bool,
}

/// The side of a pixel at an inverse depth over that depth; `side` is that at depth 1, where an orthographic camera has the same at any
/// depth.
#[inline(always)]
pub(crate) fn relative_side(side: f32, is_orthographic: bool, inverse_depth: f32) -> f32 {
    if is_orthographic { side * inverse_depth } else { side }
}

impl TargetLens {
    /// Side of a pixel at an inverse depth over that depth.
    #[inline(always)]
    pub(crate) fn relative_side(&self, inverse_depth: f32) -> f32 {
        relative_side(self.side, self.is_orthographic, inverse_depth)
    }

    fn new(camera: &Camera) -> Self {
        let k = camera.intrinsics;
        Self {
            focal: [k.fx as f32, k.fy as f32],
            center: [k.cx as f32, k.cy as f32],
            size: [k.width as f32, k.height as f32],
            side: (1.0 / (k.fx * k.fy).sqrt()) as f32,
            is_orthographic: k.is_orthographic(),
        }
    }
}

impl Registration {
    /// Carries samples of `source` into `target`.
    pub(crate) fn new(source: &Camera, target: &Camera) -> Self {
        let k = source.intrinsics;
        let target_from_source = target.camera_from_world() * source.world_from_camera;
        let mut axes = target_from_source.matrix3;
        if k.is_orthographic() && target.intrinsics.is_orthographic() {
            // What both see along one direction stays where it is, to infinity.
            axes.z_axis = along_axis(axes.z_axis);
        }
        let first = k.point_in_camera(DVec2::splat(0.5), 1.0);
        let first_ray = match k.projection {
            Projection::Perspective => axes * first,
            Projection::Orthographic => target_from_source.transform_point3(first.with_z(0.0)),
        };
        Self {
            first_ray: first_ray.as_vec3(),
            per_column: (axes.x_axis / k.fx).as_vec3(),
            per_row: (axes.y_axis / k.fy).as_vec3(),
            axes: [axes.x_axis.as_vec3(), axes.y_axis.as_vec3(), axes.z_axis.as_vec3()],
            translation: target_from_source.translation.as_vec3(),
            source_side: TargetLens::new(source).side,
            source_is_orthographic: k.is_orthographic(),
            target: TargetLens::new(target),
        }
    }

    /// Whether the lines of sight of either camera are parallel.
    #[inline(always)]
    pub(crate) fn has_orthographic(&self) -> bool {
        self.source_is_orthographic | self.target.is_orthographic
    }

    /// Side of a source pixel at an inverse depth over that depth.
    #[inline(always)]
    pub(crate) fn relative_source_side(&self, inverse_depth: f32) -> f32 {
        relative_side(self.source_side, self.source_is_orthographic, inverse_depth)
    }

    /// The larger footprint of the source's sample at inverse depth `w` and of the target's at `there`, times both.
    #[inline(always)]
    pub(crate) fn larger_footprint(&self, w: f32, there: f32) -> f32 {
        (self.relative_source_side(w) * there).max(self.target.relative_side(there) * w)
    }

    /// The size of the target's pixel over the source's, at a point of inverse depth `w` in the source and depth `depth / w` in the target.
    #[inline(always)]
    pub(crate) fn coarseness(&self, w: f32, depth: f32) -> f32 {
        let (target, source) = (&self.target, self.source_side);
        match (target.is_orthographic, self.source_is_orthographic) {
            (false, false) => target.side * depth / source,
            (true, false) => target.side * w / source,
            (false, true) => target.side * (depth / w) / source,
            (true, true) => target.side / source,
        }
    }

    /// A point of the source times its inverse depth `w`, in target camera space: of a pixel that is `along` columns from the first of
    /// `row`, as [`Registration::first_ray`] with its growth by rows.
    #[inline(always)]
    pub(crate) fn point(&self, row: Vec3, along: f32, w: f32) -> Vec3 {
        self.carried(row + self.per_column * along, w)
    }

    /// A point of the source times its inverse depth `w`, in target camera space, of a pixel that lies at `ray`, as
    /// [`Registration::first_ray`].
    #[inline(always)]
    fn carried(&self, ray: Vec3, w: f32) -> Vec3 {
        if self.source_is_orthographic { ray * w + self.axes[2] } else { ray + self.translation * w }
    }

    /// The corners of what is between two inverse depths (from 0) behind a rectangle of source pixels, given by its first and last
    /// columns and rows: points in target camera space, each times its inverse depth.
    fn corners(&self, columns: [usize; 2], rows: [usize; 2], inverse_depths: [f32; 2]) -> [Vec3; 8] {
        std::array::from_fn(|corner| {
            let [x, y] = [columns[corner & 1] as f32, rows[corner >> 1 & 1] as f32];
            let ray = self.first_ray + self.per_column * x + self.per_row * y;
            self.carried(ray, inverse_depths[corner >> 2])
        })
    }

    /// Whether the target may see anything of what is between two inverse depths (from 0) behind a rectangle of source
    /// pixels, given by its first and last columns and rows. It may wrongly be true, never wrongly false.
    pub(crate) fn may_see(&self, columns: [usize; 2], rows: [usize; 2], inverse_depths: [f32; 2]) -> bool {
        let lens = &self.target;
        // A point is out of view where one of these is negative; they are linear, so it is enough to test the corners.
        let mut largest = [f32::NEG_INFINITY; 5];
        let mut depth = 0.0_f32;
        let corners = self.corners(columns, rows, inverse_depths);
        for (nth, q) in corners.into_iter().enumerate() {
            // What positions are divided by.
            let divisor = if lens.is_orthographic { inverse_depths[nth >> 2] } else { q.z };
            let [right, bottom] = [lens.size[0] - lens.center[0], lens.size[1] - lens.center[1]];
            let inside = [
                q.x * lens.focal[0] + lens.center[0] * divisor,
                q.y * lens.focal[1] + lens.center[1] * divisor,
                right * divisor - q.x * lens.focal[0],
                bottom * divisor - q.y * lens.focal[1],
                q.z,
            ];
            for (largest, inside) in largest.iter_mut().zip(inside) {
                *largest = largest.max(inside);
            }
            depth = depth.max(q.length());
        }
        // Rounding moves a point by far less than a tenth of a pixel.
        // Of an orthographic target it is a tenth of a pixel times the largest inverse depth.
        let slack = if lens.is_orthographic { inverse_depths[1].max(inverse_depths[0]) } else { depth };
        largest.iter().all(|largest| *largest >= -0.1 * slack)
    }
}
