//! How far the ranges of pixels over all frames reach, and which share of them stays within the tolerances: where a threshold
//! is in the distribution that it cuts.

use serde::{Deserialize, Serialize};

use super::staticness::StaticTest;
use crate::preprocess::noise::{bin_of_rank, rank_of_share};
use crate::simd::{self, LANES, VectorLoop};

/// Bins per octave of the histograms of ranges.
const BINS_PER_OCTAVE: f32 = 4.0;

/// Ranges of color are binned from 2⁻⁶ steps up, those of depth from 2⁻²² up.
const COLOR_OCTAVES: f32 = 6.0;
const DEPTH_OCTAVES: f32 = 22.0;
const COLOR_BINS: usize = 18 * BINS_PER_OCTAVE as usize;
const DEPTH_BINS: usize = DEPTH_OCTAVES as usize * BINS_PER_OCTAVE as usize + 2;

/// The shares of pixels whose ranges [`RangeFacts`] names.
pub(super) const PERCENTILES: [f32; 5] = [50.0, 75.0, 90.0, 95.0, 99.0];

/// Counts pixels by their ranges.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RangeHistogram {
    color: Vec<u64>,
    depth: Vec<u64>,
    pixels: u64,
    within_color: u64,
    within_noisy_color: u64,
    within_depth: u64,
}

impl Default for RangeHistogram {
    fn default() -> Self {
        Self {
            color: vec![0; COLOR_BINS],
            depth: vec![0; DEPTH_BINS],
            pixels: 0,
            within_color: 0,
            within_noisy_color: 0,
            within_depth: 0,
        }
    }
}

/// Ranges over all frames of the pixels of one camera, and the tolerances among them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct RangeFacts {
    /// Color ranges, 8-bit sRGB steps, that 50, 75, 90, 95 and 99 % of the pixels stay below.
    pub color_percentiles_steps: Vec<f32>,
    /// Relative depth ranges that 50, 75, 90, 95 and 99 % of the pixels with a depth in every frame stay below.
    pub depth_percentiles_relative: Vec<f32>,
    /// Share of the pixels whose color stays within the tolerance alone, 0 to 1.
    pub within_color_tolerance: f32,
    /// Share of the pixels whose color stays within the tolerance and what noise explains, 0 to 1.
    pub within_color_tolerance_and_noise: f32,
    /// Depth range that is granted, relative: the tolerance or the quantization step, and what noise explains.
    pub depth_granted_relative: f32,
    /// Share of the pixels whose depth stays within it, 0 to 1.
    pub within_depth_granted: f32,
}

impl RangeHistogram {
    /// Counts pixels over all frames: their ranges of color (8-bit sRGB steps) and of depth (relative, infinite where there is a
    /// frame without depth), and the ranges of color that are granted to them.
    pub fn count(&mut self, color: &[f32], depth: &[f32], granted: &[f32], test: &StaticTest) {
        simd::run(Count { shares: self, color, depth, granted, test });
    }

    /// Adds the counts of other pixels.
    pub fn join(&mut self, other: &Self) {
        let pairs = self.color.iter_mut().zip(&other.color).chain(self.depth.iter_mut().zip(&other.depth));
        pairs.for_each(|(all, more)| *all += more);
        self.pixels += other.pixels;
        self.within_color += other.within_color;
        self.within_noisy_color += other.within_noisy_color;
        self.within_depth += other.within_depth;
    }

    /// Ranges of color (8-bit sRGB steps) from a lower end to an upper one, and how many pixels have such a range. What has
    /// no range at all comes first, from 0 to 0.
    pub fn color_bins(&self) -> impl Iterator<Item = ([f32; 2], u64)> + '_ {
        ends(&self.color, COLOR_OCTAVES)
    }

    /// The same for relative ranges of depth.
    pub fn depth_bins(&self) -> impl Iterator<Item = ([f32; 2], u64)> + '_ {
        ends(&self.depth, DEPTH_OCTAVES)
    }

    /// What the counts tell.
    pub(crate) fn facts(&self, test: &StaticTest) -> RangeFacts {
        let share = |count: u64| count as f32 / self.pixels.max(1) as f32;
        RangeFacts {
            color_percentiles_steps: percentiles(&self.color, COLOR_OCTAVES),
            depth_percentiles_relative: percentiles(&self.depth, DEPTH_OCTAVES),
            within_color_tolerance: share(self.within_color),
            within_color_tolerance_and_noise: share(self.within_noisy_color),
            depth_granted_relative: test.granted_depth(),
            within_depth_granted: share(self.within_depth),
        }
    }
}

struct Count<'a> {
    shares: &'a mut RangeHistogram,
    color: &'a [f32],
    depth: &'a [f32],
    granted: &'a [f32],
    test: &'a StaticTest,
}

impl VectorLoop for Count<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { shares, color, depth, granted, test } = self;
        let chunks = color.chunks(LANES).zip(depth.chunks(LANES)).zip(granted.chunks(LANES));
        for ((colors, depths), granteds) in chunks {
            // What is missing at the end has no depth, and is not counted.
            let (mut color, mut depth, mut granted) = ([0.0; LANES], [f32::INFINITY; LANES], [0.0; LANES]);
            color[..colors.len()].copy_from_slice(colors);
            depth[..depths.len()].copy_from_slice(depths);
            granted[..granteds.len()].copy_from_slice(granteds);
            shares.pixels += colors.len() as u64;
            shares.count_lanes(&color, &depth, &granted, test);
        }
    }
}

