//! Pixels of the picture that four pixels of the z-buffer share.
//!
//! Purpose: along silhouettes a pixel shows each surface in the share that it covers. The z-buffer is twice as fine as the picture;
//! the surfaces of the four sub-pixels of a pixel are decided one by one, and joined where they are the same.
//!
//! Source: supersampling of visibility apart from shading, as multisample antialiasing does (Akeley, *`RealityEngine` Graphics*,
//! SIGGRAPH 1993). What differs: a surface is looked up once, in the middle of the sub-pixels that show it, at their mean depth.

use super::near_cameras::NearCameras;
use super::silhouette::{EdgePixel, Patch, PixelSurfaces, RING};
use super::surface_points::{PixelShares, StripPixel, SurfaceDepth, SurfacePoints};
use super::target::{BLOCK, PictureRows, set_images};
use super::visibility_votes::VisibilityVotes;
use crate::render::input::FrameSamples;
use crate::render::splat::{inverse_depth_of, slot_of};
use crate::render::vantage::{FrontColor, LEAST_SHOWN, NO_FRONT, NO_IMAGE};

/// The sub-pixels of a pixel, from its first column and row.
const SUBPIXELS: [(usize, usize); 4] = [(0, 0), (1, 0), (0, 1), (1, 1)];

/// Pixels along a block.
const PAIRS: usize = BLOCK / 2;

/// Most surfaces of a pixel: a nearer and a farther one in each sub-pixel.
const MOST_SURFACES: usize = 2 * SUBPIXELS.len();

/// The pixels of a block that are at steps in depth, and what is known of them.
#[derive(Clone, Copy)]
pub(super) struct DecidedEdges<'a> {
    /// Which they are: a mask of columns per row.
    pub(super) edges: [u16; BLOCK],
    /// In the order of the pixels of the picture, and of the sub-pixels of each.
    pub(super) pixels: &'a [EdgePixel],
    /// The votes on those of `pixels` that are voted on.
    pub(super) votes: &'a [VisibilityVotes],
}

/// A surface that some sub-pixels of a pixel show. Sums over these, weighted by their shares.
#[derive(Clone, Copy, Default)]
struct SharedSurface {
    /// Key of the sub-pixel that was found first.
    key: u64,
    share: f32,
    x: f32,
    y: f32,
    w: f32,
}

/// The surfaces of one pixel.
#[derive(Default)]
struct PixelParts {
    surfaces: [SharedSurface; MOST_SURFACES],
    count: usize,
    /// How many of the sub-pixels samples cover.
    shown: f32,
}

impl PixelParts {
    /// Adds what the sub-pixel at column `x` and row `y` of the z-buffer shows.
    #[inline(always)]
    fn add(&mut self, surfaces: PixelSurfaces, (x, y): (f32, f32), surface_ratio: f32) {
        let parts = match surfaces {
            PixelSurfaces::Hole => return,
            PixelSurfaces::One(key) => [(key, 1.0), (key, 0.0)],
            PixelSurfaces::Two { near, far: 0, share } => [(near, share), (near, 0.0)],
            PixelSurfaces::Two { near, far, share } => [(near, share), (far, 1.0 - share)],
        };
        self.shown += parts[0].1 + parts[1].1;
        for (key, share) in parts.into_iter().filter(|(_, share)| *share > 0.0) {
            let w = inverse_depth_of(key);
            let is_same = |surface: &SharedSurface| {
                is_same_surface(surface.key, inverse_depth_of(surface.key), key, w, surface_ratio)
            };
            let known = self.surfaces[..self.count].iter().position(is_same);
            let nth = known.unwrap_or(self.count) % MOST_SURFACES;
            if known.is_none() {
                self.count = nth + 1;
                self.surfaces[nth].key = key;
            }
            let surface = &mut self.surfaces[nth];
            surface.share += share;
            surface.x += share * x;
            surface.y += share * y;
            surface.w += share * w;
        }
    }
}

