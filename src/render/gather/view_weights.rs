//! The gather stage: surface first, color second.
//!
//! The surface stage says at which depth the surface lies in each pixel. Here that surface point is carried back into the
//! cameras, and its color interpolated among their samples: bilinearly over the 2×2 samples around it, as far as they lie on
//! the same surface, averaged over cameras by sampling rate and viewing angle. Each camera first corrects the depth by its
//! own samples, so that noise and small misalignments between cameras blur nothing.
//!
//! Source: backward warping with per-view weights is that of Buehler et al., *Unstructured Lumigraph Rendering*, SIGGRAPH
//! 2001, §4 (angle and resolution penalties). What differs: the proxy is the z-buffer of the samples themselves, weights are
//! taken per pixel instead of per vertex, and samples that pruning removed are left out one by one.

use glam::Vec3;

use crate::capture::Camera;
use crate::render::geometry::{Projector, focal, rays_in_world};
use crate::render::input::{CellTable, FrameSamples, Lookup};
use crate::samples::TILE;

/// Sampling rates beyond this many times that of the vantage gain nothing: the picture cannot show more.
pub(crate) const USEFUL_RATE: f32 = 1.5;

/// Where less than this share of a pixel is known by interpolation, the nearest sample's own color stands in.
pub(crate) const ENOUGH: f32 = 0.25;

/// How much the nearest sample's own color counts for each part that is lacking.
pub(crate) const OWN_SHARE: f32 = 0.2;

/// Samples whose 2×2 neighbors lie on another surface may be blended with it: they count less than clean ones.
pub(crate) const BESIDE_EDGE: f32 = 0.3;

/// No further camera is asked once this many pixels' worth of samples are known; the best come first. Where nothing was
/// pruned two cameras average noise and aliasing; where pruning left one per surface, asking for a second finds little.
const MANY: f32 = 1.99;
const MANY_PRUNED: f32 = 0.99;

/// Depths that differ by less than this part of the tolerance are taken as equal.
pub(crate) const EXACT: f32 = 0.005;

/// A sub-pixel is at most this many samples wide. A recorded pixel, itself a box one sample wide, and the tent that interpolates
/// it have together the variance of a box 1.7 wide (1/12 + 1/6 = 1.7²/12), so that no picture is blurred by one look-up up to
/// there, nor sharper than by two of them until 2.2; up to 2.5 the difference cannot be measured.
pub(crate) const SUBPIXEL_WIDTH: f32 = 2.5;

/// Sub-pixels along each side of a pixel that is interpolated in a picture of higher sampling rate, at most.
pub(crate) const MAX_SUBPIXELS: f32 = 4.0;

/// A camera and its place beside the vantage.
pub(crate) struct SourceView {
    pub(crate) camera: usize,
    pub(crate) source_from_target: Projector,
    pub(crate) target_from_source: Projector,
    /// From the camera's center to the vantage's, in world space.
    offset_in_world: Vec3,
    /// What lies within this relative difference of inverse depth is one surface.
    pub(crate) tolerance: f32,
}

/// Finds colors of surface points among the samples of a frame.
pub(crate) struct SourceViews<'a> {
    pub(crate) lookup: Lookup<'a>,
    pub(crate) views: Vec<SourceView>,
    /// Whether samples that others represent were dropped.
    pub(crate) pruned: bool,
    /// [`MANY`] or [`MANY_PRUNED`].
    pub(crate) many: f32,
    /// World-space ray of the first pixel's center, and its growth by column and row.
    rays_in_world: [Vec3; 3],
}

impl<'a> SourceViews<'a> {
    /// Over the tiles of a table; `depth_tolerance` in footprints.
    pub(crate) fn new(
        frame: &'a FrameSamples<'a>,
        table: CellTable,
        target: &Camera,
        depth_tolerance: f32,
    ) -> Self {
        let center = target.position_in_world();
        let view = |(camera, source): (usize, &Camera)| SourceView {
            camera,
            source_from_target: Projector::new(target, source),
            target_from_source: Projector::new(source, target),
            offset_in_world: (center - source.position_in_world()).as_vec3(),
            tolerance: depth_tolerance / focal(source),
        };
        let pruned = frame.is_pruned();
        Self {
            pruned,
            many: if pruned { MANY_PRUNED } else { MANY },
            lookup: Lookup { table, frame },
            views: frame.set.cameras.iter().enumerate().map(view).collect(),
            rays_in_world: rays_in_world(target, 0.5),
        }
    }

    /// Sorts cameras by how much they count for the surface at inverse depth `w` in pixel `(x, y)`, most first.
    #[inline(always)]
    pub(crate) fn rank(
        &self,
        (x, y): (f32, f32),
        w: f32,
        cameras: &mut [u16],
        weights: &mut Vec<(f32, u16)>,
    ) {
        weights.clear();
        weights.extend(cameras.iter().map(|&camera| {
            let view = &self.views[camera as usize];
            let point = view.source_from_target.ray(x, y) + view.source_from_target.origin * w;
            let weight = if point.z > 0.0 { self.weight(view, 1.0 / point.z, (x, y), w) } else { 0.0 };
            (weight, camera)
        }));
        weights.sort_by(|a, b| b.0.total_cmp(&a.0));
        cameras.iter_mut().zip(weights).for_each(|(camera, (_, ranked))| *camera = *ranked);
    }

    /// The pixel of a camera that shows the surface at inverse depth `w` in pixel `(x, y)`, be it beside the camera's picture.
    #[inline(always)]
    pub(crate) fn pixel_in(&self, camera: u16, (x, y): (f32, f32), w: f32) -> Option<(i32, i32)> {
        let there = &self.views[camera as usize].source_from_target;
        let point = there.ray(x, y) + there.origin * w;
        let (u, v) = (point.x / point.z, point.y / point.z);
        (point.z > 0.0 && u.abs().max(v.abs()) < 1e6).then_some((u as i32, v as i32))
    }

    /// How much a camera counts: the squared sampling rate, as far as it is of use, times the cosine between its line of
    /// sight and the vantage's.
    #[inline(always)]
    pub(crate) fn weight(&self, view: &SourceView, reciprocal: f32, (x, y): (f32, f32), w: f32) -> f32 {
        let [first, across, down] = self.rays_in_world;
        let ray = first + across * x + down * y;
        let sight = ray + view.offset_in_world * w;
        let cosine = ray.dot(sight) / (ray.length_squared() * sight.length_squared()).sqrt();
        let rate = (view.source_from_target.focal_ratio * reciprocal).min(USEFUL_RATE);
        rate * rate * cosine.max(0.01)
    }
}

/// Columns and rows of the blocks of the picture that share a list of cameras.
pub(crate) const BLOCK: usize = TILE;
