//! When a pixel counts as static (the paper, §3.2: "remains constant"): the rule, apart from how ranges are found.
//!
//! A pixel is static over a span while the range (maximum − minimum, so that slow drift cannot creep past) of its color and
//! of its relative depth stays within a tolerance plus what the measured noise explains.
//!
//! What noise explains is the range of as many draws as the *whole* sequence has frames, for short spans too. A pixel that is
//! static over a span is then static over every part of it; with the narrower range of fewer draws one pixel in a few
//! thousand would fail in each of the many short spans, and be stored many times over for it.

use half::f16;

use super::noise::{BRIGHTNESS_BINS, Noise, granted_range_sigmas};
use crate::color;
use crate::settings::SpanSettings;

/// Half floats from 0 up, finite or not.
const POSITIVE_HALVES: usize = 1 << 15;

/// The rule for one camera.
#[derive(Clone, Debug)]
pub struct StaticTest {
    /// Color range that is always granted, 8-bit sRGB steps.
    color_steps: f32,
    /// Color range that is granted for a channel of a mean value, by the bits of the half float.
    noisy_color_steps: Vec<f32>,
    /// Depth range that is granted, relative.
    depth_relative: f32,
    /// See [`StaticTest::is_clearly_static`].
    clear_bits: [u16; EXPONENTS],
}

/// Exponents of half floats.
const EXPONENTS: usize = 32;

/// Color ranges below this, 8-bit sRGB steps, reach over one brightness class at most.
const ONE_CLASS: f32 = 256.0 / BRIGHTNESS_BINS as f32;

impl StaticTest {
    /// The rule under `settings` for a camera of this noise, whose depth was rounded to relative steps of
    /// `depth_step_relative`, over `frames` frames.
    #[must_use]
    pub fn new(settings: &SpanSettings, noise: &Noise, depth_step_relative: f32, frames: usize) -> Self {
        let sigmas = settings.noise * granted_range_sigmas(frames);
        let color_steps = settings.color_tolerance;
        let granted = |bits| {
            let steps = color::steps_from_linear(f16::from_bits(bits));
            color_steps + sigmas * noise.color_at(steps)
        };
        let noisy_color_steps: Vec<f32> = (0..POSITIVE_HALVES as u16).map(granted).collect();
        Self {
            color_steps,
            clear_bits: std::array::from_fn(|exponent| clear_bits(&noisy_color_steps, exponent as u16)),
            noisy_color_steps,
            // A difference of one quantization step either way is no difference.
            depth_relative: settings.depth_tolerance.max(2.0 * depth_step_relative)
                + sigmas * noise.depth_relative,
        }
    }

    /// Whether a pixel whose color has this range (8-bit sRGB steps, the widest channel), whose depth has this relative
    /// range and whose color has this mean is static. An infinite range is not.
    #[inline(always)]
    #[must_use]
    pub fn is_static(&self, color_range: f32, depth_range: f32, mean: impl FnOnce() -> [f16; 3]) -> bool {
        depth_range <= self.depth_relative
            && (color_range <= self.color_steps || color_range <= self.granted(mean()))
    }

    /// Whether a color channel whose half floats have these smallest and largest bits, neither below 0, stays within the
    /// tolerance by a margin that needs no exact look. Where all channels do, the color is static.
    #[inline(always)]
    #[must_use]
    pub fn is_clearly_static(&self, low: i16, high: i16) -> bool {
        (high - low) as u16 <= self.clear_bits[(high >> 10) as usize & (EXPONENTS - 1)]
    }

    /// Whether a color whose half floats have these smallest and largest bits, none below 0, is static around its mean, which
    /// is asked for where a look at the range is not enough.
    #[inline(always)]
    #[must_use]
    pub fn is_color_static(&self, low: [i16; 3], high: [i16; 3], mean: impl FnOnce() -> [f32; 3]) -> bool {
        let is_clear = |channel: usize| self.is_clearly_static(low[channel], high[channel]);
        (is_clear(0) & is_clear(1) & is_clear(2)) || self.is_color_static_at(low, high, mean())
    }

