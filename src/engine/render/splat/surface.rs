//! The surface stage: which sample is nearest in each pixel.
//!
//! Kernels differ in the pixels that a sample touches: `point` the one it falls into; `block` the 2×2 around it (the paper,
//! §3.3); `surfel` and `gather` those whose centers lie in its oriented footprint, each at the depth of its plane there.

use rayon::prelude::*;

use super::band_rows::BandRows;
use super::input::{StageInput, split_at_bands};
use super::packed_tile::{PackedTile, TileSamples};
use super::zkey::{CORE, key, nearness};
use crate::error::Result;
use crate::render::geometry::{
    CORE_REACH, FRINGE, Footprints, MAGNIFIED, MAX_STRETCH, PlaneAt, ProjectedPixels, RowBand, footprints,
};
use crate::samples::TILE;
use crate::settings::Kernel;
use crate::simd::{self, VectorLoop, joined, mask};

/// A sample belongs to the core of a pixel that gets at least this share of it by bilinear weights, and else to its
/// fringe. The fringe fills pixels that are no sample's core; elsewhere it stays away, so that silhouettes do not grow.
const CORE_SHARE: f32 = 0.06;

/// Raises the keys in `bands` to those of the nearest samples.
pub(crate) fn surface(input: &StageInput<'_>, bands: &[RowBand], keys: &mut [u64]) -> Result<()> {
    split_at_bands(bands, input.width, keys).into_par_iter().try_for_each(|(band, keys)| {
        let pixels = BandRows::of(input.width, &band.rows);
        let fringe = input.kernel == Kernel::Gather && input.frame.is_pruned();
        match input.kernel {
            Kernel::Point => simd::run(BandSurface { input, band, keys, splat: PointSplat(pixels) }),
            Kernel::Block => simd::run(BandSurface { input, band, keys, splat: BlockSplat(pixels) }),
            Kernel::Surfel | Kernel::Gather => {
                simd::run(BandSurface { input, band, keys, splat: PlaneSplat { pixels, fringe } })
            }
        }
    })
}

/// One band of the picture.
struct BandSurface<'a, S> {
    input: &'a StageInput<'a>,
    band: &'a RowBand,
    keys: &'a mut [u64],
    splat: S,
}

/// The keys of a band, and new keys to raise them to.
struct KeyUpdates<'a> {
    /// Pixels of the band that sixteen samples touch, the first of each sample, the second and so on; or, for samples that touch a
    /// single pixel, one for each group of a tile.
    pixels: [[u32; TILE]; TILE],
    /// The new keys; the larger of old and new stays, so 0 changes nothing.
    new: [[u64; TILE]; TILE],
    keys: &'a mut [u64],
}

/// How the samples of a kernel touch pixels.
trait Splat {
    /// Whether it reads slopes.
    const READS_SLOPES: bool = false;

    /// Raises the keys of the pixels that the `nth` group of samples of a tile touches; `slots` is the slot of the tile's first pixel.
    fn group(&self, samples: &TileSamples<'_>, slots: u32, nth: usize, raised: &mut KeyUpdates<'_>);

    /// Ends a tile.
    #[inline(always)]
    fn end(&self, _raised: &mut KeyUpdates<'_>) {}
}

/// Depths are prefetched this many tiles ahead.
const TILES_AHEAD: usize = 4;

impl<S: Splat> VectorLoop for BandSurface<'_, S> {
    type Output = Result<()>;

    #[inline(always)]
    fn run(self) -> Result<()> {
        let Self { input, band, keys, splat } = self;
        let mut packed = PackedTile::new();
        let mut raised = KeyUpdates { pixels: [[0; TILE]; TILE], new: [[0; TILE]; TILE], keys };
        for (nth, &number) in band.tiles.iter().enumerate() {
            input.job.check()?;
            if let Some(&later) = band.tiles.get(nth + TILES_AHEAD) {
                input.frame.tile(later as usize).prefetch_depths();
            }
            let tile = input.frame.tile(number as usize);
            let camera = tile.camera as usize;
            let projector = &input.projectors[camera];
            packed.set(tile, projector, S::READS_SLOPES.then_some(input.per_footprint[camera]));
            for nth in 0..packed.group_count() {
                splat.group(&packed.group(nth, tile, projector), number << 8, nth, &mut raised);
            }
            splat.end(&mut raised);
        }
        Ok(())
    }
}

impl KeyUpdates<'_> {
    /// Raises the keys of the `nth` pixel of each sample.
    #[inline(always)]
    fn raise_all(&mut self, nth: usize) {
        for (pixel, new) in self.pixels[nth].iter().zip(&self.new[nth]) {
            let key = &mut self.keys[*pixel as usize];
            *key = (*key).max(*new);
        }
    }

    /// Raises the keys of the `nth` pixel of the samples in a mask of columns.
    #[inline(always)]
    fn raise_some(&mut self, nth: usize, mut which: u32) {
        while which != 0 {
            let i = which.trailing_zeros() as usize % TILE;
            which &= which - 1;
            let key = &mut self.keys[self.pixels[nth][i] as usize];
            *key = (*key).max(self.new[nth][i]);
        }
    }
}

