//! Noise measured from the capture itself.
//!
//! Purpose: a pixel that shows the same surface in every frame still differs from frame to frame where the renderer
//! samples light at random or the sensor is noisy. The standard deviation is taken from differences of successive
//! frames, whose median is blind to the few pixels that really move:
//! `σ = median |x(t+1) − x(t)| / (√2 · 0.6745)` for a normal distribution.
//!
//! Light that moves changes neighbors alike; noise does not. The second difference `d(i−2) − 2d(i) + d(i+2)` of the relative
//! changes `d` of color along a row is what counts. It is √6 times as wide as `d` where pixels change independently, and 0 where
//! change grows evenly, whatever the pattern of the surface. Depth is treated alike: a surface that comes nearer changes
//! evenly. Patterns that move are detected in `block_motion.rs`.
//!
//! Source: the median absolute deviation (Hampel 1974) of first differences; second differences in space are those of
//! Immerkær, *Fast Noise Variance Estimation*, CVIU 1996.
//! What differs: color noise is measured per brightness, because a renderer's noise grows with light.
//!
//! The range over a number of frames that noise alone explains.
//!
//! Source: the range of `n` normal draws is that of Tippett, *On the extreme individuals and the range of samples*, Biometrika
//! 1925: `P(range ≤ r) = n ∫ φ(x) [Φ(x + r) − Φ(x)]^(n−1) dx`.

use half::f16;
use serde::{Deserialize, Serialize};

use super::block_motion::{is_same_surface, patterns_move};
use crate::capture::Frame;
use crate::color;

/// Brightness classes of the color noise, each `256 / BRIGHTNESS_BINS` sRGB steps wide; the last also holds all above.
pub const BRIGHTNESS_BINS: usize = 16;

/// Width of a bin of the histogram of color differences, 8-bit sRGB steps.
const COLOR_BIN_STEPS: f32 = 1.0 / 16.0;
const COLOR_BINS: usize = 1024;

/// Depth differences are binned by their binary logarithm, a quarter of an octave a bin, from 2^-32 up.
const DEPTH_BINS_PER_OCTAVE: f32 = 4.0;
const DEPTH_OCTAVES: f32 = 32.0;
const DEPTH_BINS: usize = 128 + 1;

/// A brightness class with fewer differences than this is not believed and takes the value of all classes together.
const MIN_DIFFERENCES: u64 = 500;

/// Fewer differences of depth than this speak for no noise: what moves may be most of so few pixels.
const MIN_DEPTH_DIFFERENCES: u64 = 256;

/// Where more than half of a picture moves, the median no longer speaks of noise. No renderer and no sensor worth
/// recording with is noisier than this: standard deviation of color, 8-bit sRGB steps, and of depth, relative.
const MAX_COLOR_STEPS: f32 = 8.0;
const MAX_DEPTH_RELATIVE: f32 = 0.01;

/// Pixels between those whose changes are compared: a renderer's pixel filter makes nearer ones alike.
const APART: usize = 2;

/// √(1 + 2² + 1): the standard deviation of `a − 2b + c`, of independent numbers, over that of one of them.
const SECOND_DIFFERENCE: f32 = 2.449_49;

/// Darker colors are taken for this one, 8-bit sRGB steps, where changes are compared as parts of them.
const DARKEST_STEPS: f32 = 8.0;

/// √2 · Φ⁻¹(0.75): from the median absolute difference of two draws to their standard deviation.
const MEDIAN_DIFFERENCE_PER_SIGMA: f32 = 0.953_87;

/// If fewer than one in this many pixels of resting surfaces change at all, light moves and nothing is noisy.
const FEWEST_REDRAWN: u64 = 10;

/// Depth that changes by more than this, or by this many times its noise, is that of another surface.
const SAME_SURFACE_RELATIVE: f32 = 1e-3;
const SAME_SURFACE_SIGMAS: f32 = 6.0;

/// Noise is measured on every `NOISE_ROW_STRIDE`-th row: plenty for a median.
const NOISE_ROW_STRIDE: usize = 4;

/// Noise of one camera.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CameraNoise {
    /// Standard deviation of color over time, 8-bit sRGB steps, per brightness class.
    pub color_steps: [f32; BRIGHTNESS_BINS],
    /// Standard deviation of color over time, 8-bit sRGB steps, all brightness classes together.
    pub color_steps_overall: f32,
    /// Relative standard deviation of depth over time.
    pub depth_relative: f32,
}