    #[cold]
    fn is_color_static_at(&self, low: [i16; 3], high: [i16; 3], mean: [f32; 3]) -> bool {
        let table = color::steps_table();
        let steps =
            |channel: usize| table[high[channel] as usize & 0x7fff] - table[low[channel] as usize & 0x7fff];
        let range = steps(0).max(steps(1)).max(steps(2));
        range <= self.color_steps || range <= self.granted_around(mean)
    }

    /// [`StaticTest::granted`] of a mean in single precision, rounded down to a half float.
    #[inline(always)]
    #[must_use]
    pub fn granted_around(&self, mean: [f32; 3]) -> f32 {
        // The exponent of a half float in its place: the difference of the exponent biases is 112.
        let bits = |value: f32| ((value.max(0.0) * f32::from_bits(0x0780_0000)).to_bits() >> 13) as usize;
        mean.iter()
            .map(|&value| self.noisy_color_steps[bits(value) & (POSITIVE_HALVES - 1)])
            .fold(0.0, f32::max)
    }

    /// Color range that is granted to a pixel of this mean color, 8-bit sRGB steps.
    #[inline(always)]
    #[must_use]
    pub fn granted(&self, mean: [f16; 3]) -> f32 {
        mean.iter()
            .map(|channel| self.noisy_color_steps[(channel.to_bits() as i16).max(0) as usize])
            .fold(0.0, f32::max)
    }

    /// Color range that is granted to every pixel, whatever the noise, 8-bit sRGB steps.
    #[must_use]
    pub fn granted_color(&self) -> f32 {
        self.color_steps
    }

    /// Depth range that is granted, relative.
    #[must_use]
    pub fn granted_depth(&self) -> f32 {
        self.depth_relative
    }
}

/// How far apart two half floats may lie, the larger of this exponent, that certainly are within the color range granted to
/// any mean between them.
///
/// Within an exponent the curve from bits to steps is concave, and it begins the steeper the larger the exponent: so the
/// first step of the larger one's exponent is the longest on the way.
fn clear_bits(granted: &[f32], exponent: u16) -> u16 {
    let steps = |bits: u16| color::steps_from_linear(f16::from_bits(bits));
    let first = exponent << 10;
    if f16::from_bits(first + 1).is_nan() {
        return 0;
    }
    let mut lowest = first;
    while lowest > 0 && steps(first) - steps(lowest) <= ONE_CLASS {
        lowest = lowest.saturating_sub(64);
    }
    let least = granted[lowest as usize..=(first + 1023) as usize].iter().copied().fold(ONE_CLASS, f32::min);
    let longest = (1..4).map(|i| steps(first + i) - steps(first + i - 1)).fold(1e-6, f32::max);
    // The margin covers what the steps were rounded with.
    (0.999 * least / longest).min(f32::from(first + 1023)) as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_clearly_static_is_static_when_looked_at_exactly() {
        let noise = Noise {
            color_steps: std::array::from_fn(|bin| 0.4 + 0.15 * ((bin * 7) % 16) as f32),
            color_steps_overall: 1.0,
            depth_relative: 0.0,
        };
        let test = StaticTest::new(&SpanSettings::default(), &noise, 0.0, 60);
        let mut clear = 0;
        for high in (0..0x7c00_i16).step_by(37) {
            for apart in (0..2000).step_by(23) {
                let low = (high - apart).max(0);
                if !test.is_clearly_static(low, high) {
                    continue;
                }
                clear += 1;
                let [low, high] = [low, high].map(|bits| f16::from_bits(bits as u16));
                let range = color::steps_from_linear(high) - color::steps_from_linear(low);
                for share in [0.0, 0.3, 0.7, 1.0] {
                    let mean = f16::from_f32(low.to_f32() + share * (high.to_f32() - low.to_f32()));
                    assert!(test.is_static(range, 0.0, || [mean; 3]), "{low} to {high}: {range}");
                }
            }
        }
        assert!(clear > 10_000, "{clear}");
    }
}