/// `point`: a sample touches the pixel that it falls into.
struct PointSplat(BandRows);

impl Splat for PointSplat {
    #[inline(always)]
    fn group(&self, samples: &TileSamples<'_>, slots: u32, nth: usize, raised: &mut KeyUpdates<'_>) {
        let projected = &samples.projected;
        for i in 0..TILE {
            let (pixel, inside) = self.0.pixel(projected.u[i].floor(), projected.v[i].floor(), i);
            raised.pixels[nth][i] = pixel;
            raised.new[nth][i] = samples.key(i, CORE, slots, inside);
        }
    }

    /// A tile is projected as a whole before its keys are compared, because only projecting is work for vectors. Groups that it
    /// has not hold keys of an earlier tile, which change nothing.
    #[inline(always)]
    fn end(&self, raised: &mut KeyUpdates<'_>) {
        for group in 0..TILE {
            raised.raise_all(group);
        }
    }
}

/// `block`: a sample touches the 2×2 pixels around it.
struct BlockSplat(BandRows);

impl Splat for BlockSplat {
    #[inline(always)]
    fn group(&self, samples: &TileSamples<'_>, slots: u32, _nth: usize, raised: &mut KeyUpdates<'_>) {
        let projected = &samples.projected;
        for corner in 0..4 {
            let (right, below) = ((corner & 1) as f32, (corner >> 1) as f32);
            for i in 0..TILE {
                let (left, top) = ((projected.u[i] - 0.5).floor(), (projected.v[i] - 0.5).floor());
                let (along, down) = (projected.u[i] - 0.5 - left, projected.v[i] - 0.5 - top);
                let share_x = if corner & 1 == 1 { along } else { 1.0 - along };
                let share_y = if corner >> 1 == 1 { down } else { 1.0 - down };
                let tier = if share_x * share_y >= CORE_SHARE { CORE } else { 0 };
                let (pixel, inside) = self.0.pixel(left + right, top + below, i);
                raised.pixels[corner][i] = pixel;
                raised.new[corner][i] = samples.key(i, tier, slots, inside);
            }
        }
        for corner in 0..4 {
            raised.raise_all(corner);
        }
    }
}

/// `surfel` and `gather`: a sample touches the pixels whose centers its footprint covers, at the depth of its plane.
struct PlaneSplat {
    pixels: BandRows,
    /// Whether magnified samples have a fringe, which fills pixels outside all footprints, where neighbors may have been pruned.
    /// The gather stage decides which of these pixels show the surface.
    fringe: bool,
}

impl PlaneSplat {
    /// Whether none of some samples reaches into the band: many do not where a tile lies across its ends.
    #[inline(always)]
    fn misses(&self, samples: &TileSamples<'_>) -> bool {
        let TileSamples { projector, w, projected, .. } = samples;
        let touching = mask(|i| {
            // No footprint reaches farther, with or without its fringe.
            let reach = MAX_STRETCH * projector.magnification(w[i], projected.reciprocal[i]) + 1.0;
            self.pixels.has_row_between(projected.v[i] - reach, projected.v[i] + reach)
        });
        touching == 0
    }
}

impl Splat for PlaneSplat {
    const READS_SLOPES: bool = true;