impl CameraNoise {
    /// Standard deviation of a color channel whose value is `steps` (8-bit sRGB).
    #[must_use]
    pub fn color_at(&self, steps: f32) -> f32 {
        self.color_steps[brightness_bin(steps)]
    }
}

/// The brightness class of a value, 8-bit sRGB steps.
pub(crate) fn brightness_bin(steps: f32) -> usize {
    ((steps * (BRIGHTNESS_BINS as f32 / 256.0)) as usize).min(BRIGHTNESS_BINS - 1)
}

/// Collects differences of successive frames. Counting is exact, so the order of calls does not matter.
struct NoiseMeter {
    color: Vec<u64>,
    depth: Vec<u64>,
    /// Pixels that were looked at for a change of color, and pixels that had one.
    looked_at: u64,
    redrawn: u64,
}

impl Default for NoiseMeter {
    fn default() -> Self {
        Self {
            color: vec![0; BRIGHTNESS_BINS * COLOR_BINS],
            depth: vec![0; DEPTH_BINS],
            looked_at: 0,
            redrawn: 0,
        }
    }
}

impl NoiseMeter {
    /// Counts the change of a color channel of this brightness between two frames, both 8-bit sRGB steps.
    fn add_color(&mut self, steps: f32, change_steps: f32) {
        let bin = ((change_steps.abs() / COLOR_BIN_STEPS) as usize).min(COLOR_BINS - 1);
        self.color[brightness_bin(steps) * COLOR_BINS + bin] += 1;
    }

    /// Counts what the changes of color between two frames have of their own beside those of their neighbors. A surface is the
    /// same in both where its relative inverse depths differ by no more than `limit`.
    fn add_colors(&mut self, [before, after]: [&Frame; 2], limit: f32) {
        let mut changes = Vec::new();
        for y in looked_at_rows(after) {
            let colors = before.color.row(y).iter().zip(after.color.row(y));
            changes.clear();
            changes.extend(finite_depths(before, after, y).zip(colors).map(|(depths, (&before, &after))| {
                let same = depths.filter(|depths| is_same_surface(*depths, limit));
                same.map(|_| ColorChange::between([before, after]))
            }));
            self.looked_at += changes.iter().flatten().count() as u64;
            self.redrawn += changes.iter().flatten().filter(|change| change.is_redrawn()).count() as u64;
            for window in changes.windows(2 * APART + 1) {
                if let (Some(left), Some(here), Some(right)) =
                    (&window[0], &window[APART], &window[2 * APART])
                    && here.is_redrawn()
                {
                    for channel in 0..3 {
                        let own = own_part([left, here, right].map(|change| change.relative[channel]));
                        let steps = here.mean_steps[channel];
                        self.add_color(steps, steps * own);
                    }
                }
            }
        }
    }

    /// Counts what the changes of finite depths between two frames have of their own beside those of their neighbors.
    fn add_depths(&mut self, [before, after]: [&Frame; 2]) {
        let mut changes = Vec::new();
        for y in looked_at_rows(after) {
            changes.clear();
            let relative = |[before, after]: [f32; 2]| (after - before) / before.max(after);
            changes.extend(finite_depths(before, after, y).map(|depths| depths.map(relative)));
            for window in changes.windows(2 * APART + 1) {
                if let (Some(left), Some(here), Some(right)) = (window[0], window[APART], window[2 * APART]) {
                    self.add_depth(own_part([left, here, right]));
                }
            }
        }
    }

    /// Counts a relative change of depth.
    fn add_depth(&mut self, relative: f32) {
        let relative = relative.abs();
        let bin = if relative == 0.0 {
            0
        } else {
            let octaves = (relative.log2() + DEPTH_OCTAVES).max(0.0);
            1 + ((octaves * DEPTH_BINS_PER_OCTAVE) as usize).min(DEPTH_BINS - 2)
        };
        self.depth[bin] += 1;
    }

