//! The cameras that colors are gathered from, and how much each counts for a surface point.

use glam::Vec3;

use crate::capture::{Camera, Projection};
use crate::render::geometry::{Projector, growth_along, rays_in_world};
use crate::render::input::RelativeWidth;
use crate::render::input::{CellTable, FrameSamples, LaneValues, Lookup};
use crate::settings::RenderSettings;
use crate::simd::LANES;

/// A higher sampling rate than this many times the vantage's gains nothing: the picture cannot show more.
const USEFUL_RATE: f32 = 1.5;

/// Cosines of incidence that differ by more than this factor count as differing by it.
const MOST_SLANTED: f32 = 0.02;

/// A camera that covers all but this share of a pixel counts as one that covers it.
const UNCOVERED: f32 = 0.01;

/// No further camera is read once this many pixels' worth of samples are found; the best come first. In a set that was not
/// pruned several cameras average noise and aliasing; pruning leaves one per surface, and reading a second finds little.
pub(crate) fn full_coverage(pruned: bool, settings: &RenderSettings) -> f32 {
    if pruned { 1.0 - UNCOVERED } else { settings.views as f32 - UNCOVERED }
}

/// A camera and its position relative to the vantage.
pub(super) struct SourceView {
    pub(super) camera: usize,
    pub(super) source_from_target: Projector,
    pub(super) target_from_source: Projector,
    /// From the camera's center to the vantage's, in world space; of an orthographic camera its direction of view.
    offset_in_world: Vec3,
    /// What growth of the inverse depth tells of `offset_in_world`: see [`growth_along`].
    growth_along_offset: Vec3,
    /// Inverse depths that differ by no more than this share belong to one surface.
    pub(super) tolerance: RelativeWidth,
}

impl SourceView {
    /// Whether the camera's lines of sight are parallel.
    #[inline(always)]
    pub(super) fn is_orthographic(&self) -> bool {
        self.source_from_target.target_is_orthographic
    }
}

/// Surface points sixteen at a time: columns and rows of their pixels and inverse depths, in the vantage.
#[derive(Clone, Copy)]
pub(super) struct TargetPoints {
    pub(super) x: LaneValues,
    pub(super) y: LaneValues,
    pub(super) w: LaneValues,
}

/// The cameras of a frame as the vantage sees them, and their samples.
pub(crate) struct SourceViews<'a> {
    pub(super) lookup: Lookup<'a>,
    pub(super) views: Vec<SourceView>,
    /// Whether samples that others represent were dropped.
    pub(super) pruned: bool,
    /// As the function of this name gives it.
    pub(super) full_coverage: f32,
    /// Pixels of the z-buffer along each side of a pixel of the picture, for whose size rates are measured.
    pub(super) subpixels: f32,
    /// World-space ray of the first pixel's center, and its growth by column and row.
    rays_in_world: [Vec3; 3],
}

impl<'a> SourceViews<'a> {
    /// Over the tiles of a table, with `subpixels` of the target along each side of a pixel of the picture.
    pub(crate) fn new(
        frame: &'a FrameSamples<'a>,
        table: CellTable,
        target: &Camera,
        settings: &RenderSettings,
        subpixels: usize,
    ) -> Self {
        let center = target.position_in_world();
        let rays_in_world = rays_in_world(target, 0.5);
        let view = |(camera, source): (usize, &Camera)| {
            let offset_in_world = match source.intrinsics.projection {
                Projection::Perspective => center - source.position_in_world(),
                Projection::Orthographic => source.forward_in_world(),
            };
            let offset_in_world = offset_in_world.as_vec3();
            SourceView {
                camera,
                source_from_target: Projector::new(target, source),
                target_from_source: Projector::new(source, target),
                offset_in_world,
                growth_along_offset: growth_along(rays_in_world, offset_in_world),
                tolerance: RelativeWidth::of(settings.depth_tolerance, source),
            }
        };
        let pruned = frame.is_pruned();
        Self {
            pruned,
            full_coverage: full_coverage(pruned, settings),
            lookup: Lookup { table, frame },
            views: frame.set.cameras.iter().enumerate().map(view).collect(),
            subpixels: subpixels as f32,
            rays_in_world,
        }
    }

    /// Recorded pixels of a camera along a pixel of the picture, for a point at a ratio of distances as in [`ReprojectedPoints`].
    ///
    /// [`ReprojectedPoints`]: crate::render::gather::visibility_votes::ReprojectedPoints
    #[inline(always)]
    pub(super) fn rate(&self, view: &SourceView, distance_ratio: f32) -> f32 {
        view.source_from_target.focal_ratio * distance_ratio * self.subpixels
    }

    /// Sorts cameras by their weight for the surface at inverse depth `w` in pixel `(x, y)`, which grows by `slope` a column and a row,
    /// largest first.
    #[inline(always)]
    pub(super) fn rank(
        &self,
        (x, y): (f32, f32),
        w: f32,
        slope: [f32; 2],
        cameras: &mut [u16],
        weights: &mut Vec<(f32, u16)>,
    ) {
        weights.clear();
        weights.extend(cameras.iter().map(|&camera| {
            let view = &self.views[camera as usize];
            let point = view.source_from_target.point(x, y, w);
            let weight = if point.z > 0.0 {
                let ratio = if view.is_orthographic() { w.recip() } else { 1.0 / point.z };
                self.weight_on_surface(view, ratio, (x, y), w, slope)
            } else {
                0.0
            };
            (weight, camera)
        }));
        weights.sort_by(|a, b| b.0.total_cmp(&a.0));
        cameras.iter_mut().zip(weights).for_each(|(camera, (_, ranked))| *camera = *ranked);
    }

