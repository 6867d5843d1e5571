//! Noise as a path tracer leaves it: it differs from frame to frame, grows with brightness, and now and then strays far.
//!
//! The noise of a channel has the standard deviation `relative · √(L (L + 0.02))`, nearly proportional to the color
//! with a little more in the dark, and zero mean; two thirds of it are common to all channels, as most of a renderer's
//! noise is in how much light arrives. One pixel in [`OUTLIER_ONE_IN`] strays [`OUTLIER_FACTOR`] times as far.
//! A pixel's noise depends on scene, camera, frame and pixel alone.

use glam::Vec3;

use crate::random::{gaussian_pair, mix};

const OUTLIER_ONE_IN: u64 = 2048;
const OUTLIER_FACTOR: f32 = 3.0;
const COMMON: f32 = 0.816_5;
const OWN: f32 = 0.577_35;

/// The noise of one frame of one camera.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RenderNoise {
    relative: f32,
    stream: u64,
}

impl RenderNoise {
    /// Noise of standard deviation `relative` for a frame; `None` where that is 0.
    pub(crate) fn new(relative: f32, seed: u64, camera: usize, frame: usize) -> Option<Self> {
        let stream = mix(mix(mix(seed) ^ camera as u64) ^ frame as u64);
        (relative > 0.0).then_some(Self { relative, stream })
    }

    /// The color with this frame's noise at pixel number `pixel`; never negative.
    pub(crate) fn apply(&self, color: Vec3, pixel: usize) -> Vec3 {
        let bits = mix(self.stream ^ mix(pixel as u64));
        let [common, r] = gaussian_pair(bits);
        let [g, b] = gaussian_pair(mix(bits ^ 0x51_7c_c1_b7));
        let far = if mix(bits ^ 0x2545_f491).is_multiple_of(OUTLIER_ONE_IN) { OUTLIER_FACTOR } else { 1.0 };
        let strayed = |value, own| with_render_noise(value, self.relative * far, common, own);
        Vec3::new(strayed(color.x, r), strayed(color.y, g), strayed(color.z, b))
    }
}

/// A channel's value, linear and not negative, with noise: `common` is a standard normal number of all channels, `own` one of this
/// channel alone, and `relative` the deviation of a bright value as a share of it. Never negative.
#[must_use]
pub fn with_render_noise(value: f32, relative: f32, common: f32, own: f32) -> f32 {
    let sigma = relative * (value * (value + 0.02)).sqrt();
    (value + sigma * (COMMON * common + OWN * own)).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::RenderNoise;
    use glam::Vec3;

    #[test]
    fn the_noise_has_the_deviation_it_promises_and_no_mean() {
        let noise = RenderNoise::new(0.05, 1, 2, 3).unwrap();
        let color = Vec3::splat(0.5);
        let errors: Vec<f32> = (0..40_000).map(|pixel| noise.apply(color, pixel).y - color.y).collect();
        let mean = errors.iter().sum::<f32>() / errors.len() as f32;
        let deviation = (errors.iter().map(|e| e * e).sum::<f32>() / errors.len() as f32).sqrt();
        let expected = 0.05 * (0.5_f32 * 0.52).sqrt();
        assert!(mean.abs() < 4e-4 && (deviation / expected - 1.0).abs() < 0.03, "{mean} {deviation}");
    }

    #[test]
    fn no_noise_is_asked_for_with_zero() {
        assert!(RenderNoise::new(0.0, 1, 2, 3).is_none());
    }
}
