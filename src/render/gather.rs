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

use std::ops::Range;

use glam::{DVec2, DVec3, Vec3};

use super::frame_samples::FrameSamples;
use super::gather_points::bilinear;
use super::lookup::{Lookup, Quad};
use super::project::{Projector, focal};
use crate::capture::Camera;
use crate::preprocess::TILE;
use crate::settings::PruningMethod;

/// Sampling rates beyond this many times that of the vantage gain nothing: the picture cannot show more.
pub(super) const USEFUL_RATE: f32 = 1.5;

/// Where less than this share of a pixel is known by interpolation, the nearest sample's own color stands in.
pub(super) const ENOUGH: f32 = 0.25;

/// How much the nearest sample's own color counts for each part that is lacking.
pub(super) const OWN_SHARE: f32 = 0.2;

/// Samples whose 2×2 neighbors lie on another surface may be blended with it: they count less than clean ones.
pub(super) const BESIDE_EDGE: f32 = 0.3;

/// No further camera is asked once this many pixels' worth of samples are known; the best come first. Where nothing was
/// pruned two cameras average noise and aliasing; where pruning left one per surface, asking for a second finds little.
const MANY: f32 = 1.99;
const MANY_PRUNED: f32 = 0.99;

/// Depths that differ by less than this part of the tolerance are taken as equal.
pub(super) const EXACT: f32 = 0.005;

/// Sub-pixels along each side of a pixel that is interpolated in a picture of higher sampling rate, at most.
pub(super) const MAX_SUBPIXELS: f32 = 4.0;

/// A camera and its place beside the vantage.
pub(super) struct View {
    pub(super) camera: usize,
    pub(super) source_from_target: Projector,
    pub(super) target_from_source: Projector,
    /// From the camera's center to the vantage's, in world space.
    offset_in_world: Vec3,
    /// What lies within this relative difference of inverse depth is one surface.
    pub(super) tolerance: f32,
}

/// How one camera sees a surface point, as shares of the 2×2 samples around it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sight {
    /// Shows the surface there.
    pub(super) agree: f32,
    /// Shows something behind it: it sees through.
    pub(super) through: f32,
    /// Says nothing: hidden by something nearer, or pruned.
    pub(super) silent: f32,
    /// By sampling rate and viewing angle.
    pub(super) weight: f32,
}

/// Finds colors of surface points among the samples of a frame.
pub(super) struct Gather<'a> {
    pub(super) lookup: Lookup<'a>,
    pub(super) views: Vec<View>,
    /// Whether samples that others represent were dropped.
    pub(super) pruned: bool,
    /// [`MANY`] or [`MANY_PRUNED`].
    pub(super) many: f32,
    /// World-space ray of the first pixel's center, and its growth by column and row.
    rays_in_world: [Vec3; 3],
}

/// A surface point in one camera.
struct Place {
    quad: Quad,
    left: f32,
    above: f32,
    along: f32,
    down: f32,
    /// Inverse depth there, if it is the surface that the camera sees.
    expected: f32,
    /// Distance from the vantage over that from the camera.
    reciprocal: f32,
}

impl<'a> Gather<'a> {
    /// Over some tiles of the frame; `depth_tolerance` in footprints.
    pub(super) fn new(
        frame: &'a FrameSamples<'a>,
        tiles: Range<usize>,
        target: &Camera,
        depth_tolerance: f32,
    ) -> Self {
        let center = target.position_in_world();
        let view = |(camera, source): (usize, &Camera)| View {
            camera,
            source_from_target: Projector::new(target, source),
            target_from_source: Projector::new(source, target),
            offset_in_world: (center - source.position_in_world()).as_vec3(),
            tolerance: depth_tolerance / focal(source),
        };
        let ray = |x, y| target.world_from_camera.matrix3 * target.intrinsics.ray_in_camera(DVec2::new(x, y));
        let first = ray(0.5, 0.5);
        let pruned = frame.set.settings.pruning.method != PruningMethod::Off;
        Self {
            pruned,
            many: if pruned { MANY_PRUNED } else { MANY },
            lookup: Lookup::new(frame, tiles),
            views: frame.set.cameras.iter().enumerate().map(view).collect(),
            rays_in_world: [first, ray(1.5, 0.5) - first, ray(0.5, 1.5) - first].map(DVec3::as_vec3),
        }
    }