    #[inline(always)]
    fn group(&self, samples: &TileSamples<'_>, slots: u32, _nth: usize, raised: &mut KeyUpdates<'_>) {
        let TileSamples { at, w, projected, trust, .. } = samples;
        if self.misses(samples) {
            return;
        }
        let found = footprints(samples.projector, projected, w, &samples.slopes);
        // First and last column and row whose centers the footprint covers: up to three unless it is large.
        let mut edges = [[0.0_f32; TILE]; 4];
        let mut large = [0_u32; TILE];
        // The samples that cover a first, a second and a third column and row.
        let (mut columns, mut rows) =
            ([[u32::MAX; TILE], [0; TILE], [0; TILE]], [[u32::MAX; TILE], [0; TILE], [0; TILE]]);
        for i in 0..TILE {
            let (half_width, half_height) = (found.half_width[i].max(0.5), found.half_height[i].max(0.5));
            let seen = (projected.reciprocal[i] > 0.0) & (w[i] >= 0.0);
            edges[0][i] = (projected.u[i] - half_width - 0.5).ceil();
            edges[1][i] = (projected.u[i] + half_width - 0.5).floor();
            edges[2][i] = (projected.v[i] - half_height - 0.5).ceil();
            edges[3][i] = (projected.v[i] + half_height - 0.5).floor();
            let wide = (edges[1][i] > edges[0][i] + 2.0) | (edges[3][i] > edges[2][i] + 2.0);
            large[i] = u32::from(wide & seen) << i;
            columns[1][i] = u32::from((edges[1][i] > edges[0][i]) & seen & !wide) << i;
            columns[2][i] = u32::from((edges[1][i] > edges[0][i] + 1.0) & seen & !wide) << i;
            rows[1][i] = u32::from((edges[3][i] > edges[2][i]) & seen & !wide) << i;
            rows[2][i] = u32::from((edges[3][i] > edges[2][i] + 1.0) & seen & !wide) << i;
        }
        let mut large = joined(&large);
        let (columns, rows) = (columns.map(|columns| joined(&columns)), rows.map(|rows| joined(&rows)));
        let mut touched = [0_u32; 9];
        for corner in 0..9_usize {
            let (right, below) = (corner % 3, corner / 3);
            let further = columns[right] & rows[below];
            if further == 0 {
                continue;
            }
            for i in 0..TILE {
                let (x, y) = (edges[0][i] + right as f32, edges[2][i] + below as f32);
                let (pixel, inside) = self.pixels.pixel(x, y, i);
                let PlaneAt { inverse_depth: depth, is_core: covered, .. } =
                    found.plane_at(projected, i, (x, y), 1.0);
                let is_further = further >> i & 1 == 1;
                let seen = inside & covered & is_further & (projected.reciprocal[i] > 0.0) & (w[i] >= 0.0);
                raised.pixels[corner][i] = pixel;
                raised.new[corner][i] =
                    if seen { key(nearness(depth, CORE | trust[i]), slots | at[i]) } else { 0 };
                touched[corner] |= u32::from(seen) << i;
            }
        }
        raised.raise_all(0);
        for corner in 1..9 {
            raised.raise_some(corner, touched[corner]);
        }
        while large != 0 {
            let i = large.trailing_zeros() as usize % TILE;
            large &= large - 1;
            let own = LargeFootprint { found: &found, projected, i, slot: slots | at[i], trust: trust[i] };
            self.pixels.raise(raised.keys, edges.map(|edges| edges[i]), |x, y| own.core(x, y));
            if self.fringe && own.has_fringe() {
                let reach = samples.reach(i);
                self.pixels.raise(raised.keys, own.edges_of_fringe(reach), |x, y| own.fringe(x, y, reach));
            }
        }
    }
}

/// A sample whose footprint covers many pixels.
struct LargeFootprint<'a> {
    found: &'a Footprints,
    projected: &'a ProjectedPixels,
    /// Its number in the group.
    i: usize,
    slot: u32,
    /// As [`TileSamples::trust`].
    trust: u32,
}

impl LargeFootprint<'_> {
    /// Its key at the center of pixel `(x, y)`; 0 where the footprint does not cover it.
    #[inline(always)]
    fn core(&self, x: f32, y: f32) -> u64 {
        let at = self.found.plane_at(self.projected, self.i, (x, y), 1.0);
        if at.is_core { key(nearness(at.inverse_depth, CORE | self.trust), self.slot) } else { 0 }
    }

    /// That of its fringe, which begins where the footprint ends; `reach` as [`TileSamples::reach`] gives it.
    #[inline(always)]
    fn fringe(&self, x: f32, y: f32, reach: [f32; 4]) -> u64 {
        let at = self.found.plane_at(self.projected, self.i, (x, y), FRINGE / CORE_REACH);
        let reaches = !at.is_core
            & (-reach[0] <= at.across)
            & (at.across <= reach[1])
            & (-reach[2] <= at.down)
            & (at.down <= reach[3]);
        if reaches { key(nearness(at.inverse_depth, self.trust), self.slot) } else { 0 }
    }

    /// Whether it is magnified and not seen edge on, where the surface beside it would be unknown.
    #[inline(always)]
    fn has_fringe(&self) -> bool {
        let is_known = self.found.inverse.iter().any(|part| part[self.i] != 0.0);
        is_known && self.found.largest[self.i] >= MAX_STRETCH * MAGNIFIED
    }

    /// First and last column and row whose centers the fringe may cover.
    #[inline(always)]
    fn edges_of_fringe(&self, reach: [f32; 4]) -> [f32; 4] {
        let [a, b, c, d] = self.found.jacobian.map(|part| part[self.i]);
        let largest = self.found.largest[self.i];
        let span = |middle: f32, per_column: f32, per_row: f32| {
            let (left, right) = (-reach[0] * per_column, reach[1] * per_column);
            let (above, below) = (-reach[2] * per_row, reach[3] * per_row);
            let before = (left.min(right) + above.min(below)).max(-largest).min(-0.5);
            let after = (left.max(right) + above.max(below)).min(largest).max(0.5);
            [(middle + before - 0.5).ceil(), (middle + after - 0.5).floor()]
        };
        let [left, right] = span(self.projected.u[self.i], a, b);
        let [top, bottom] = span(self.projected.v[self.i], c, d);
        [left, right, top, bottom]
    }
}
