//! When a pixel counts as static (the paper, §3.2: "remains constant"): the rule, apart from how ranges are found.
//!
//! A pixel is static over a span while the range (maximum − minimum, so that slow drift cannot creep past) of its color and
//! of its relative depth stays within a tolerance plus what the measured noise explains.
//!
//! What noise explains is the range of as many draws as the *whole* sequence has frames, for short spans too. Each channel is
//! granted that of the least noisy brightness that it goes through, and all three what the noisiest of them is granted. A
//! pixel that is static over a span is then static over every part of it, which goes through no more: it does not matter in
//! which order spans are looked at. With the narrower range of fewer draws one pixel in a few thousand would fail in each of
//! the many short spans, and be stored many times over for it.

use half::f16;

use crate::capture::{Intrinsics, ValueChannel};
use crate::preprocess::noise::{BRIGHTNESS_BINS, CameraNoise, brightness_bin, granted_range_sigmas};
use crate::settings::SpanSettings;
use crate::{color, simd};

/// Half floats from 0 up, finite or not.
const POSITIVE_HALVES: usize = 1 << 15;

/// The rule for one camera.
#[derive(Clone, Debug)]
pub struct StaticTest {
    /// Color range that is always granted, 8-bit sRGB steps.
    color_steps: f32,
    /// Color range that is granted to a channel that goes from one brightness class up to another: the least of these.
    noisy_color_steps: [[f32; BRIGHTNESS_BINS]; BRIGHTNESS_BINS],
    /// Depth range that is granted, relative.
    depth_relative: f32,
    /// What of it is the setting alone, without rounding and noise.
    depth_tolerance: f32,
    /// What is granted besides, relative, for an inverse depth of 1; 0 in perspective.
    depth_per_inverse: f32,
    /// Ranges of scalar values that are granted, channel by channel.
    value_tolerances: Vec<f32>,
    /// See [`StaticTest::is_clearly_static`]; by the bits of the larger half float.
    margins: Vec<u16>,
    /// The same in few steps: the least from some bits up to the next. Ascending.
    margin_steps: [(i16, i16); MARGIN_STEPS],
}

/// Channels of the sixteen colors that are looked at together.
pub(crate) const CHANNELS: usize = 3 * 16;

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

/// [`StaticTest::uncertain_colors`] distinguishes halves of octaves: what is darker than 2⁻⁹ counts as the first, what is brighter
/// than 1.5 as the last.
const MARGIN_STEPS: usize = 20;
const DARKEST: usize = 6 << 10;
const HALF_OCTAVE: usize = 1 << 9;