    /// Sorts cameras by how much they count for the surface at inverse depth `w` in pixel `(x, y)`, most first.
    pub(super) fn rank(&self, (x, y): (f32, f32), w: f32, cameras: &mut [u16]) {
        let weight = |camera: &u16| {
            let view = &self.views[*camera as usize];
            let point = view.source_from_target.ray(x, y) + view.source_from_target.origin * w;
            if point.z > 0.0 { self.weight(view, 1.0 / point.z, (x, y), w) } else { 0.0 }
        };
        cameras.sort_by(|a, b| weight(b).total_cmp(&weight(a)));
    }

    /// Where the surface point lies in a camera; `None` behind it and outside its picture.
    #[inline(always)]
    fn place(&self, view: &View, x: f32, y: f32, w: f32) -> Option<Place> {
        let projector = &view.source_from_target;
        let point = projector.ray(x, y) + projector.origin * w;
        let reciprocal = 1.0 / point.z;
        let (u, v) = (point.x * reciprocal - 0.5, point.y * reciprocal - 0.5);
        let (width, height) = self.lookup.size(view.camera);
        let inside = point.z > 0.0 && u > -1.0 && v > -1.0 && u < width as f32 && v < height as f32;
        if !inside {
            return None;
        }
        // Rounded down: both are larger than −1.
        let (column, row) = ((u + 1.0) as i32 - 1, (v + 1.0) as i32 - 1);
        let (left, above) = (column as f32, row as f32);
        Some(Place {
            quad: self.lookup.quad(view.camera, column, row),
            left,
            above,
            along: u - left,
            down: v - above,
            expected: w * reciprocal,
            reciprocal,
        })
    }

    /// How much a camera counts: the squared sampling rate, as far as it is of use, times the cosine between its line of
    /// sight and the vantage's.
    #[inline(always)]
    pub(super) fn weight(&self, view: &View, reciprocal: f32, (x, y): (f32, f32), w: f32) -> f32 {
        let [first, across, down] = self.rays_in_world;
        let ray = first + across * x + down * y;
        let sight = ray + view.offset_in_world * w;
        let cosine = ray.dot(sight) / (ray.length_squared() * sight.length_squared()).sqrt();
        let rate = (view.source_from_target.focal_ratio * reciprocal).min(USEFUL_RATE);
        rate * rate * cosine.max(0.01)
    }

    /// How a camera sees the surface at inverse depth `w`; `None` behind it and outside its picture.
    ///
    /// `agree` falls to −1 times its share where the surface that the camera saw lies elsewhere in the vantage, by half a
    /// pixel and more: there it is another part of the surface, which only happens to be as far away.
    #[inline(always)]
    pub(super) fn sight(&self, camera: u16, x: f32, y: f32, w: f32) -> Option<Sight> {
        let view = &self.views[camera as usize];
        let place = self.place(view, x, y, w)?;
        let limit = place.expected * view.tolerance;
        let mut sight = Sight { weight: self.weight(view, place.reciprocal, (x, y), w), ..Sight::default() };
        let mut depth = 0.0;
        for (found, share) in place.quad.depth.into_iter().zip(bilinear(place.along, place.down)) {
            if found >= 0.0 && (found - place.expected).abs() <= limit {
                sight.agree += share;
                depth += share * found;
            } else if found >= 0.0 && found < place.expected {
                sight.through += share;
            } else {
                sight.silent += share;
            }
        }
        if sight.agree > 0.0 {
            let projector = &view.target_from_source;
            let seen = projector.ray(place.left + place.along, place.above + place.down)
                + projector.origin * (depth / sight.agree);
            let off = (seen.x / seen.z - x - 0.5).abs().max((seen.y / seen.z - y - 0.5).abs());
            let doubt = sight.agree * off.min(1.0);
            sight.agree -= doubt;
            sight.through += doubt;
        }
        Some(sight)
    }
}

/// Columns and rows of the blocks of the picture that share a list of cameras.
pub(super) const BLOCK: usize = TILE;
