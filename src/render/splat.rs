//! Splatting: projected samples become a layer of nearest depths and blended colors.
//!
//! Source: Interactive Dynamic Environments Using Image-Based Modeling and Rendering, §3.3, "a coarse blending within a
//! 4-pixel region": a sample is spread with bilinear weights over the 2×2 pixels around its position. What differs: only
//! samples of the nearest surface are blended, within a tolerance in depth, so that what lies behind never shows through.
//!
//! Everything is summed in integers. Integer sums do not depend on their order, so the picture is the same, bit by bit,
//! whatever the thread count.
//!
//! ```text
//! key of a pixel = [ core: 1 bit | nearness: 31 bits | u32::MAX − ordinal: 32 bits ]     0: nothing there
//! ```
//! Nearness is the bits of the inverse depth plus one (positive floats order like integers); the larger key is the nearer
//! sample and, of two equally near ones, the one with the smaller ordinal.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use super::project::Projector;
use crate::capture::Camera;
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::{SampleImage, SampleSet};
use crate::settings::{Kernel, RenderSettings};

/// Weights are multiples of `1 / WEIGHT_ONE`.
const WEIGHT_ONE: f32 = 256.0;

/// Colors are summed as multiples of `1 / COLOR_ONE`: finer than a half float's step at 2⁻⁶ and wide enough for 65,504.
const COLOR_ONE: f32 = 65_536.0;

/// A sample belongs to the core of a pixel that gets at least this share of it, and else to its fringe. The fringe fills
/// pixels that are no sample's core; everywhere else it stays away, so that silhouettes do not grow by a pixel.
const CORE_SHARE: f32 = 0.06;

/// The bit of a key that marks a core sample: it wins over every fringe sample. Bits of positive floats leave it free.
const CORE: u32 = 1 << 31;

/// One pixel's blended color: red, green, blue, and the sum of weights.
pub(super) type Sum = [u64; 4];

/// Nearest depths and blended colors of some images.
#[derive(Clone, Debug, Default)]
pub(super) struct Layer {
    /// See the module's page; row-major.
    pub(super) keys: Vec<u64>,
    /// Blended colors; empty for the point kernel, which shows the nearest sample's own color.
    pub(super) sums: Vec<Sum>,
    /// Samples that were projected.
    pub(super) samples: u64,
}

/// The inverse depth that a key stands for; negative for 0.
pub(super) fn inverse_depth_of(key: u64) -> f32 {
    match (key >> 32) as u32 & !CORE {
        0 => -1.0,
        nearness => f32::from_bits(nearness - 1),
    }
}

/// The ordinal that a key stands for.
pub(super) fn ordinal_of(key: u64) -> u32 {
    u32::MAX - key as u32
}

fn key(inverse_depth: f32, tier: u32, ordinal: u32) -> u64 {
    u64::from((inverse_depth.to_bits() + 1) | tier) << 32 | u64::from(u32::MAX - ordinal)
}

/// The farthest inverse depth that still belongs to the surface whose nearest sample has `inverse_depth`.
pub(super) fn surface_limit(inverse_depth: f32, target: &Camera, settings: &RenderSettings) -> f32 {
    let focal = (target.intrinsics.fx * target.intrinsics.fy).sqrt() as f32;
    inverse_depth / (1.0 + settings.depth_tolerance / focal)
}

/// An image to paint and the ordinal of its first sample.
pub(super) struct Source<'a> {
    pub(super) image: &'a Arc<SampleImage>,
    pub(super) first_ordinal: u32,
}

/// Some tiles of one source: what one thread paints in one go.
struct Piece<'a> {
    source: &'a Source<'a>,
    projector: Projector,
    tiles: Range<usize>,
}