    /// The standard deviations that the counted differences speak for.
    fn noise(&self) -> CameraNoise {
        let mut overall = vec![0; COLOR_BINS];
        self.color.iter().zip((0..COLOR_BINS).cycle()).for_each(|(count, bin)| overall[bin] += count);
        let is_motion = self.redrawn * FEWEST_REDRAWN < self.looked_at;
        let color_sigma = |bins: &[u64]| {
            if is_motion {
                return 0.0;
            }
            // Bin 0 means "no difference that matters", so that noise-free input measures exactly 0.
            let steps = |bin: f32| (bin * COLOR_BIN_STEPS / MEDIAN_DIFFERENCE_PER_SIGMA).min(MAX_COLOR_STEPS);
            median_bin(bins).filter(|bin| *bin >= 1.0).map_or(0.0, steps)
        };
        let color_steps_overall = color_sigma(&overall);
        let mut color_steps = [color_steps_overall; BRIGHTNESS_BINS];
        for (sigma, class) in color_steps.iter_mut().zip(self.color.chunks_exact(COLOR_BINS)) {
            if class.iter().sum::<u64>() >= MIN_DIFFERENCES {
                *sigma = color_sigma(class);
            }
        }
        let depth = |bin: f32| {
            let difference = ((bin - 1.0) / DEPTH_BINS_PER_OCTAVE - DEPTH_OCTAVES).exp2();
            (difference / MEDIAN_DIFFERENCE_PER_SIGMA).min(MAX_DEPTH_RELATIVE)
        };
        let is_believed = self.depth.iter().sum::<u64>() >= MIN_DEPTH_DIFFERENCES;
        let bin = median_bin(&self.depth).filter(|bin| is_believed && *bin >= 1.0);
        let depth_relative = bin.map_or(0.0, depth);
        CameraNoise { color_steps, color_steps_overall, depth_relative }
    }
}

/// How the color of a pixel changed from one frame to the next, per channel.
struct ColorChange {
    /// 8-bit sRGB, at least [`DARKEST_STEPS`].
    mean_steps: [f32; 3],
    /// Relative to that.
    relative: [f32; 3],
}

impl ColorChange {
    #[inline(always)]
    fn between(colors: [[f16; 3]; 2]) -> Self {
        let table = color::steps_table();
        let [before, after] = colors.map(|color| color.map(|channel| table[channel.to_bits() as usize]));
        let mean_steps =
            [0, 1, 2].map(|channel| (0.5 * (before[channel] + after[channel])).max(DARKEST_STEPS));
        Self {
            mean_steps,
            relative: [0, 1, 2].map(|channel| (after[channel] - before[channel]) / mean_steps[channel]),
        }
    }

    fn is_redrawn(&self) -> bool {
        self.relative != [0.0; 3]
    }
}

/// The part of a change that its two neighbors do not share, scaled to the spread of a change when all three are independent.
fn own_part([left, here, right]: [f32; 3]) -> f32 {
    (left - 2.0 * here + right) / SECOND_DIFFERENCE
}

fn looked_at_rows(frame: &Frame) -> impl Iterator<Item = usize> {
    (0..frame.size().1).step_by(NOISE_ROW_STRIDE)
}

/// Inverse depths of a row of pixels in two frames, where both are finite. The sky is often a constant and would speak for a
/// noise-free scene.
fn finite_depths<'a>(
    before: &'a Frame,
    after: &'a Frame,
    y: usize,
) -> impl Iterator<Item = Option<[f32; 2]>> + 'a {
    let rows = before.inverse_depth.row(y).iter().zip(after.inverse_depth.row(y));
    rows.map(|(&before, &after)| (before > 0.0 && after > 0.0).then_some([before, after]))
}

/// The noise of a camera from some pairs of successive frames.
///
/// Differences of color count where the surface is the same in both frames and the color is not. A renderer that draws the
/// same random numbers for every frame gives a pixel that nothing moving shines on the very same color again, which shows
/// nothing of its noise; the differences of the others do.
#[must_use]
pub fn measure_pairs(pairs: &[[&Frame; 2]]) -> CameraNoise {
    let mut meter = NoiseMeter::default();
    for pair in pairs {
        meter.add_depths(*pair);
    }
    let limit = SAME_SURFACE_RELATIVE.max(SAME_SURFACE_SIGMAS * meter.noise().depth_relative);
    if !patterns_move(pairs, limit) {
        for pair in pairs {
            meter.add_colors(*pair, limit);
        }
    }
    meter.noise()
}

/// The bin that the `rank`-th smallest of the counted numbers falls into, counted from 1; `None` beyond the last.
pub(crate) fn bin_of_rank(counts: impl IntoIterator<Item = u64>, rank: u64) -> Option<usize> {
    let mut up_to = 0;
    counts.into_iter().position(|count| {
        up_to += count;
        up_to >= rank
    })
}

/// The rank, counted from 1, of the smallest number that a share of `total` numbers, 0 to 1, does not exceed.
pub(crate) fn rank_of_share(total: u64, share: f64) -> u64 {
    (total as f64 * share).ceil() as u64
}

