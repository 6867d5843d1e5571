//! Noise measured from the capture itself, and the range that noise alone explains.
//!
//! Purpose: a pixel that shows the same surface in every frame still differs from frame to frame where the renderer
//! samples light at random or the sensor is noisy. The standard deviation is taken from differences of successive
//! frames, whose median is blind to the few pixels that really move:
//! `σ = median |x(t+1) − x(t)| / (√2 · 0.6745)` for a normal distribution.
//!
//! Source: the median absolute deviation (Hampel 1974) of first differences; the range of `n` normal draws is that of
//! Tippett, *On the extreme individuals and the range of samples*, Biometrika 1925:
//! `P(range ≤ r) = n ∫ φ(x) [Φ(x + r) − Φ(x)]^(n−1) dx`.
//! What differs: color noise is measured per brightness, because a renderer's noise grows with light.

use serde::{Deserialize, Serialize};

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

/// Where more than half of a picture moves, the median no longer speaks of noise. No renderer and no sensor worth
/// recording with is noisier than this: standard deviation of color, 8-bit sRGB steps, and of depth, relative.
const MAX_COLOR_STEPS: f32 = 8.0;
const MAX_DEPTH_RELATIVE: f32 = 0.01;

/// √2 · Φ⁻¹(0.75): from the median absolute difference of two draws to their standard deviation.
const MEDIAN_DIFFERENCE_PER_SIGMA: f32 = 0.953_87;

/// Share of static pixels that the granted range must hold; what is lost goes to the foreground, which costs bytes only.
const STATIC_SHARE: f64 = 0.9998;

/// Where fewer than one in so many pixels of resting surfaces change at all, light moves and nothing is noisy.
const FEWEST_REDRAWN: u64 = 10;

/// Depth that changes by more than this, or by so many times its noise, is that of another surface.
const SAME_SURFACE_RELATIVE: f32 = 1e-3;
const SAME_SURFACE_SIGMAS: f32 = 6.0;

/// Noise is measured on every `NOISE_ROW_STRIDE`-th row: plenty for a median.
const NOISE_ROW_STRIDE: usize = 4;

/// Noise of one camera.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Noise {
    /// Standard deviation of color over time, 8-bit sRGB steps, per brightness class.
    pub color_steps: [f32; BRIGHTNESS_BINS],
    /// Standard deviation of color over time, 8-bit sRGB steps, all brightness classes together.
    pub color_steps_overall: f32,
    /// Relative standard deviation of depth over time.
    pub depth_relative: f32,
}

impl Noise {
    /// Standard deviation of a color channel whose value is `steps` (8-bit sRGB).
    #[must_use]
    pub fn color_at(&self, steps: f32) -> f32 {
        self.color_steps[brightness_bin(steps)]
    }
}

fn brightness_bin(steps: f32) -> usize {
    ((steps * (BRIGHTNESS_BINS as f32 / 256.0)) as usize).min(BRIGHTNESS_BINS - 1)
}

/// Collects differences of successive frames. Counting is exact, so the order of calls does not matter.
#[derive(Clone)]
pub struct NoiseMeter {
    color: Vec<u64>,
    depth: Vec<u64>,
    /// Pixels that were looked at for a change of color, and those that had one, where they are told apart.
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
    /// Counts the change of one color channel between two frames, 8-bit sRGB steps.
    pub fn add_color(&mut self, before_steps: f32, after_steps: f32) {
        let bin = (((after_steps - before_steps).abs() / COLOR_BIN_STEPS) as usize).min(COLOR_BINS - 1);
        self.color[brightness_bin(before_steps) * COLOR_BINS + bin] += 1;
    }

    /// Counts the change of a finite depth between two frames, given as inverse depths (both above 0).
    pub fn add_depth(&mut self, before: f32, after: f32) {
        let relative = (after - before).abs() / before.max(after);
        let bin = if relative == 0.0 {
            0
        } else {
            let octaves = (relative.log2() + DEPTH_OCTAVES).max(0.0);
            1 + ((octaves * DEPTH_BINS_PER_OCTAVE) as usize).min(DEPTH_BINS - 2)
        };
        self.depth[bin] += 1;
    }

    /// The standard deviations that the counted differences speak for.
    #[must_use]
    pub fn noise(&self) -> Noise {
        let mut overall = vec![0; COLOR_BINS];
        for class in self.color.chunks_exact(COLOR_BINS) {
            overall.iter_mut().zip(class).for_each(|(sum, count)| *sum += count);
        }
        let is_motion = self.redrawn * FEWEST_REDRAWN < self.looked_at;
        let color_sigma = |bins: &[u64]| {
            if is_motion {
                return 0.0;
            }
            // Bin 0 means "no difference that matters", so that noise-free input measures exactly 0.
            median_bin(bins).map_or(0.0, |bin| {
                if bin < 1.0 {
                    0.0
                } else {
                    (bin * COLOR_BIN_STEPS / MEDIAN_DIFFERENCE_PER_SIGMA).min(MAX_COLOR_STEPS)
                }
            })
        };
        let color_steps_overall = color_sigma(&overall);
        let mut color_steps = [color_steps_overall; BRIGHTNESS_BINS];
        for (sigma, class) in color_steps.iter_mut().zip(self.color.chunks_exact(COLOR_BINS)) {
            if class.iter().sum::<u64>() >= MIN_DIFFERENCES {
                *sigma = color_sigma(class);
            }
        }
        let depth_relative = median_bin(&self.depth).map_or(0.0, |bin| {
            if bin < 1.0 {
                0.0
            } else {
                let difference = ((bin - 1.0) / DEPTH_BINS_PER_OCTAVE - DEPTH_OCTAVES).exp2();
                (difference / MEDIAN_DIFFERENCE_PER_SIGMA).min(MAX_DEPTH_RELATIVE)
            }
        });
        Noise { color_steps, color_steps_overall, depth_relative }
    }
}

