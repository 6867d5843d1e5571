//! Linear Rec.709 to and from what a display shows, and steps of it.
//!
//! Source: IEC 61966-2-1 (sRGB). What differs: above 1 the curve goes on, so that bright scene-referred values still
//! differ by steps; displays clip them.

use std::sync::LazyLock;

use half::f16;

/// sRGB-encoded value (0 to 1 for displayable input) of a linear one. Negative input gives 0.
#[must_use]
pub fn srgb_from_linear(linear: f32) -> f32 {
    if linear <= 0.0 {
        0.0
    } else if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

/// Linear value of an sRGB-encoded one.
#[must_use]
pub fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded.max(0.0) / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// Brighter colors are lights and their mirror images: all count as this luminance.
const BRIGHTEST: f32 = 2.0;

/// How bright a linear Rec.709 color is, for comparing pictures: the square root of its luminance. Noise is about as wide in dark parts as in
/// bright ones, and a change of exposure is a factor.
pub(crate) fn brightness([red, green, blue]: [f32; 3]) -> f32 {
    (0.2126 * red + 0.7152 * green + 0.0722 * blue).clamp(0.0, BRIGHTEST).sqrt()
}

/// 8-bit sRGB of a linear value, clipped and rounded.
#[must_use]
pub fn srgb8_from_linear(linear: f32) -> u8 {
    (srgb_from_linear(linear) * 255.0 + 0.5).clamp(0.0, 255.0) as u8
}

static STEPS: LazyLock<Vec<f32>> = LazyLock::new(|| {
    (0..=u16::MAX)
        .map(|bits| {
            let linear = f16::from_bits(bits).to_f32();
            if linear.is_finite() { srgb_from_linear(linear) * 255.0 } else { 0.0 }
        })
        .collect()
});

/// The table from the bits of a half float (linear) to 8-bit sRGB steps, unrounded: 0 to 255 on a display, and on
/// above white. 65,536 entries.
#[must_use]
pub fn steps_table() -> &'static [f32] {
    &STEPS
}

/// 8-bit sRGB steps of a linear half float, unrounded and not clipped above.
#[must_use]
pub fn steps_from_linear(linear: f16) -> f32 {
    STEPS[linear.to_bits() as usize]
}

/// 2¹¹²: the difference between the exponents' biases of single floats and half floats.
pub(crate) const WIDENING: f32 = f32::from_bits(0x7780_0000);

/// A half float widened by integer arithmetic alone, so that it is vectorized; colors are finite.
#[inline(always)]
#[must_use]
pub(crate) fn widened(bits: i16) -> f32 {
    widened_small(bits) * WIDENING
}

/// The numbers times 2⁻¹¹²: sign, exponent and mantissa are in their place, and the exponent is the half float's. Sums of such numbers
/// are those of the numbers themselves times 2⁻¹¹²: the least half float, 2⁻²⁴, is as exact as the largest.
#[inline(always)]
pub(crate) fn widened_small(bits: i16) -> f32 {
    f32::from_bits((i32::from(bits) << 16 >> 3) as u32 & 0x8fff_ffff)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encoding_and_decoding_are_inverses() {
        for i in 0..=1000 {
            let linear = i as f32 / 500.0;
            assert!((linear_from_srgb(srgb_from_linear(linear)) - linear).abs() < 1e-5);
        }
    }

    #[test]
    fn published_srgb_values_are_met() {
        assert_eq!(srgb8_from_linear(0.0), 0);
        assert_eq!(srgb8_from_linear(1.0), 255);
        assert_eq!(srgb8_from_linear(0.215_861), 128);
        assert_eq!(srgb8_from_linear(7.0), 255);
        assert_eq!(steps_from_linear(f16::NAN), 0.0);
    }
}
