//! Colors as formats of splats mean them.

use crate::color::srgb_from_linear;

/// The spherical harmonic of degree 0, the same in all directions: ½ √(1/π).
const DEGREE_0: f32 = 0.282_094_8;

/// The coefficient of degree 0 that shows a linear color on a display: splats are blended as sRGB-encoded values.
pub(super) fn coefficients(linear: [f32; 3]) -> [f32; 3] {
    linear.map(|channel| (srgb_from_linear(channel) - 0.5) / DEGREE_0)
}

/// The sRGB-encoded byte of a linear channel's coefficient, as SPZ packs it: its unit is 0.15 of a coefficient.
pub(super) fn packed(linear: [f32; 3]) -> [u8; 3] {
    coefficients(linear).map(|coefficient| byte(coefficient * 0.15 * 255.0 + 127.5))
}

/// The nearest byte.
pub(super) fn byte(value: f32) -> u8 {
    (value + 0.5).clamp(0.0, 255.0) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn black_middle_gray_and_white_have_the_coefficients_that_viewers_turn_back() {
        let middle = crate::color::linear_from_srgb(0.5);
        let [black, gray, white] = coefficients([0.0, middle, 1.0]);
        assert!((black + 1.772_454).abs() < 1e-5 && gray.abs() < 1e-5 && (white - 1.772_454).abs() < 1e-5);
        assert_eq!(packed([0.0, middle, 1.0]), [60, 128, 195]);
    }
}
