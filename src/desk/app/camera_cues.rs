//! Signs of cameras: a color, and a pattern once colors repeat. Small signs beside names and pixels of pictures
//! show the same of both, so that one explains the other.
//!
//! Sources: the first seven colors are those of Okabe and Ito (*Color Universal Design*, 2008). What differs: seven lighter ones
//! and seven of other hues follow, all light enough for a dark window and dark enough for a light one.

use egui::{Color32, Painter, Rect, Stroke, StrokeKind, vec2};

/// Colors of cameras in their order; then they repeat, with a pattern.
const COLORS: [u32; 21] = [
    0x56_b4e9, 0xe6_9f00, 0x00_9e73, 0xf0_e442, 0xd5_5e00, 0xcc_79a7,
    0x2c_82c4, // Okabe and Ito, the blue one lighter
    0xa9_d8f3, 0xf2_cd7a, 0x7a_cdb4, 0xa8_a23a, 0xee_a47c, 0xe6_bdd4,
    0x8f_b2d6, // lighter, the yellow one darker
    0x9a_78d0, 0xa8_7c58, 0x2f_bcc8, 0xe2_4f6f, 0x8c_b83c, 0xb0_a5e8,
    0x8e_9aa6, // violet, brown, cyan, red, lime, lavender, slate
];

/// Pixels of a picture that a pattern takes to repeat, in the order in which patterns are used.
const PERIODS: [usize; 3] = [4, 8, 14];

/// Kinds of patterns.
const KINDS: usize = 6;

/// Patterns of every kind and period, and none.
const PATTERNS: usize = 1 + KINDS * PERIODS.len();

/// Brightness of the darker part of a pattern.
const DARKER: f32 = 0.42;

/// The color of a camera by its index.
pub(crate) fn color(index: usize) -> Color32 {
    let hex = COLORS[index % COLORS.len()];
    Color32::from_rgb((hex >> 16) as u8, (hex >> 8) as u8, hex as u8)
}

/// The color of a camera at a pixel of a picture, or at a point of a sign: with its pattern.
pub(crate) fn color_at(index: usize, x: usize, y: usize) -> Color32 {
    let color = color(index);
    if is_darker(index, x, y) { darker(color) } else { color }
}

fn darker(color: Color32) -> Color32 {
    color.lerp_to_gamma(Color32::BLACK, 1.0 - DARKER)
}

/// Whether a pixel lies in the darker part of the pattern of a camera.
fn is_darker(index: usize, x: usize, y: usize) -> bool {
    let Some(pattern) = (index / COLORS.len() % PATTERNS).checked_sub(1) else { return false };
    let period = PERIODS[pattern / KINDS];
    let half = |at: usize| at % period < period / 2;
    match pattern % KINDS {
        0 => half(x + y),
        1 => half(x + period - y % period),
        2 => half(y),
        3 => half(x),
        4 => half(x) == half(y),
        _ => half(x) && half(y),
    }
}

/// Draws the sign of a camera: its color, with its pattern where it has one.
pub(crate) fn sign(painter: &Painter, area: Rect, index: usize) {
    // The rim keeps light colors visible in a light window.
    let dark = darker(color(index));
    painter.rect(area, 2.0, color(index), Stroke::new(1.0, dark), StrokeKind::Inside);
    if index < COLORS.len() {
        return;
    }
    let [columns, rows] = [area.width(), area.height()].map(|side| side.round() as usize);
    for y in 0..rows {
        let points: Vec<usize> = (0..columns).filter(|x| is_darker(index, *x, y)).collect();
        // A run of points at a time: signs are many.
        for run in points.chunk_by(|x, next| x + 1 == *next) {
            let corner = area.min + vec2(run[0] as f32, y as f32);
            painter.rect_filled(Rect::from_min_size(corner, vec2(run.len() as f32, 1.0)), 0.0, dark);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::theme::Tokens;

    /// Side of the smallest sign.
    const SIGN: usize = 10;

    #[test]
    fn of_three_hundred_cameras_no_two_look_alike_even_as_a_small_sign() {
        let looks = |index: usize| -> Vec<[u8; 4]> {
            (0..SIGN * SIGN).map(|at| color_at(index, at % SIGN, at / SIGN).to_array()).collect()
        };
        let cameras = COLORS.len() * PATTERNS;
        let all: std::collections::HashSet<_> = (0..cameras).map(looks).collect();
        assert!(all.len() == cameras && cameras >= 300, "{} of {cameras}", all.len());
    }

    #[test]
    fn no_camera_vanishes_in_either_theme() {
        for dark in [true, false] {
            let background = luminance(Tokens::of(dark).background);
            for index in 0..COLORS.len() {
                // In a light window the rim of a sign is what stands out.
                let own = luminance(if dark { color(index) } else { darker(color(index)) });
                let contrast = (own.max(background) + 0.05) / (own.min(background) + 0.05);
                assert!(contrast >= 4.0, "camera {index}, dark {dark}: {contrast:.2}");
            }
        }
    }

    /// Relative luminance as WCAG defines contrast by.
    fn luminance(color: Color32) -> f32 {
        let linear = |channel: u8| overlook_engine::color::linear_from_srgb(f32::from(channel) / 255.0);
        0.2126 * linear(color.r()) + 0.7152 * linear(color.g()) + 0.0722 * linear(color.b())
    }
}