impl StaticTest {
    /// The rule under `settings` for a camera of this noise, whose depth was rounded to relative steps of
    /// `depth_step_relative`, over `frames` frames.
    #[must_use]
    pub fn new(
        settings: &SpanSettings,
        noise: &CameraNoise,
        depth_step_relative: f32,
        frames: usize,
    ) -> Self {
        let sigmas = settings.noise * granted_range_sigmas(frames);
        let color_steps = settings.color_tolerance;
        let granted = noise.color_steps.map(|sigma| color_steps + sigmas * sigma);
        let least =
            |from: usize, to: usize| granted[from..=to.max(from)].iter().copied().fold(f32::MAX, f32::min);
        let margins = margins(&granted);
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
            noisy_color_steps: std::array::from_fn(|from| std::array::from_fn(|to| least(from, to))),
            // A difference of one quantization step either way is no difference.
            depth_relative: settings.depth_tolerance.max(2.0 * depth_step_relative)
                + sigmas * noise.depth_relative,
            depth_tolerance: settings.depth_tolerance
                - settings.depth_tolerance.min(2.0 * depth_step_relative),
            depth_per_inverse: 0.0,
            value_tolerances: Vec::new(),
        }
    }

    /// The same rule for a lens: an orthographic one is granted the setting as a share of
    /// [`Intrinsics::depth_scale`], and rounding and noise, which grow with depth, as all others are.
    #[must_use]
    pub(crate) fn with_lens(self, lens: &Intrinsics) -> Self {
        if !lens.is_orthographic() {
            return self;
        }
        let depth_per_inverse = self.depth_tolerance * lens.depth_scale(1.0) as f32;
        Self { depth_relative: self.depth_relative - self.depth_tolerance, depth_per_inverse, ..self }
    }

    /// The same rule for a capture with these channels of scalar values: none may range over more than its tolerance.
    #[must_use]
    pub fn with_values(self, channels: &[ValueChannel]) -> Self {
        Self { value_tolerances: channels.iter().map(|channel| channel.tolerance).collect(), ..self }
    }

    /// Ranges of scalar values that are granted, channel by channel.
    pub(crate) fn value_tolerances(&self) -> &[f32] {
        &self.value_tolerances
    }

    /// Whether a color channel whose half floats have these smallest and largest bits, neither below 0, stays within the
    /// tolerance by a margin that needs no exact look. Where all channels do, the color is static.
    #[inline(always)]
    pub(crate) fn is_clearly_static(&self, low: i16, high: i16) -> bool {
        (high - low) as u16 <= self.margins[high as usize & (POSITIVE_HALVES - 1)]
    }

    /// Which of sixteen colors are not clearly static, one bit each, by [`StaticTest::is_clearly_static`] of their channels,
    /// three to a color; of dark and very bright ones by a narrower margin.
    #[inline(always)]
    pub(crate) fn uncertain_colors(&self, low: &[i16; CHANNELS], high: &[i16; CHANNELS]) -> u32 {
        let mut margin = [0; CHANNELS];
        for &(from, least) in &self.margin_steps {
            for i in 0..CHANNELS {
                margin[i] = if high[i] >= from { least } else { margin[i] };
            }
        }
        let mut uncertain = [0; CHANNELS];
        for i in 0..CHANNELS {
            uncertain[i] = if high[i] - low[i] > margin[i] { COLOR_BITS[i] } else { 0 };
        }
        simd::joined(&uncertain)
    }

    /// Whether a color whose half floats have these smallest and largest bits, none below 0, is static.
    #[inline(always)]
    pub(crate) fn is_color_static(&self, low: [i16; 3], high: [i16; 3]) -> bool {
        let is_clear = |channel: usize| self.is_clearly_static(low[channel], high[channel]);
        (is_clear(0) & is_clear(1) & is_clear(2)) || self.is_within_granted(low, high)
    }

    #[cold]
    fn is_within_granted(&self, low: [i16; 3], high: [i16; 3]) -> bool {
        let range = color_range_steps(color::steps_table(), &low, &high);
        range <= self.granted_within(low, high)
    }

    /// Color range that is granted to a pixel whose half floats have these smallest and largest bits, none below 0: that of the
    /// noisiest channel, 8-bit sRGB steps.
    #[inline(always)]
    pub(crate) fn granted_within(&self, low: [i16; 3], high: [i16; 3]) -> f32 {
        let table = color::steps_table();
        let class =
            |bits: i16| brightness_bin(table[bits as usize & (POSITIVE_HALVES - 1)]) % BRIGHTNESS_BINS;
        let granted = |channel: usize| self.noisy_color_steps[class(low[channel])][class(high[channel])];
        granted(0).max(granted(1)).max(granted(2))
    }

    /// Color range that is granted to every pixel, whatever the noise, 8-bit sRGB steps.
    #[must_use]
    pub fn granted_color(&self) -> f32 {
        self.color_steps
    }

    /// Depth range that is granted, relative.
    #[must_use]
    pub fn granted_depth(&self) -> f32 {
        if self.depth_per_inverse > 0.0 {
            return self.depth_relative + self.depth_tolerance;
        }
        self.depth_relative
    }

    /// The same at an inverse depth.
    #[inline(always)]
    pub(crate) fn granted_depth_at(&self, inverse_depth: f32) -> f32 {
        self.depth_relative + self.depth_per_inverse * inverse_depth
    }

    /// Relative ranges of depth as they compare with [`StaticTest::granted_depth`], from those of pixels and their inverse depths.
    pub(crate) fn comparable(&self, mut ranges: Vec<f32>, inverse_depths: &[f32]) -> Vec<f32> {
        if self.depth_per_inverse > 0.0 {
            for (range, inverse_depth) in ranges.iter_mut().zip(inverse_depths) {
                *range *= self.granted_depth()
                    / self.granted_depth_at(inverse_depth.max(0.0)).max(f32::MIN_POSITIVE);
            }
        }
        ranges
    }
}

