//! How far the ranges of pixels over all frames reach, and which share of them stays within the tolerances: where a threshold
//! lies in the distribution that it cuts.

use serde::{Deserialize, Serialize};

use super::span_sums::SpanSums;
use super::static_test::StaticTest;

/// Bins per octave of the histograms of ranges.
const BINS_PER_OCTAVE: f32 = 4.0;

/// Ranges of color are binned from 2⁻⁶ steps up, those of depth from 2⁻²² up.
const COLOR_OCTAVES: f32 = 6.0;
const DEPTH_OCTAVES: f32 = 22.0;
const COLOR_BINS: usize = 18 * BINS_PER_OCTAVE as usize;
const DEPTH_BINS: usize = DEPTH_OCTAVES as usize * BINS_PER_OCTAVE as usize + 2;

/// The shares of pixels whose ranges [`RangeFacts`] names.
pub const PERCENTILES: [f32; 5] = [50.0, 75.0, 90.0, 95.0, 99.0];

/// Counts pixels by their ranges.
#[derive(Clone, Debug)]
pub struct RangeShares {
    color: Vec<u64>,
    depth: Vec<u64>,
    pixels: u64,
    with_depth: u64,
    within_color: u64,
    within_noisy_color: u64,
    within_depth: u64,
}

impl Default for RangeShares {
    fn default() -> Self {
        Self {
            color: vec![0; COLOR_BINS],
            depth: vec![0; DEPTH_BINS],
            pixels: 0,
            with_depth: 0,
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

impl RangeShares {
    /// Counts a pixel over all frames, of which the mean colors are known.
    pub fn add(&mut self, sums: &SpanSums, means: &[[half::f16; 3]], pixel: usize, test: &StaticTest) {
        let (color, depth) = (sums.color_range_steps(pixel), sums.depth_range_relative(pixel));
        self.count(color, depth, test, || means[pixel]);
    }

    /// Counts a pixel of these ranges; an infinite range of depth stands for a frame without depth.
    pub fn count(
        &mut self,
        color: f32,
        depth: f32,
        test: &StaticTest,
        mean: impl FnOnce() -> [half::f16; 3],
    ) {
        self.pixels += 1;
        if !depth.is_finite() {
            return;
        }
        self.with_depth += 1;
        self.color[bin(color, COLOR_OCTAVES, COLOR_BINS)] += 1;
        self.depth[bin(depth, DEPTH_OCTAVES, DEPTH_BINS)] += 1;
        let within = color <= test.granted_color();
        self.within_color += u64::from(within);
        self.within_noisy_color += u64::from(within || color <= test.granted(mean()));
        self.within_depth += u64::from(depth <= test.granted_depth());
    }

    /// Adds the counts of other pixels.
    pub fn join(&mut self, other: &Self) {
        let pairs = self.color.iter_mut().zip(&other.color).chain(self.depth.iter_mut().zip(&other.depth));
        pairs.for_each(|(all, more)| *all += more);
        self.pixels += other.pixels;
        self.with_depth += other.with_depth;
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
    #[must_use]
    pub fn facts(&self, test: &StaticTest) -> RangeFacts {
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

/// Bin 0 holds ranges of nothing, the others a quarter of an octave each.
fn bin(range: f32, octaves: f32, bins: usize) -> usize {
    if range <= 0.0 {
        return 0;
    }
    // Octave and quarter of it are those of the float's exponent and mantissa: no logarithm is needed.
    let bits = range.to_bits();
    let octave = (bits >> 23) as i32 - 127 + octaves as i32;
    let mantissa = bits & 0x7f_ffff;
    let quarter = QUARTERS.iter().filter(|from| mantissa >= **from).count() as i32;
    let position = (octave * BINS_PER_OCTAVE as i32 + quarter).max(0);
    (1 + position as usize).min(bins - 1)
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
            let rank = (f64::from(*percent) / 100.0 * total as f64).ceil() as u64;
            let mut below = 0;
            let found = bins.iter().position(|count| {
                below += count;
                below >= rank
            });
            match found.unwrap_or(0) {
                0 => 0.0,
                bin => (bin as f32 / BINS_PER_OCTAVE - octaves).exp2(),
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preprocess::noise::Noise;
    use crate::settings::SpanSettings;

    #[test]
    fn a_range_falls_into_the_bin_that_its_logarithm_names() {
        let mut range = 1e-8_f32;
        while range < 1e4 {
            let position = (f64::from(range).log2() + f64::from(COLOR_OCTAVES)) * f64::from(BINS_PER_OCTAVE);
            let expected = (1 + position.max(0.0) as usize).min(COLOR_BINS - 1);
            assert_eq!(bin(range, COLOR_OCTAVES, COLOR_BINS), expected, "{range}");
            range *= 1.013;
        }
        assert_eq!(bin(0.0, COLOR_OCTAVES, COLOR_BINS), 0);
        assert_eq!(bin(f32::MIN_POSITIVE / 8.0, COLOR_OCTAVES, COLOR_BINS), 1);
    }

    #[test]
    fn percentiles_and_shares_tell_where_the_tolerance_lies() {
        let settings = SpanSettings::default();
        let test = StaticTest::new(&settings, &Noise::default(), 0.0, 10);
        let mut shares = RangeShares::default();
        for i in 0..1000 {
            shares.count(i as f32 / 100.0, 0.0, &test, || [half::f16::ZERO; 3]);
        }
        shares.count(0.0, f32::INFINITY, &test, || [half::f16::ZERO; 3]);
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
