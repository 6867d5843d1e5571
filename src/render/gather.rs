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
use super::lookup::{Lookup, Quad};
use super::project::{Projector, focal};
use crate::capture::Camera;
use crate::preprocess::TILE;
use crate::settings::PruningMethod;

/// Sampling rates beyond this many times that of the vantage gain nothing: the picture cannot show more.
const USEFUL_RATE: f32 = 1.5;

/// Where less than this share of a pixel is known by interpolation, the nearest sample's own color stands in.
const ENOUGH: f32 = 0.25;

/// How much the nearest sample's own color counts for each part that is lacking.
const OWN_SHARE: f32 = 0.2;

/// Samples whose 2×2 neighbors lie on another surface may be blended with it: they count less than clean ones.
const BESIDE_EDGE: f32 = 0.3;

/// No further camera is asked once this many pixels' worth of samples are known; the best come first. Where nothing was
/// pruned two cameras average noise and aliasing; where pruning left one per surface, asking for a second finds little.
const MANY: f32 = 1.99;
const MANY_PRUNED: f32 = 0.99;

/// Depths that differ by less than this part of the tolerance are taken as equal.
const EXACT: f32 = 0.005;

/// Sub-pixels along each side of a pixel that is interpolated in a picture of higher sampling rate, at most.
const MAX_SUBPIXELS: f32 = 4.0;

/// A camera and its place beside the vantage.
struct View {
    camera: usize,
    source_from_target: Projector,
    target_from_source: Projector,
    /// From the camera's center to the vantage's, in world space.
    offset_in_world: Vec3,
    /// What lies within this relative difference of inverse depth is one surface.
    tolerance: f32,
}

/// One camera's answer.
struct Answer {
    /// Weighted by `weight`.
    color: [f32; 3],
    weight: f32,
    /// Share of the pixel that is known.
    known: f32,
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
    lookup: Lookup<'a>,
    views: Vec<View>,
    /// Whether samples that others represent were dropped.
    pruned: bool,
    /// [`MANY`] or [`MANY_PRUNED`].
    many: f32,
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

    /// The color of the surface at inverse depth `w` in pixel `(x, y)` of the vantage, among the samples of `cameras`, of
    /// which the best come first, and, in a pruned set, before them those of the camera that `sample` comes from. `own` is
    /// the color of that sample, for where nothing can be interpolated.
    #[inline(always)]
    pub(super) fn color(
        &self,
        (x, y): (f32, f32),
        w: f32,
        (sample, cameras): (u16, &[u16]),
        own: impl FnOnce() -> [f32; 3],
    ) -> [f32; 3] {
        let (mut sum, mut total, mut known) = ([0.0; 3], 0.0, 0.0);
        let mut next = 0;
        let mut camera = sample;
        let mut ask = self.pruned;
        loop {
            if ask && let Some(answer) = self.answer(&self.views[camera as usize], x, y, w) {
                (0..3).for_each(|channel| sum[channel] += answer.color[channel]);
                total += answer.weight;
                known += answer.known;
            }
            if next == cameras.len() || known >= self.many {
                break;
            }
            camera = cameras[next];
            ask = !self.pruned || camera != sample;
            next += 1;
        }
        if total < ENOUGH {
            let lack = (ENOUGH - total) * OWN_SHARE + 1e-6;
            let own = own();
            (0..3).for_each(|channel| sum[channel] += own[channel] * lack);
            total += lack;
        }
        sum.map(|channel| channel / total)
    }