/// Sets depth and image of the pixels of `which`, and lists their surface points. `which` is a mask of columns of the z-buffer per
/// row, in which the sub-pixels of a pixel are all set or none.
#[inline(always)]
pub(super) fn set_surfaces_of_pairs(
    patch: &Patch,
    frame: &FrameSamples<'_>,
    (decided, near): (DecidedEdges<'_>, &NearCameras),
    which: &[u16; BLOCK],
    rows: &mut PictureRows<'_>,
    points: &mut SurfacePoints,
) {
    let DecidedEdges { edges, pixels, votes } = decided;
    let (mut edge_pixels, mut votes) = (pixels.iter(), votes.iter());
    let columns = BLOCK.min(2 * rows.width - patch.left);
    for row in (0..BLOCK).step_by(2).filter(|row| which[*row] != 0) {
        let y = (patch.top + row) as f32;
        if edges[row] | edges[row + 1] == 0 && which[row] == u16::MAX && columns == BLOCK {
            set_row_of_pairs((patch, near), frame, row, rows, points);
            continue;
        }
        for column in (0..columns).step_by(2).filter(|column| which[row] >> column & 1 == 1) {
            let at = row / 2 * rows.width + patch.left / 2 + column / 2;
            let x = (patch.left + column) as f32;
            rows.color[at] = [0.0; 3];
            let near = near.mask(column, row);
            let mut surfaces = [PixelSurfaces::Hole; 4];
            for ((right, below), surfaces) in SUBPIXELS.into_iter().zip(&mut surfaces) {
                let (column, row) = (column + right, row + below);
                *surfaces = if edges[row] >> column & 1 == 1 {
                    let Some(edge_pixel) = edge_pixels.next() else { continue };
                    let votes = edge_pixel.voted_key().and_then(|_| votes.next().copied());
                    edge_pixel.decide(votes.unwrap_or_default(), 2)
                } else {
                    PixelSurfaces::One(patch.keys[row + RING][column + RING])
                };
            }
            let is_edge = (edges[row] | edges[row + 1]) & 3 << column != 0;
            if let Some((key, w)) = one_surface(&surfaces, is_edge, patch.surface_ratio) {
                let pixel = StripPixel { x: x + 0.5, y: y + 0.5, at: at as u32, near };
                let depth = SurfaceDepth { w, slope: patch.slope(column, row) };
                points.push(key, depth, frame.camera_of(slot_of(key)), pixel, PixelShares::WHOLE);
                rows.inverse_depth[at] = w;
                if let Some(front) = rows.fronts.get_mut(at) {
                    *front = NO_FRONT;
                }
                if let Some(coverage) = rows.coverage.get_mut(at) {
                    *coverage = 1.0;
                }
                rows.image[at] = frame.image_of(slot_of(key));
                continue;
            }
            let slope = patch.slope(column, row);
            let mut parts = PixelParts::default();
            for ((right, below), surfaces) in SUBPIXELS.into_iter().zip(surfaces) {
                parts.add(surfaces, (x + right as f32, y + below as f32), patch.surface_ratio);
            }
            let ResolvedPixel { inverse_depth, image, front, coverage } =
                push_parts(&parts, frame, (at, near), slope, points);
            rows.inverse_depth[at] = inverse_depth;
            rows.image[at] = image;
            if let Some(place) = rows.coverage.get_mut(at) {
                *place = coverage;
            }
            if let Some(place) = rows.fronts.get_mut(at) {
                *place = front;
            }
        }
    }
}

/// Sets depth and image of a row of pixels, each of which shows one surface, and lists their surface points. `row` is the first of
/// their two rows of the z-buffer.
#[inline(always)]
fn set_row_of_pairs(
    (patch, near): (&Patch, &NearCameras),
    frame: &FrameSamples<'_>,
    row: usize,
    rows: &mut PictureRows<'_>,
    points: &mut SurfacePoints,
) {
    let start = row / 2 * rows.width + patch.left / 2;
    let pixels = start..start + PAIRS;
    let (above, below) = (&patch.w[row + RING], &patch.w[row + RING + 1]);
    let (mut keys, mut w) = ([0; PAIRS], [0.0; PAIRS]);
    for i in 0..PAIRS {
        let column = RING + 2 * i;
        keys[i] = patch.keys[row + RING][column];
        w[i] = 0.25 * (above[column] + above[column + 1] + below[column] + below[column + 1]);
    }
    rows.color[pixels.clone()].fill([0.0; 3]);
    rows.inverse_depth[pixels.clone()].copy_from_slice(&w);
    if let Some(fronts) = rows.fronts.get_mut(pixels.clone()) {
        fronts.fill(NO_FRONT);
    }
    if let Some(coverage) = rows.coverage.get_mut(pixels.clone()) {
        coverage.fill(1.0);
    }
    let cameras = set_images(&keys, frame, &mut rows.image[pixels]);
    let (x, y) = (patch.left as f32 + 0.5, (patch.top + row) as f32 + 0.5);
    let mut slopes = [[0.0; PAIRS]; 2];
    for i in 0..PAIRS {
        [slopes[0][i], slopes[1][i]] = patch.slope(2 * i, row);
    }
    let first = StripPixel { x, y, at: start as u32, near: 0 };
    points.push_row(&keys, &w, &slopes, (&cameras, &near.row(row, 2)), first, 2.0);
}

/// The surface that all sub-pixels of a pixel show, by the key of the first and their mean inverse depth; `None` if there are several,
/// or holes. Without an edge there is only one.
#[inline(always)]
fn one_surface(surfaces: &[PixelSurfaces; 4], is_edge: bool, surface_ratio: f32) -> Option<(u64, f32)> {
    let mut keys = [0; 4];
    for (key, surfaces) in keys.iter_mut().zip(surfaces) {
        let PixelSurfaces::One(one) = *surfaces else { return None };
        *key = one;
    }
    let w = keys.map(inverse_depth_of);
    let is_same = |key: u64, other: f32| is_same_surface(keys[0], w[0], key, other, surface_ratio);
    if is_edge && !(1..4).all(|nth| is_same(keys[nth], w[nth])) {
        return None;
    }
    Some((keys[0], 0.25 * (w[0] + w[1] + w[2] + w[3])))
}

/// Whether two samples, with their keys and inverse depths, show one surface: a sample alone does, however slanted.
#[inline(always)]
fn is_same_surface(a: u64, a_w: f32, b: u64, b_w: f32, surface_ratio: f32) -> bool {
    slot_of(a) == slot_of(b) || a_w.min(b_w) >= a_w.max(b_w) * surface_ratio
}

/// What a pixel shows, apart from colors.
struct ResolvedPixel {
    /// That of the surface that takes most of it.
    inverse_depth: f32,
    image: u32,
    /// Without a color yet.
    front: FrontColor,
    /// Share of the pixel that its surfaces cover.
    coverage: f32,
}

/// Lists the surfaces of a pixel, by its position in the strip and the cameras near it, around which inverse depths grow by `slope`.
#[inline(always)]
fn push_parts(
    parts: &PixelParts,
    frame: &FrameSamples<'_>,
    (at, near): (usize, u32),
    slope: [f32; 2],
    points: &mut SurfacePoints,
) -> ResolvedPixel {
    let mut pixel =
        ResolvedPixel { inverse_depth: inverse_depth_of(0), image: NO_IMAGE, front: NO_FRONT, coverage: 0.0 };
    let surfaces = &parts.surfaces[..parts.count];
    let all = parts.shown;
    pixel.coverage = (all / SUBPIXELS.len() as f32).min(1.0);
    let is_hole = pixel.coverage < LEAST_SHOWN;
    let farthest = surfaces.iter().fold(f32::INFINITY, |least, surface| least.min(surface.w / surface.share));
    let is_farthest = |surface: &SharedSurface| surface.w / surface.share <= farthest;
    let before: f32 =
        surfaces.iter().filter(|surface| !is_farthest(surface)).map(|surface| surface.share).sum();
    let has_front = parts.count > 1;
    let slope = if has_front { [0.0; 2] } else { slope };
    if has_front {
        (pixel.front[3], pixel.front[4]) = (farthest, before / SUBPIXELS.len() as f32);
    }
    // Most of what is shown lies in front of the farthest surface.
    let shows_front = has_front && 2.0 * before >= all;
    let mut largest = 0.0;
    for surface in surfaces {
        let mean = 1.0 / surface.share;
        let w = surface.w * mean;
        let place = StripPixel { x: surface.x * mean, y: surface.y * mean, at: at as u32, near };
        let own = frame.camera_of(slot_of(surface.key));
        let is_front = has_front && !is_farthest(surface);
        let front_share = if is_front { surface.share / before } else { 0.0 };
        let shares = PixelShares { pixel: surface.share / all, front: front_share };
        points.push(surface.key, SurfaceDepth { w, slope }, own, place, shares);
        if surface.share > largest && (is_front || !shows_front) && !is_hole {
            largest = surface.share;
            (pixel.inverse_depth, pixel.image) = (w, frame.image_of(slot_of(surface.key)));
        }
    }
    pixel
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::splat::{CORE, key, nearness};

    const RATIO: f32 = 0.99;

    fn sample(w: f32) -> u64 {
        key(nearness(w, CORE), w.to_bits())
    }

    /// The surfaces of a pixel whose sub-pixels show this.
    fn parts(shown: [PixelSurfaces; 4]) -> PixelParts {
        let mut parts = PixelParts::default();
        for ((right, below), surfaces) in SUBPIXELS.into_iter().zip(shown) {
            parts.add(surfaces, (right as f32, below as f32), RATIO);
        }
        parts
    }

    fn found(parts: &PixelParts) -> Vec<(f32, [f32; 2], f32)> {
        let of = |part: &SharedSurface| {
            (part.share, [part.x, part.y].map(|sum| sum / part.share), part.w / part.share)
        };
        parts.surfaces[..parts.count].iter().map(of).collect()
    }

    #[test]
    fn sub_pixels_of_one_surface_are_looked_up_once_in_their_middle() {
        let one = |w| PixelSurfaces::One(sample(w));
        let same = parts([one(1.0), one(1.004), one(1.0), one(1.004)]);
        assert_eq!((same.shown, same.count), (4.0, 1));
        let [(share, at, w)] = found(&same)[..] else { panic!("one surface") };
        assert!(share == 4.0 && at == [0.5, 0.5] && (w - 1.002).abs() < 1e-6, "{share} {at:?} {w}");
        let both = parts([one(1.0), one(0.5), one(1.0), one(0.5)]);
        assert_eq!(found(&both), [(2.0, [0.0, 0.5], 1.0), (2.0, [1.0, 0.5], 0.5)]);
    }

    #[test]
    fn a_sub_pixel_that_shows_two_surfaces_counts_for_both_by_its_share() {
        let (near, far) = (sample(1.0), sample(0.5));
        let blend = PixelSurfaces::Two { near, far, share: 0.25 };
        let one = PixelSurfaces::One(near);
        let mixed = parts([one, one, blend, PixelSurfaces::Hole]);
        assert_eq!((mixed.shown, mixed.count), (3.0, 2));
        let shares: Vec<f32> = found(&mixed).iter().map(|(share, ..)| *share).collect();
        assert_eq!(shares, [2.25, 0.75]);
    }

    #[test]
    fn a_surface_that_ends_at_a_hole_within_a_sub_pixel_covers_a_share_of_it() {
        let one = PixelSurfaces::One(sample(1.0));
        let rim = PixelSurfaces::Two { near: sample(1.0), far: 0, share: 0.25 };
        let part = parts([one, rim, one, PixelSurfaces::Hole]);
        assert_eq!((part.shown, part.count), (2.25, 1));
    }

    #[test]
    fn the_sky_is_a_surface_of_its_own() {
        let (near, sky) = (PixelSurfaces::One(sample(0.01)), PixelSurfaces::One(sample(0.0)));
        assert_eq!(parts([sky, sky, near, sky]).count, 2);
        assert_eq!(parts([sky; 4]).count, 1);
    }
}
