//! When a pixel counts as static (the paper, §3.2: "remains constant"): the rule, apart from how ranges are found.
//!
//! A pixel is static over a span while the range (maximum − minimum, so that slow drift cannot creep past) of its color and
//! of its relative depth stays within a tolerance plus what the measured noise explains.
//!
//! What noise explains is the range of as many draws as the *whole* sequence has frames, for short spans too. A pixel that is
//! static over a span is then static over every part of it; with the narrower range of fewer draws one pixel in a few
//! thousand would fail in each of the many short spans, and be stored many times over for it.

use half::f16;

use super::noise::{Noise, granted_range_sigmas};
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
}

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
        Self {
            color_steps,
            noisy_color_steps: (0..POSITIVE_HALVES as u16).map(granted).collect(),
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