/// Counts the changes of every pixel between two successive frames.
pub fn measure_noise(meter: &mut NoiseMeter, before: &Frame, after: &Frame) {
    let steps = color::steps_table();
    for_each_pair(before, after, |depths, colors| {
        meter.add_depth(depths[0], depths[1]);
        for channel in 0..3 {
            let [before, after] = colors.map(|color| steps[color[channel].to_bits() as usize]);
            meter.add_color(before, after);
        }
    });
}

/// The noise of a camera from some pairs of successive frames.
///
/// Differences of color count where the surface is the same in both frames and the color is not. A renderer that draws the
/// same random numbers for every frame gives a pixel that nothing moving shines on the very same color again, which says
/// nothing about its noise; how the others differ does.
#[must_use]
pub fn measure_pairs(pairs: &[[&Frame; 2]]) -> Noise {
    let mut meter = NoiseMeter::default();
    for [before, after] in pairs {
        for_each_pair(before, after, |depths, _| meter.add_depth(depths[0], depths[1]));
    }
    let limit = SAME_SURFACE_RELATIVE.max(SAME_SURFACE_SIGMAS * meter.noise().depth_relative);
    let steps = color::steps_table();
    for [before, after] in pairs {
        for_each_pair(before, after, |[before, after], colors| {
            if (after - before).abs() > limit * before.max(after) {
                return;
            }
            meter.looked_at += 1;
            if colors[0] == colors[1] {
                return;
            }
            meter.redrawn += 1;
            for channel in 0..3 {
                let [before, after] = colors.map(|color| steps[color[channel].to_bits() as usize]);
                meter.add_color(before, after);
            }
        });
    }
    meter.noise()
}

/// Calls `add` with the inverse depths and colors of pixels that have a finite depth in both frames.
fn for_each_pair(before: &Frame, after: &Frame, mut add: impl FnMut([f32; 2], [[half::f16; 3]; 2])) {
    let (_, height) = after.size();
    for y in (0..height).step_by(NOISE_ROW_STRIDE) {
        let depths = before.inverse_depth.row(y).iter().zip(after.inverse_depth.row(y));
        let colors = before.color.row(y).iter().zip(after.color.row(y));
        for ((&w_before, &w_after), (&c_before, &c_after)) in depths.zip(colors) {
            // The sky is often a constant and would speak for a noise-free scene.
            if w_before > 0.0 && w_after > 0.0 {
                add([w_before, w_after], [c_before, c_after]);
            }
        }
    }
}

/// Position of the median in a histogram, in bins, interpolated within its bin; `None` where nothing was counted.
fn median_bin(bins: &[u64]) -> Option<f32> {
    let total: u64 = bins.iter().sum();
    if total == 0 {
        return None;
    }
    let half = total as f64 / 2.0;
    let mut below = 0.0;
    for (bin, &count) in bins.iter().enumerate() {
        let count = count as f64;
        if below + count >= half {
            return Some(bin as f32 + ((half - below) / count) as f32);
        }
        below += count;
    }
    None
}

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
            meter.add_color(100.0 + 1.5 * a, 100.0 + 1.5 * b + moved);
            meter.add_depth(0.5 * (1.0 + 1e-3 * a), 0.5 * (1.0 + 1e-3 * b) + moved);
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
            meter.add_color(20.0, 220.0);
            meter.add_depth(0.1 + i as f32 * 1e-4, 0.9);
        }
        let noise = meter.noise();
        assert!(noise.color_at(20.0) <= MAX_COLOR_STEPS && noise.depth_relative <= MAX_DEPTH_RELATIVE);
    }

    #[test]
    fn noise_is_that_of_the_pixels_drawn_anew_and_light_that_moves_over_few_is_none() {
        let frame = |shift: &dyn Fn(usize, &mut u64) -> f32| {
            let mut state = 7;
            let color: Vec<_> =
                (0..80 * 80).map(|pixel| [half::f16::from_f32(0.3 + shift(pixel, &mut state)); 3]).collect();
            Frame {
                color: crate::grid::Grid::from_vec(80, 80, color),
                inverse_depth: crate::grid::Grid::filled(80, 80, 0.5),
                normal_in_world: None,
                depth_step_relative: 0.0,
            }
        };
        let still = frame(&|_, _| 0.0);
        let shadow = frame(&|pixel, _| if pixel % 80 < 4 { -0.2 } else { 0.0 });
        assert_eq!(measure_pairs(&[[&still, &shadow]]), Noise::default());
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
    fn noise_free_input_measures_exactly_zero() {
        let mut meter = NoiseMeter::default();
        for i in 0..1000 {
            let moved = if i % 3 == 0 { 40.0 } else { 0.0 };
            meter.add_color(80.0, 80.0 + moved);
            meter.add_depth(0.25, 0.25 + moved);
        }
        assert_eq!(meter.noise(), Noise::default());
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