/// Position of the median in a histogram, in bins, interpolated within its bin; `None` where nothing was counted.
pub(super) fn median_bin(bins: &[u64]) -> Option<f32> {
    let total: u64 = bins.iter().sum();
    if total == 0 {
        return None;
    }
    let half = total as f64 / 2.0;
    let bin = bin_of_rank(bins.iter().copied(), half.ceil() as u64)?;
    let below: u64 = bins[..bin].iter().sum();
    Some(bin as f32 + ((half - below as f64) / bins[bin] as f64) as f32)
}

/// Share of static pixels that the granted range must hold; what is lost goes to the foreground, which costs bytes only.
const STATIC_SHARE: f64 = 0.9998;

/// The range, in standard deviations, that all but a fraction of a permille of static pixels keep within over `draws`
/// frames. 0 for fewer than two draws.
#[must_use]
pub fn granted_range_sigmas(draws: usize) -> f32 {
    if draws < 2 {
        return 0.0;
    }
    let (mut low, mut high) = (0.0_f64, 20.0_f64);
    for _ in 0..40 {
        let middle = f64::midpoint(low, high);
        if range_probability(draws, middle) < STATIC_SHARE { low = middle } else { high = middle }
    }
    high as f32
}

/// `P(range ≤ r)` of `draws` standard normal draws, by the trapezoidal rule (spectrally accurate on this integrand).
fn range_probability(draws: usize, r: f64) -> f64 {
    const STEP: f64 = 0.02;
    let density = |x: f64| (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
    let cumulative: Vec<f64> = {
        let mut sum = 0.0;
        (-500..=1600)
            .map(|i| {
                let cell = density(f64::from(i) * STEP) * STEP;
                sum += cell;
                sum - 0.5 * cell
            })
            .collect()
    };
    let shift = r / STEP;
    let mut probability = 0.0;
    for (i, &below) in cumulative.iter().enumerate().take(1001) {
        let x = (i as f64 - 500.0) * STEP;
        let position = (i as f64 + shift).min(cumulative.len() as f64 - 2.0);
        let cell = position.floor();
        let above = {
            let (a, b) = (cumulative[cell as usize], cumulative[cell as usize + 1]);
            a + (b - a) * (position - cell)
        };
        probability += density(x) * (above - below).max(0.0).powi(draws as i32 - 1) * STEP;
    }
    draws as f64 * probability
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;

    /// Sum of twelve uniform draws, less 6: normal enough up to four standard deviations.
    fn normal_draw(state: &mut u64) -> f32 {
        (0..12)
            .map(|_| {
                *state =
                    state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (*state >> 40) as f32 / (1u64 << 24) as f32
            })
            .sum::<f32>()
            - 6.0
    }

    #[test]
    fn the_meter_finds_the_noise_that_was_put_in_although_a_quarter_of_the_pixels_move() {
        let mut meter = NoiseMeter::default();
        let mut state = 1;
        for i in 0..40_000 {
            let (a, b) = (normal_draw(&mut state), normal_draw(&mut state));
            let moved = if i % 4 == 0 { 60.0 } else { 0.0 };
            meter.add_color(100.0 + 1.5 * a, 1.5 * (b - a) + moved);
            meter.add_depth(1e-3 * (b - a) + moved);
        }
        let noise = meter.noise();
        // A quarter of outliers lifts the median to the 67th percentile of the rest: at most 1.45 times.
        assert!((1.4..2.2).contains(&noise.color_at(100.0)), "{}", noise.color_at(100.0));
        assert!((0.9e-3..1.6e-3).contains(&noise.depth_relative), "{}", noise.depth_relative);
    }

    #[test]
    fn a_picture_that_moves_as_a_whole_is_not_taken_for_a_noisy_one() {
        let mut meter = NoiseMeter::default();
        for i in 0..2000 {
            meter.add_color(20.0, 200.0);
            meter.add_depth(0.8 - i as f32 * 1e-4);
        }
        let noise = meter.noise();
        assert!(noise.color_at(20.0) <= MAX_COLOR_STEPS && noise.depth_relative <= MAX_DEPTH_RELATIVE);
    }

    /// 80×80 pixels of these linear brightnesses, all at one depth.
    fn gray(brightness: impl FnMut(usize) -> f32) -> Frame {
        let color = (0..80 * 80).map(brightness).map(|value| [f16::from_f32(value); 3]);
        Frame {
            color: Grid::from_vec(80, 80, color.collect()),
            inverse_depth: Grid::filled(80, 80, 0.5),
            normal_in_world: None,
            depth_step_relative: 0.0,
            values: crate::capture::Values::default(),
        }
    }

    #[test]
    fn noise_is_that_of_the_pixels_drawn_anew_and_light_that_moves_over_few_is_none() {
        let frame = |shift: &dyn Fn(usize, &mut u64) -> f32| {
            let mut state = 7;
            gray(|pixel| 0.3 + shift(pixel, &mut state))
        };
        let still = frame(&|_, _| 0.0);
        let shadow = frame(&|pixel, _| if pixel % 80 < 4 { -0.2 } else { 0.0 });
        assert_eq!(measure_pairs(&[[&still, &shadow]]), CameraNoise::default());
        // A third of the pixels is drawn anew; a step of sRGB is about 0.0044 there.
        let noisy = |salt: u64| {
            frame(&move |pixel, state| {
                *state ^= salt;
                if pixel % 3 == 0 { 0.0044 * normal_draw(state) } else { 0.0 }
            })
        };
        let noise = measure_pairs(&[[&noisy(11), &noisy(99)]]);
        assert!((0.7..1.3).contains(&noise.color_at(150.0)), "{noise:?}");
    }

    #[test]
    fn light_that_dims_over_a_patterned_surface_is_no_noise() {
        let mut state = 5;
        let albedo: Vec<f32> = (0..80 * 80).map(|_| 0.35 + 0.04 * normal_draw(&mut state)).collect();
        let frame = |dim: f32| gray(|pixel| albedo[pixel] * (1.0 - dim * (pixel % 80) as f32 / 80.0));
        let noise = measure_pairs(&[[&frame(0.0), &frame(0.1)]]);
        // What is left is the rounding of half floats.
        assert!(noise.color_steps_overall < 0.1, "{noise:?}");
    }

    #[test]
    fn a_thing_that_recedes_alone_before_the_sky_has_no_noise_and_its_own_noise_is_found_nonetheless() {
        let frame = |distance: f32, sigma: f32, seed: u64| {
            let mut state = seed;
            let depths = (0..80 * 80).map(|pixel| {
                let (x, y) = ((pixel % 80) as f32, (pixel / 80) as f32);
                let bulge = 0.002 * (x - 40.0).powi(2) / 40.0;
                let is_thing = (20.0..60.0).contains(&x) && (20.0..60.0).contains(&y);
                let noise = if sigma > 0.0 { sigma * normal_draw(&mut state) } else { 0.0 };
                if is_thing { (1.0 + noise) / (distance + bulge) } else { 0.0 }
            });
            Frame { inverse_depth: Grid::from_vec(80, 80, depths.collect()), ..gray(|_| 0.3) }
        };
        let receding = measure_pairs(&[[&frame(2.0, 0.0, 1), &frame(2.018, 0.0, 2)]]);
        assert!(receding.depth_relative < 1e-5, "{receding:?}");
        let noisy = measure_pairs(&[[&frame(2.0, 1e-3, 1), &frame(2.018, 1e-3, 2)]]);
        assert!((0.8e-3..1.25e-3).contains(&noisy.depth_relative), "{noisy:?}");
    }

    #[test]
    fn a_thing_that_passes_through_a_picture_of_few_pixels_is_no_noise() {
        let frame = |from: usize| Frame {
            color: Grid::filled(16, 21, [f16::ONE; 3]),
            inverse_depth: Grid::from_fn(16, 21, |x, y| {
                if (from..from + 8).contains(&x) { 0.5 } else { 0.1 + 1e-3 * y as f32 }
            }),
            ..gray(|_| 1.0)
        };
        let noise = measure_pairs(&[[&frame(0), &frame(4)], [&frame(4), &frame(8)]]);
        assert_eq!(noise.depth_relative.to_bits(), 0);
    }

    #[test]
    fn noise_free_input_measures_exactly_zero() {
        let mut meter = NoiseMeter::default();
        for moved in (0..1000).map(|i| if i % 3 == 0 { 40.0 } else { 0.0 }) {
            meter.add_color(80.0, moved);
            meter.add_depth(moved);
        }
        assert_eq!(meter.noise(), CameraNoise::default());
    }

    #[test]
    fn the_range_distribution_meets_published_tables() {
        // Upper 5 % points of the studentized range with infinite degrees of freedom (Harter 1960).
        for (draws, point) in [(2, 2.772), (5, 3.858), (10, 4.474), (60, 5.764)] {
            assert!((range_probability(draws, point) - 0.95).abs() < 2e-3, "{draws}");
        }
        assert!(granted_range_sigmas(60) > granted_range_sigmas(2));
        assert_eq!(granted_range_sigmas(1), 0.0);
    }
}
