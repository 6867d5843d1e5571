//! Noise: how much the same surface differs from frame to frame, measured on a few pairs of frames.
//!
//! Noise between cameras: how far apart two cameras put one surface, and how differently they color it.
//!
//! Purpose: noise over time does not contain errors that a sensor makes in every frame alike, and captures of one frame have none.
//! Poses and lenses that are slightly off also separate the surfaces of different cameras, just as noise does. Noise between cameras
//! is measured per camera and class of depth, since the noise of depth sensors grows with depth.

mod block_motion;
mod estimate;
mod frame_pairs;

pub use estimate::{BRIGHTNESS_BINS, CameraNoise, granted_range_sigmas, measure_pairs};
pub(crate) use estimate::{bin_of_rank, brightness_bin, rank_of_share};
pub(crate) use frame_pairs::NoiseFrames;

/// Classes of depth: two to an octave of the inverse depth.
pub(crate) const DEPTH_CLASSES: usize = 128;

/// Bits of an `f32` below those that tell the classes apart.
const CLASS_SHIFT: u32 = 22;

/// The class before that of 2⁻³².
const FIRST_CLASS: u32 = ((127 - 32) << 23) >> CLASS_SHIFT;

/// Noise of one camera as others see it. It is zero where a camera is not noisy.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NoiseBetween {
    /// Relative standard deviation of depth, per class of depth.
    pub(crate) depth_relative: [f32; DEPTH_CLASSES],
    /// Standard deviation of color, 8-bit sRGB steps, per brightness class.
    pub(crate) color_steps: [f32; BRIGHTNESS_BINS],
}

impl NoiseBetween {
    /// Relative standard deviation of a depth, given its inverse, which is not negative.
    #[inline(always)]
    pub(crate) fn depth_at(&self, inverse_depth: f32) -> f32 {
        self.depth_relative[depth_class(inverse_depth)]
    }

    /// Standard deviation of a color channel whose value is `steps`, both 8-bit sRGB steps.
    #[inline(always)]
    pub(crate) fn color_at(&self, steps: f32) -> f32 {
        self.color_steps[brightness_bin(steps)]
    }
}

/// The class of a depth, given its inverse: nearer depths have higher classes.
#[inline(always)]
pub(crate) fn depth_class(inverse_depth: f32) -> usize {
    let class = (inverse_depth.max(0.0).to_bits() >> CLASS_SHIFT).saturating_sub(FIRST_CLASS);
    (class as usize).min(DEPTH_CLASSES - 1)
}

/// A depth in the middle of a class.
pub(crate) fn depth_of_class(class: usize) -> f32 {
    let bits = ((class as u32 + FIRST_CLASS) << CLASS_SHIFT) | 1 << (CLASS_SHIFT - 1);
    f32::from_bits(bits).recip()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_class_of_depth_is_half_an_octave_and_holds_the_depth_in_its_middle() {
        for depth in [0.01_f32, 0.7, 1.0, 3.3, 250.0] {
            let class = depth_class(depth.recip());
            assert_eq!(depth_class(depth_of_class(class).recip()), class);
            assert!((depth_of_class(class) / depth).log2().abs() < 0.6, "{depth}");
        }
        assert!(depth_class(1.0 / 2.0) < depth_class(1.0));
        assert_eq!(
            [depth_class(0.0), depth_class(-1.0), depth_class(f32::INFINITY)],
            [0, 0, DEPTH_CLASSES - 1]
        );
    }
}