    #[inline(always)]
    fn answer(&self, view: &View, x: f32, y: f32, w: f32) -> Option<Answer> {
        let place = self.place(view, x, y, w)?;
        let rate = view.source_from_target.focal_ratio * place.reciprocal;
        if rate <= USEFUL_RATE {
            return self.interpolate(view, &place, x, y, w);
        }
        // The picture is coarser than the camera's: the mean over sub-pixels, or fine detail would alias.
        let count = (rate / USEFUL_RATE).ceil().min(MAX_SUBPIXELS);
        let mut sum = Answer { color: [0.0; 3], weight: 0.0, known: 0.0 };
        let per_subpixel = 1.0 / count;
        for sub_y in 0..count as usize {
            for sub_x in 0..count as usize {
                let x = x + (sub_x as f32 + 0.5) * per_subpixel - 0.5;
                let y = y + (sub_y as f32 + 0.5) * per_subpixel - 0.5;
                let Some(place) = self.place(view, x, y, w) else { continue };
                if let Some(part) = self.interpolate(view, &place, x, y, w) {
                    (0..3).for_each(|channel| sum.color[channel] += part.color[channel]);
                    sum.weight += part.weight;
                    sum.known += part.known;
                }
            }
        }
        let share = per_subpixel * per_subpixel;
        (sum.weight > 0.0).then(|| Answer {
            color: sum.color.map(|channel| channel * share),
            weight: sum.weight * share,
            known: sum.known * share,
        })
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

    #[inline(always)]
    fn interpolate(&self, view: &View, place: &Place, x: f32, y: f32, w: f32) -> Option<Answer> {
        let limit = place.expected * view.tolerance;
        let depths = &place.quad.depth;
        let shares = bilinear(place.along, place.down);
        // Samples that show the surface there count fully, others not at all; all four do nearly everywhere.
        let agrees = depths
            .map(|depth| f32::from(u8::from(((depth - place.expected).abs() <= limit) & (depth >= 0.0))));
        let shown: [f32; 4] = std::array::from_fn(|corner| shares[corner] * agrees[corner]);
        let known = (shown[0] + shown[1]) + (shown[2] + shown[3]);
        if known < 1e-3 {
            return None;
        }
        let weighted: [f32; 4] = std::array::from_fn(|corner| shown[corner] * depths[corner]);
        let depth = ((weighted[0] + weighted[1]) + (weighted[2] + weighted[3])) / known;
        // Where the camera agrees with the z-buffer to a small part of the tolerance, correcting moves nothing.
        let shares = if (depth - place.expected).abs() > EXACT * limit {
            let (along, down) = corrected(view, place, (x, y), depth);
            bilinear(along, down)
        } else {
            shares
        };
        let (mut color, mut known) = ([0.0; 3], 0.0);
        for corner in 0..4 {
            if agrees[corner] > 0.0 {
                let sample = self.lookup.color(&place.quad, corner);
                (0..3).for_each(|channel| color[channel] += shares[corner] * sample[channel]);
                known += shares[corner];
            }
        }
        let beside = (0..4).any(|corner| (agrees[corner] == 0.0) & (depths[corner] >= 0.0));
        let weight = self.weight(view, place.reciprocal, (x, y), w) * if beside { BESIDE_EDGE } else { 1.0 };
        Some(Answer { color: color.map(|channel| channel * weight), weight: known * weight, known })
    }

    /// How much a camera counts: the squared sampling rate, as far as it is of use, times the cosine between its line of
    /// sight and the vantage's.
    #[inline(always)]
    fn weight(&self, view: &View, reciprocal: f32, (x, y): (f32, f32), w: f32) -> f32 {
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

/// Shares of left above, right above, left below, right below.
#[inline(always)]
fn bilinear(along: f32, down: f32) -> [f32; 4] {
    let (back, up) = (1.0 - along, 1.0 - down);
    [back * up, along * up, back * down, along * down]
}

/// Where between the 2×2 samples the pixel's line of sight meets the surface that the camera itself saw, at inverse depth
/// `depth`, instead of the one that the z-buffer holds.
#[inline(always)]
fn corrected(view: &View, place: &Place, (x, y): (f32, f32), depth: f32) -> (f32, f32) {
    let back = &view.target_from_source;
    let seen = back.ray(place.left + place.along, place.above + place.down) + back.origin * depth;
    let there = &view.source_from_target;
    let point = there.ray(x, y) * seen.z + there.origin * depth;
    let reciprocal = 1.0 / point.z;
    let (u, v) = (point.x * reciprocal - 0.5, point.y * reciprocal - 0.5);
    let sound = seen.z > 0.0 && point.z > 0.0;
    if sound {
        ((u - place.left).clamp(0.0, 1.0), (v - place.above).clamp(0.0, 1.0))
    } else {
        (place.along, place.down)
    }
}

/// Columns and rows of the blocks of the picture that share a list of cameras.
pub(super) const BLOCK: usize = TILE;
