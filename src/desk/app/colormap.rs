//! Color maps: from numbers to colors that everybody can tell apart.
//!
//! Sources: the sequential map is *viridis* (van der Walt and Smith, 2015), interpolated between nine of its entries; the
//! diverging one is `ColorBrewer`'s `PuOr` (Brewer and Harrower, 2003), safe for color-blind readers. What differs: the diverging
//! map's middle is a light gray so that it stands apart from both white and from pixels without an answer.

use egui::Color32;

use crate::app::theme::{Tokens, rgb};
use overlook_engine::color::steps_from_linear;
use overlook_engine::preprocess::agreement::SampleAgreement;

const VIRIDIS: [u32; 9] =
    [0x44_0154, 0x47_2c7a, 0x3b_518b, 0x2c_718e, 0x21_908d, 0x27_ad81, 0x5c_c863, 0xaa_dc32, 0xfd_e725];

const PURPLE_ORANGE: [u32; 9] =
    [0x54_2788, 0x80_73ac, 0xb2_abd2, 0xd8_daeb, 0xf0_f0f0, 0xfe_e0b6, 0xfd_b863, 0xe0_8214, 0xb3_5806];

fn interpolate(stops: &[u32; 9], position: f32) -> Color32 {
    let scaled = position.clamp(0.0, 1.0) * 8.0;
    let first = (scaled as usize).min(7);
    mix(rgb(stops[first]), rgb(stops[first + 1]), scaled - first as f32)
}

/// A color that grows lighter from 0 to 1; values outside are clamped, NaN is 0.
pub(crate) fn sequential(position: f32) -> Color32 {
    interpolate(&VIRIDIS, if position.is_nan() { 0.0 } else { position })
}

/// Purple at −1, light gray at 0, orange at 1; values outside are clamped, NaN is 0.
pub(crate) fn diverging(value: f32) -> Color32 {
    interpolate(&PURPLE_ORANGE, if value.is_nan() { 0.5 } else { value * 0.5 + 0.5 })
}

/// Black or white, whichever reads better on a color.
pub(crate) fn text_on(background: Color32) -> Color32 {
    if lightness(background) > 110.0 { Color32::BLACK } else { Color32::WHITE }
}

/// Lightness of a color, 0 to 255.
fn lightness(color: Color32) -> f32 {
    let [r, g, b, _] = color.to_array().map(f32::from);
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// An 8-bit sRGB color.
pub(crate) fn opaque([red, green, blue]: [u8; 3]) -> Color32 {
    Color32::from_rgb(red, green, blue)
}

/// A recorded linear color as a display shows it.
pub(crate) fn recorded(linear: [half::f16; 3]) -> Color32 {
    opaque(linear.map(|c| steps_from_linear(c).clamp(0.0, 255.0).round() as u8))
}

/// `over` laid over `under` with the given opacity, 0 to 1, in display space.
pub(crate) fn mix(under: Color32, over: Color32, opacity: f32) -> Color32 {
    let channel = |a: u8, b: u8| (f32::from(a) + (f32::from(b) - f32::from(a)) * opacity).round() as u8;
    let ([r, g, b, _], [over_r, over_g, over_b, _]) = (under.to_array(), over.to_array());
    Color32::from_rgb(channel(r, over_r), channel(g, over_g), channel(b, over_b))
}

/// A color of a picture, tinted by how its sample agrees with other cameras; confirmed colors stay readable.
pub(crate) fn agreeing(own: Color32, agreement: SampleAgreement, tokens: &Tokens) -> Color32 {
    let opacity = if agreement == SampleAgreement::Contradicted { 0.85 } else { 0.6 };
    mix(dimmed(own, 0.9), tokens.of_agreement(agreement), opacity)
}

/// `color` as a gray of its lightness, at `strength` of its brightness.
pub(crate) fn dimmed(color: Color32, strength: f32) -> Color32 {
    Color32::from_gray((lightness(color) * strength).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sequential_map_grows_lighter_throughout() {
        let steps: Vec<f32> = (0..=64).map(|i| lightness(sequential(i as f32 / 64.0))).collect();
        assert!(steps.is_sorted(), "{steps:?}");
    }

    #[test]
    fn the_diverging_map_is_lightest_in_the_middle_and_ends_in_different_colors() {
        assert_eq!(diverging(0.0), Color32::from_rgb(240, 240, 240));
        for i in 1..=16 {
            let value = i as f32 / 16.0;
            assert!(lightness(diverging(value)) < lightness(diverging(value - 1.0 / 16.0)));
            assert!(lightness(diverging(-value)) < lightness(diverging(1.0 / 16.0 - value)));
        }
        assert!(diverging(-1.0).b() > diverging(-1.0).r() && diverging(1.0).r() > diverging(1.0).b());
        assert_eq!(diverging(f32::NAN), diverging(0.0));
    }
}