    /// Whether what a camera recorded is coarser than a number of pixels of the z-buffer at the surface at inverse depth `w` in pixel
    /// `(x, y)`, or that lies behind the camera.
    #[inline(always)]
    pub(super) fn is_coarser(&self, camera: u16, (x, y): (f32, f32), w: f32, pixels: f32) -> bool {
        let view = &self.views[camera as usize];
        let point = view.source_from_target.point(x, y, w);
        let ratio = if view.is_orthographic() { w.recip() } else { point.z.recip() };
        point.z <= 0.0 || self.rate(view, ratio) * pixels < self.subpixels
    }

    /// The pixel of a camera that shows the surface at inverse depth `w` in pixel `(x, y)`; it may be outside the camera's
    /// picture. `None` behind the camera.
    #[inline(always)]
    pub(super) fn pixel_in(&self, camera: u16, (x, y): (f32, f32), w: f32) -> Option<(i32, i32)> {
        let point = self.views[camera as usize].source_from_target.point(x, y, w);
        let divisor = if self.views[camera as usize].is_orthographic() { w } else { point.z };
        let (u, v) = (point.x / divisor, point.y / divisor);
        (point.z > 0.0 && u.abs().max(v.abs()) < 1e6).then_some((u as i32, v as i32))
    }

    /// The weights of a camera for sixteen points beside steps in depth, where no slope is known. Distances are given as in
    /// [`ReprojectedPoints`].
    ///
    /// [`ReprojectedPoints`]: crate::render::gather::visibility_votes::ReprojectedPoints
    #[inline(always)]
    pub(super) fn weights(
        &self,
        view: &SourceView,
        distance_ratio: &LaneValues,
        points: &TargetPoints,
    ) -> LaneValues {
        let mut weights = [0.0; LANES];
        if view.is_orthographic() {
            return self.weights_of_orthographic(view, distance_ratio, points, None);
        }
        for i in 0..LANES {
            weights[i] = self.weight(view, distance_ratio[i], (points.x[i], points.y[i]), points.w[i]);
        }
        weights
    }

    /// The same on surfaces of known slopes.
    #[inline(always)]
    pub(super) fn weights_on_surface(
        &self,
        view: &SourceView,
        distance_ratio: &LaneValues,
        points: &TargetPoints,
        slopes: &[LaneValues; 2],
    ) -> LaneValues {
        let mut weights = [0.0; LANES];
        if view.is_orthographic() {
            return self.weights_of_orthographic(view, distance_ratio, points, Some(slopes));
        }
        for i in 0..LANES {
            let (at, slope) = ((points.x[i], points.y[i]), [slopes[0][i], slopes[1][i]]);
            weights[i] = self.weight_on_surface(view, distance_ratio[i], at, points.w[i], slope);
        }
        weights
    }

    /// [`SourceViews::weights_on_surface`] of an orthographic camera, or [`SourceViews::weights`] where no slopes are given.
    #[cold]
    #[inline(never)]
    fn weights_of_orthographic(
        &self,
        view: &SourceView,
        distance_ratio: &LaneValues,
        points: &TargetPoints,
        slopes: Option<&[LaneValues; 2]>,
    ) -> LaneValues {
        std::array::from_fn(|i| {
            let (ratio, at, w) = (distance_ratio[i], (points.x[i], points.y[i]), points.w[i]);
            match slopes {
                Some(slopes) => self.weight_on_surface(view, ratio, at, w, slopes.map(|slopes| slopes[i])),
                None => self.weight(view, ratio, at, w),
            }
        })
    }

    /// The cosine between the lines of sight of the vantage and of a camera to the surface at inverse depth `w` in pixel `(x, y)`, and
    /// the squared lengths of both.
    #[inline(always)]
    fn sights(&self, view: &SourceView, (x, y): (f32, f32), w: f32) -> (f32, [f32; 2]) {
        let [first, across, down] = self.rays_in_world;
        let ray = first + across * x + down * y;
        let sight =
            if view.is_orthographic() { view.offset_in_world } else { ray + view.offset_in_world * w };
        let squared = [ray.length_squared(), sight.length_squared()];
        (ray.dot(sight) / (squared[0] * squared[1]).sqrt(), squared)
    }

    /// The weight of a camera where nothing is known of the surface's slope: the squared sampling rate, up to [`USEFUL_RATE`], times the
    /// cosine between its line of sight and the vantage's.
    #[inline(always)]
    fn weight(&self, view: &SourceView, distance_ratio: f32, at: (f32, f32), w: f32) -> f32 {
        let (cosine, _) = self.sights(view, at, w);
        let rate = self.rate(view, distance_ratio).min(USEFUL_RATE);
        rate * rate * cosine.max(0.01)
    }

    /// The weight of a camera for a surface whose inverse depth grows by `slope` a column and a row: the cubed sampling rate on the
    /// surface, else as [`SourceViews::weight`]. Among the powers 2, 3 and 4, 3 loses least: textures gain by more, edges by less.
    #[inline(always)]
    fn weight_on_surface(
        &self,
        view: &SourceView,
        distance_ratio: f32,
        (x, y): (f32, f32),
        w: f32,
        slope: [f32; 2],
    ) -> f32 {
        let (cosine, [ray_squared, sight_squared]) = self.sights(view, (x, y), w);
        // The cosine of incidence over the vantage's.
        let growth = Vec3::new(slope[0], slope[1], w - slope[0] * x - slope[1] * y);
        let along = view.growth_along_offset.dot(growth);
        let facing = if view.is_orthographic() { along / w } else { 1.0 + along };
        let facing = (facing * (ray_squared / sight_squared).sqrt()).clamp(MOST_SLANTED, 1.0 / MOST_SLANTED);
        let rate = (self.rate(view, distance_ratio) * facing.sqrt()).min(USEFUL_RATE);
        rate * rate * rate * cosine.max(0.01)
    }
}