/// How far a color ranges whose half floats have these smallest and largest bits, none below 0: the widest of the three channels,
/// by the table of 8-bit sRGB steps.
#[inline(always)]
pub(crate) fn color_range_steps(table: &[f32], low: &[i16; 3], high: &[i16; 3]) -> f32 {
    let steps =
        |channel: usize| table[high[channel] as usize & 0x7fff] - table[low[channel] as usize & 0x7fff];
    steps(0).max(steps(1)).max(steps(2))
}

/// How far apart two half floats may lie, by the bits of the larger one, to be within what is `granted` to the brightness classes
/// from one to the other.
fn margins(granted: &[f32; BRIGHTNESS_BINS]) -> Vec<u16> {
    let steps = color::steps_table();
    let mut low = 0;
    let margin = |high: usize| {
        if !f16::from_bits(high as u16).is_finite() {
            return 0;
        }
        let least = |low: usize| {
            let classes = brightness_bin(steps[low])..=brightness_bin(steps[high]);
            granted[classes].iter().copied().fold(f32::MAX, f32::min)
        };
        // What is too low for one half is so for all higher ones.
        while low < high && steps[high] - steps[low] > least(low) {
            low += 1;
        }
        (high - low) as u16
    };
    (0..POSITIVE_HALVES).map(margin).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Classes that are unlike each other, as those of real renderers are.
    fn test() -> StaticTest {
        let noise = CameraNoise {
            color_steps: std::array::from_fn(|bin| 0.4 + 0.15 * ((bin * 7) % 16) as f32),
            color_steps_overall: 1.0,
            depth_relative: 0.0,
        };
        StaticTest::new(&SpanSettings::default(), &noise, 0.0, 60)
    }

    /// Ranges of a channel, and whether it is clearly static.
    fn channels(test: &StaticTest) -> impl Iterator<Item = (i16, i16, bool)> + '_ {
        let apart = |high: i16| (0..2000).step_by(23).map(move |apart| ((high - apart).max(0), high));
        let ranges = (0..0x7c00_i16).step_by(37).flat_map(apart);
        ranges.map(|(low, high)| (low, high, test.is_clearly_static(low, high)))
    }

    #[test]
    fn what_is_clearly_static_is_static_when_looked_at_exactly() {
        let test = test();
        let mut clear = 0;
        for (low, high, is_clear) in channels(&test) {
            assert_eq!(is_clear, test.is_within_granted([low; 3], [high; 3]), "{low} to {high}");
            clear += usize::from(is_clear);
            let uncertain = test.uncertain_colors(&[low; CHANNELS], &[high; CHANNELS]);
            assert!(is_clear || uncertain == 0xffff, "{low} to {high}");
        }
        assert!(clear > 10_000, "{clear}");
    }

    #[test]
    fn what_is_static_over_a_range_is_static_over_every_part_of_it() {
        let test = test();
        let others = [[0x2000, 0x2010], [0x3400, 0x3480], [0x3800, 0x3b00]];
        let mut found = 0;
        for (low, high, _) in channels(&test) {
            for other in others {
                let [lows, highs] = [[low, other[0], 0x3000], [high, other[1], 0x3000]];
                if !test.is_color_static(lows, highs) {
                    continue;
                }
                found += 1;
                for share in [0, 1, 5, 8] {
                    let part = |channel: usize| {
                        let (low, high) = (i32::from(lows[channel]), i32::from(highs[channel]));
                        [low + (high - low) * share / 16, high - (high - low) * share / 16 / 2]
                    };
                    let parts = [0, 1, 2].map(part);
                    let [lows, highs] = [0, 1].map(|end| parts.map(|part| part[end] as i16));
                    assert!(test.is_color_static(lows, highs), "{lows:?} to {highs:?}");
                }
            }
        }
        assert!(found > 10_000, "{found}");
    }
}