/// Paints `sources` as seen by `target`.
///
/// # Errors
/// `Cancelled`.
pub(super) fn splat(
    set: &SampleSet,
    sources: &[Source<'_>],
    target: &Camera,
    settings: &RenderSettings,
    job: &Job,
) -> Result<Layer> {
    let pixels = target.intrinsics.pixel_count();
    let shares = share_out(set, sources, target, rayon::current_num_threads());
    let size = (target.intrinsics.width as usize, target.intrinsics.height as usize);
    let keys = shares
        .par_iter()
        .map(|share| splat_keys(share, size, settings.kernel, job))
        .try_reduce(Vec::new, |a, b| Ok(merge(a, b, |a, b| *a = (*a).max(b))))?;
    let keys = if keys.is_empty() { vec![0; pixels] } else { keys };
    let samples = sources.iter().map(|source| source.image.len() as u64).sum();
    if settings.kernel == Kernel::Point {
        return Ok(Layer { keys, sums: Vec::new(), samples });
    }
    let limits: Vec<f32> =
        keys.par_iter().map(|&key| surface_limit(inverse_depth_of(key), target, settings)).collect();
    let sums = shares
        .par_iter()
        .map(|share| splat_colors(share, size, &limits, job))
        .try_reduce(Vec::new, |a, b| {
            Ok(merge(a, b, |a: &mut Sum, b| (0..4).for_each(|channel| a[channel] += b[channel])))
        })?;
    let sums = if sums.is_empty() { vec![[0; 4]; pixels] } else { sums };
    Ok(Layer { keys, sums, samples })
}

/// Merges two buffers value by value; an empty one stands for nothing painted.
fn merge<T: Copy + Send + Sync>(mut a: Vec<T>, b: Vec<T>, add: impl Fn(&mut T, T) + Sync) -> Vec<T> {
    if a.is_empty() {
        return b;
    }
    a.par_iter_mut().zip(&b).with_min_len(4096).for_each(|(a, &b)| add(a, b));
    a
}

/// Splits all tiles into `count` shares of about as many samples each.
fn share_out<'a>(
    set: &SampleSet,
    sources: &'a [Source<'a>],
    target: &Camera,
    count: usize,
) -> Vec<Vec<Piece<'a>>> {
    let total: usize = sources.iter().map(|source| source.image.len()).sum();
    let per_share = total.div_ceil(count.max(1)).max(1);
    let mut shares = vec![Vec::new()];
    let mut in_share = 0;
    for source in sources {
        let projector = Projector::new(&set.cameras[source.image.camera as usize], target);
        let mut start = 0;
        for (tile, found) in source.image.tiles.iter().enumerate() {
            in_share += found.count();
            if in_share >= per_share {
                if let Some(share) = shares.last_mut() {
                    share.push(Piece { source, projector, tiles: start..tile + 1 });
                }
                shares.push(Vec::new());
                (start, in_share) = (tile + 1, 0);
            }
        }
        if let Some(share) = shares.last_mut() {
            share.push(Piece { source, projector, tiles: start..source.image.tiles.len() });
        }
    }
    shares
}

/// The 2×2 pixels around a position with their bilinear weights; those outside the picture are left out.
#[inline]
fn block(u: f32, v: f32, (width, height): (usize, usize), mut touch: impl FnMut(usize, f32)) {
    // Negated so that NaN is left out too.
    if !(u > -0.5 && v > -0.5 && u < width as f32 + 0.5 && v < height as f32 + 0.5) {
        return;
    }
    let (left, top) = ((u - 0.5).floor(), (v - 0.5).floor());
    let (along, down) = (u - 0.5 - left, v - 0.5 - top);
    for (dy, share_y) in [(0.0, 1.0 - down), (1.0, down)] {
        for (dx, share_x) in [(0.0, 1.0 - along), (1.0, along)] {
            let (x, y, weight) = (left + dx, top + dy, share_x * share_y);
            if x >= 0.0 && y >= 0.0 && x < width as f32 && y < height as f32 {
                touch(y as usize * width + x as usize, weight);
            }
        }
    }
}

fn splat_keys(share: &[Piece<'_>], size: (usize, usize), kernel: Kernel, job: &Job) -> Result<Vec<u64>> {
    let mut keys = vec![0_u64; size.0 * size.1];
    for piece in share {
        let image = &piece.source.image;
        for tile in piece.tiles.clone() {
            job.check()?;
            piece.projector.project_tile(image, tile, |sample| {
                let ordinal = piece.source.first_ordinal + sample.index as u32;
                match kernel {
                    Kernel::Point => {
                        let inside = sample.u >= 0.0
                            && sample.v >= 0.0
                            && sample.u < size.0 as f32
                            && sample.v < size.1 as f32;
                        if inside {
                            let pixel = &mut keys[sample.v as usize * size.0 + sample.u as usize];
                            *pixel = (*pixel).max(key(sample.inverse_depth, CORE, ordinal));
                        }
                    }
                    Kernel::Block => block(sample.u, sample.v, size, |pixel, weight| {
                        let tier = if weight >= CORE_SHARE { CORE } else { 0 };
                        keys[pixel] = keys[pixel].max(key(sample.inverse_depth, tier, ordinal));
                    }),
                }
            });
        }
    }
    Ok(keys)
}

fn splat_colors(share: &[Piece<'_>], size: (usize, usize), limits: &[f32], job: &Job) -> Result<Vec<Sum>> {
    let mut sums = vec![[0_u64; 4]; size.0 * size.1];
    for piece in share {
        let image = &piece.source.image;
        for tile in piece.tiles.clone() {
            job.check()?;
            piece.projector.project_tile(image, tile, |sample| {
                let color =
                    image.color[sample.index].map(|channel| (channel.to_f32().max(0.0) * COLOR_ONE) as u64);
                block(sample.u, sample.v, size, |pixel, weight| {
                    if sample.inverse_depth >= limits[pixel] {
                        let weight = (weight * WEIGHT_ONE) as u64;
                        let sum = &mut sums[pixel];
                        (0..3).for_each(|channel| sum[channel] += weight * color[channel]);
                        sum[3] += weight;
                    }
                });
            });
        }
    }
    Ok(sums)
}

/// The mean color of a sum of weighted colors; `None` where nothing was summed.
pub(super) fn mean_color(sum: Sum) -> Option<[f32; 3]> {
    let scale = 1.0 / (sum[3] as f64 * f64::from(COLOR_ONE));
    (sum[3] > 0).then(|| [sum[0], sum[1], sum[2]].map(|channel| (channel as f64 * scale) as f32))
}