impl RangeHistogram {
    #[inline(always)]
    fn count_lanes(
        &mut self,
        color: &[f32; LANES],
        depth: &[f32; LANES],
        granted: &[f32; LANES],
        test: &StaticTest,
    ) {
        let (mut color_bins, mut depth_bins, mut within) = ([0; LANES], [0; LANES], [[0_u32; LANES]; 4]);
        for i in 0..LANES {
            let has_depth = depth[i] < f32::INFINITY;
            color_bins[i] = bin(color[i], COLOR_OCTAVES, COLOR_BINS);
            depth_bins[i] = bin(depth[i], DEPTH_OCTAVES, DEPTH_BINS);
            let is_within = color[i] <= test.granted_color();
            within[0][i] = u32::from(has_depth);
            within[1][i] = u32::from(has_depth & is_within);
            within[2][i] = u32::from(has_depth & (is_within | (color[i] <= granted[i])));
            within[3][i] = u32::from(has_depth & (depth[i] <= test.granted_depth()));
        }
        let sum = |of: &[u32; LANES]| u64::from(of.iter().sum::<u32>());
        self.within_color += sum(&within[1]);
        self.within_noisy_color += sum(&within[2]);
        self.within_depth += sum(&within[3]);
        for i in 0..LANES {
            self.color[color_bins[i] as usize % COLOR_BINS] += u64::from(within[0][i]);
            self.depth[depth_bins[i] as usize % DEPTH_BINS] += u64::from(within[0][i]);
        }
    }
}

/// Bin 0 holds ranges of nothing, the others a quarter of an octave each.
#[inline(always)]
fn bin(range: f32, octaves: f32, bins: usize) -> u32 {
    // Octave and quarter of it are those of the float's exponent and mantissa: no logarithm is needed.
    let bits = range.to_bits();
    let octave = (bits >> 23) as i32 - 127 + octaves as i32;
    let mantissa = bits & 0x7f_ffff;
    let mut quarter = 0;
    for from in QUARTERS {
        quarter += i32::from(mantissa >= from);
    }
    let position = (octave * BINS_PER_OCTAVE as i32 + quarter).max(0);
    let bin = (1 + position).min(bins as i32 - 1);
    if range <= 0.0 { 0 } else { bin as u32 }
}

fn ends(bins: &[u64], octaves: f32) -> impl Iterator<Item = ([f32; 2], u64)> + '_ {
    let end = move |bin: usize| (bin as f32 / BINS_PER_OCTAVE - octaves).exp2();
    let ends = move |bin: usize| if bin == 0 { [0.0; 2] } else { [end(bin - 1), end(bin)] };
    bins.iter().enumerate().map(move |(bin, count)| (ends(bin), *count))
}

/// Mantissas of 2^¼, 2^½ and 2^¾, where the second, third and fourth bin of an octave begin.
const QUARTERS: [u32; 3] = [0x18_37f0, 0x35_04f3, 0x57_44fd];

/// The upper ends of the bins that the percentiles fall into; empty where nothing was counted.
fn percentiles(bins: &[u64], octaves: f32) -> Vec<f32> {
    let total: u64 = bins.iter().sum();
    if total == 0 {
        return Vec::new();
    }
    PERCENTILES
        .iter()
        .map(|percent| {
            let rank = rank_of_share(total, f64::from(*percent) / 100.0);
            match bin_of_rank(bins.iter().copied(), rank).unwrap_or(0) {
                0 => 0.0,
                bin => (bin as f32 / BINS_PER_OCTAVE - octaves).exp2(),
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preprocess::noise::CameraNoise;
    use crate::settings::SpanSettings;

    #[test]
    fn a_range_falls_into_the_bin_that_its_logarithm_names() {
        let mut range = 1e-8_f32;
        while range < 1e4 {
            let position = (f64::from(range).log2() + f64::from(COLOR_OCTAVES)) * f64::from(BINS_PER_OCTAVE);
            let expected = (1 + position.max(0.0) as u32).min(COLOR_BINS as u32 - 1);
            assert_eq!(bin(range, COLOR_OCTAVES, COLOR_BINS), expected, "{range}");
            range *= 1.013;
        }
        assert_eq!(bin(0.0, COLOR_OCTAVES, COLOR_BINS), 0);
        assert_eq!(bin(f32::MIN_POSITIVE / 8.0, COLOR_OCTAVES, COLOR_BINS), 1);
    }

    #[test]
    fn percentiles_and_shares_tell_where_the_tolerance_lies() {
        let settings = SpanSettings::default();
        let test = StaticTest::new(&settings, &CameraNoise::default(), 0.0, 10);
        let mut shares = RangeHistogram::default();
        for i in 0..1000 {
            shares.count(&[i as f32 / 100.0], &[0.0], &[test.granted_color()], &test);
        }
        shares.count(&[0.0], &[f32::INFINITY], &[test.granted_color()], &test);
        let facts = shares.facts(&test);
        let expected = settings.color_tolerance / 10.0;
        assert!((facts.within_color_tolerance - expected).abs() < 2e-3, "{facts:?}");
        let median = shares.color_bins().find(|([low, high], _)| (*low..*high).contains(&5.0)).unwrap();
        assert!(median.1 > 50 && shares.color_bins().map(|(_, count)| count).sum::<u64>() == 1000);
        // A bin is a quarter of an octave wide.
        assert!((5.0..5.0 * 1.2).contains(&facts.color_percentiles_steps[0]), "{facts:?}");
        assert_eq!(facts.depth_percentiles_relative, [0.0; 5]);
        assert_eq!(facts.within_depth_granted, 1000.0 / 1001.0);
    }
}
