//! When a pixel counts as static (the paper, §3.2: "remains constant"): the rule, apart from how ranges are found.
//!
//! A pixel is static over a span while the range (maximum − minimum, so that slow drift cannot creep past) of its color and
//! of its relative depth stays within a tolerance plus what the measured noise explains.
//!
//! What noise explains is the range of as many draws as the *whole* sequence has frames, for short spans too. A pixel that is
//! static over a span is then static over every part of it; with the narrower range of fewer draws one pixel in a few
//! thousand would fail in each of the many short spans, and be stored many times over for it.

use std::collections::VecDeque;

use half::f16;

use super::noise::Noise;
use super::noise_range::granted_range_sigmas;
use crate::color;
use crate::settings::SpanSettings;
use crate::simd;

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
    /// See [`StaticTest::is_clearly_static`]; by the bits of the larger half float.
    margins: Vec<u16>,
    /// The same in few steps: the least from some bits up to the next. Ascending.
    margin_steps: [(i16, i16); MARGIN_STEPS],
}

/// Channels of the sixteen colors that are looked at together.
pub(super) const CHANNELS: usize = 3 * 16;

/// The bit of the color that a channel belongs to.
const COLOR_BITS: [u32; CHANNELS] = {
    let mut bits = [0; CHANNELS];
    let mut i = 0;
    while i < CHANNELS {
        bits[i] = 1 << (i / 3);
        i += 1;
    }
    bits
};

/// [`StaticTest::doubtful_colors`] tells halves of octaves apart: what is darker than 2⁻⁹ counts as the first, what is brighter
/// than 1.5 as the last.
const MARGIN_STEPS: usize = 20;
const DARKEST: usize = 6 << 10;
const HALF_OCTAVE: usize = 1 << 9;

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
        let margins = margins(&noisy_color_steps);
        let margin_step = |step: usize| {
            let first = if step == 0 { 0 } else { DARKEST + step * HALF_OCTAVE };
            let end =
                if step + 1 == MARGIN_STEPS { POSITIVE_HALVES } else { DARKEST + (step + 1) * HALF_OCTAVE };
            let least = margins[first..end].iter().copied().fold(i16::MAX as u16, u16::min);
            (first as i16, least as i16)
        };
        Self {
            color_steps,
            margin_steps: std::array::from_fn(margin_step),
            margins,
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
        (high - low) as u16 <= self.margins[high as usize & (POSITIVE_HALVES - 1)]
    }

    /// Which of sixteen colors are not clearly static, one bit each, by [`StaticTest::is_clearly_static`] of their channels,
    /// three to a color; of dark and very bright ones by a narrower margin.
    #[inline(always)]
    #[must_use]
    pub(super) fn doubtful_colors(&self, low: &[i16; CHANNELS], high: &[i16; CHANNELS]) -> u32 {
        let mut margin = [0; CHANNELS];
        for &(from, least) in &self.margin_steps {
            for i in 0..CHANNELS {
                margin[i] = if high[i] >= from { least } else { margin[i] };
            }
        }
        let mut doubtful = [0; CHANNELS];
        for i in 0..CHANNELS {
            doubtful[i] = if high[i] - low[i] > margin[i] { COLOR_BITS[i] } else { 0 };
        }
        simd::joined(&doubtful)
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
        let range = color_range_steps(color::steps_table(), &low, &high);
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

/// How far a color ranges whose half floats have these smallest and largest bits, none below 0: the widest of the three channels,
/// by the table of 8-bit sRGB steps.
#[inline(always)]
pub(super) fn color_range_steps(table: &[f32], low: &[i16; 3], high: &[i16; 3]) -> f32 {
    let steps =
        |channel: usize| table[high[channel] as usize & 0x7fff] - table[low[channel] as usize & 0x7fff];
    steps(0).max(steps(1)).max(steps(2))
}

/// How far apart two half floats may lie, by the bits of the larger one, that certainly are within the color range granted to any
/// mean between them.
fn margins(granted: &[f32]) -> Vec<u16> {
    let steps = color::steps_table();
    let mut low = 0;
    // Bits from `low` on of which none after them is granted less, ascending: the first is granted the least of all.
    let mut least = VecDeque::new();
    let margin = |high: usize| {
        while least.back().is_some_and(|&other: &usize| granted[other] >= granted[high]) {
            least.pop_back();
        }
        least.push_back(high);
        // Means are rounded, and so are steps.
        while low < high && steps[high] - steps[low] > 0.999 * granted[least[0]] {
            low += 1;
            if least[0] < low {
                least.pop_front();
            }
        }
        if f16::from_bits(high as u16).is_finite() { (high - low) as u16 } else { 0 }
    };
    (0..POSITIVE_HALVES).map(margin).collect()
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
