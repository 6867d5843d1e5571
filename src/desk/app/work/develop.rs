//! Turns linear color into what the screen shows, as both views and exported pictures do.

use egui::Color32;

use crate::app::colormap::sequential;
use crate::app::model::look::{Background, Channel, Display, LEVELS, PictureHistogram, ToneCurve};
use overlook_engine::color::{linear_from_srgb, srgb_from_linear, srgb8_from_linear};
use overlook_engine::grid::Grid;
use overlook_engine::render::{NO_IMAGE, Picture};

/// Weights of red, green and blue in luminance (Rec.709).
const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// Middle gray, from which false colors count stops.
const MIDDLE_GRAY: f32 = 0.18;

/// Stops from middle gray to either end of the false colors.
const STOPS: f32 = 6.0;

/// Marks of what is above white, below black, and no finite number.
const MARKS: [Color32; 3] =
    [Color32::from_rgb(255, 0, 64), Color32::from_rgb(40, 90, 255), Color32::from_rgb(255, 0, 255)];

/// Side of the squares that show a transparent background, pixels.
const SQUARE: usize = 8;

/// Pixels that a histogram looks at, at most, to find the brightest hundredth.
const SAMPLED: usize = 8192;

/// A linear color as displayed.
pub(crate) fn displayed(display: &Display, linear: [f32; 3]) -> Color32 {
    if display.is_neutral() {
        let [r, g, b] = linear.map(srgb8_from_linear);
        return Color32::from_rgb(r, g, b);
    }
    let [above, below, not_finite] = MARKS;
    if display.marks_clipped && linear.iter().any(|c| !c.is_finite()) {
        return not_finite;
    }
    let gain = display.exposure.exp2();
    let color = channel(display.channel, linear.map(|c| c * gain + display.offset));
    let cuts_off = matches!(display.curve, ToneCurve::Srgb | ToneCurve::Gamma);
    if display.marks_clipped && cuts_off {
        if color.iter().any(|c| *c > 1.0) {
            return above;
        }
        if color.iter().any(|c| *c < 0.0) {
            return below;
        }
    }
    let luminance = luminance(color);
    let encoded = match display.curve {
        ToneCurve::Srgb => color.map(srgb_from_linear),
        ToneCurve::Gamma => color.map(|c| c.max(0.0).powf(1.0 / display.gamma)),
        ToneCurve::Filmic => color.map(|c| srgb_from_linear(filmic(c))),
        ToneCurve::Reinhard => color.map(|c| srgb_from_linear(c / (1.0 + luminance.max(0.0)))),
        ToneCurve::FalseColor => {
            let stops = (luminance.max(f32::MIN_POSITIVE) / MIDDLE_GRAY).log2();
            return sequential(stops / (2.0 * STOPS) + 0.5);
        }
    };
    let [r, g, b] = encoded.map(|c| (c * 255.0 + 0.5).clamp(0.0, 255.0) as u8);
    Color32::from_rgb(r, g, b)
}

fn luminance(color: [f32; 3]) -> f32 {
    color.iter().zip(LUMINANCE).map(|(c, weight)| c * weight).sum()
}

fn channel(channel: Channel, color: [f32; 3]) -> [f32; 3] {
    match channel {
        Channel::Color => color,
        Channel::Red => [color[0]; 3],
        Channel::Green => [color[1]; 3],
        Channel::Blue => [color[2]; 3],
        Channel::Luminance => [luminance(color); 3],
    }
}

/// Narkowicz's fit; 0 for what is below black.
fn filmic(c: f32) -> f32 {
    let c = c.max(0.0);
    ((c * (2.51 * c + 0.03)) / (c * (2.43 * c + 0.59) + 0.14)).min(1.0)
}

/// The background color of a pixel at infinity; `None` keeps the recorded color.
pub(crate) fn background_at(background: Background, x: usize, y: usize) -> Option<Color32> {
    match background {
        Background::Recorded => None,
        Background::Solid([r, g, b]) => Some(Color32::from_rgb(r, g, b)),
        Background::Transparent => {
            Some(Color32::from_gray(if (x / SQUARE + y / SQUARE).is_multiple_of(2) { 90 } else { 130 }))
        }
    }
}

/// The picture as a file shows it: developed, before the chosen background. A transparent one is left out.
pub(crate) fn developed(display: &Display, picture: &Picture) -> Option<Picture> {
    if display.is_neutral() {
        return None;
    }
    let mut developed = picture.clone();
    let (width, height) = picture.color.size();
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let at_infinity = picture.inverse_depth[(x, y)] == 0.0;
        if at_infinity && display.background == Background::Transparent {
            (developed.inverse_depth[(x, y)], developed.image[(x, y)]) = (-1.0, NO_IMAGE);
            developed.color[(x, y)] = [0.0; 3];
            continue;
        }
        let background = background_at(display.background, x, y).filter(|_| at_infinity);
        let shown = background.unwrap_or_else(|| displayed(display, picture.color[(x, y)]));
        let [r, g, b, _] = shown.to_array();
        developed.color[(x, y)] = [r, g, b].map(|c| linear_from_srgb(f32::from(c) / 255.0));
    }
    Some(developed)
}

/// How bright a picture is: its linear and its displayed colors.
pub(crate) fn histogram_of<C>(
    linear: &Grid<C>,
    shown: &Grid<Color32>,
    value: impl Fn(&C) -> [f32; 3],
) -> PictureHistogram {
    let mut counts = [[0; LEVELS]; 3];
    let (mut at_white, mut at_black, mut not_finite) = (0, 0, 0);
    for color in shown.as_slice() {
        let channels = [color.r(), color.g(), color.b()];
        for (counts, channel) in counts.iter_mut().zip(channels) {
            counts[usize::from(channel) * LEVELS / 256] += 1;
        }
        at_white += u32::from(channels.contains(&u8::MAX));
        at_black += u32::from(channels == [0; 3]);
    }
    let step = linear.as_slice().len().div_ceil(SAMPLED).max(1);
    let mut bright = Vec::with_capacity(SAMPLED);
    for (index, color) in linear.as_slice().iter().enumerate() {
        let [r, g, b] = value(color);
        let largest = r.max(g).max(b);
        if !(r.is_finite() && g.is_finite() && b.is_finite()) {
            not_finite += 1;
        } else if index % step == 0 {
            bright.push(largest);
        }
    }
    let rank = bright.len() * 99 / 100;
    let bright = match bright.len() {
        0 => 0.0,
        _ => *bright.select_nth_unstable_by(rank, f32::total_cmp).1,
    };
    PictureHistogram { counts, at_white, at_black, not_finite, pixels: shown.as_slice().len() as u32, bright }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(display: Display, linear: [f32; 3]) -> [u8; 3] {
        let [r, g, b, _] = displayed(&display, linear).to_array();
        [r, g, b]
    }

    #[test]
    fn a_stop_of_exposure_doubles_the_light_and_the_offset_comes_after() {
        let neutral = Display::default();
        let stop = Display { exposure: 1.0, ..neutral };
        assert_eq!(shown(stop, [0.1, 0.2, 0.25]), shown(neutral, [0.2, 0.4, 0.5]));
        let both = Display { offset: -0.1, ..stop };
        assert_eq!(shown(both, [0.2; 3]), shown(neutral, [0.3; 3]));
        let gamma = Display { curve: ToneCurve::Gamma, gamma: 1.0, ..neutral };
        assert_eq!(shown(gamma, [0.0, 0.5, 1.0]), [0, 128, 255]);
    }

    #[test]
    fn curves_that_roll_off_keep_differences_above_white() {
        for curve in [ToneCurve::Filmic, ToneCurve::Reinhard, ToneCurve::FalseColor] {
            let display = Display { curve, ..Display::default() };
            let steps: Vec<[u8; 3]> = [0.2, 1.0, 2.5].map(|c| shown(display, [c; 3])).to_vec();
            assert!(steps[0] != steps[1] && steps[1] != steps[2], "{curve:?}: {steps:?}");
        }
        let reinhard = Display { curve: ToneCurve::Reinhard, ..Display::default() };
        assert!(shown(reinhard, [1e6; 3]).iter().all(|c| *c >= 254));
    }

    #[test]
    fn one_channel_is_gray_and_what_is_cut_off_or_no_number_is_marked() {
        let red = Display { channel: Channel::Red, ..Display::default() };
        assert_eq!(shown(red, [1.0, 0.0, 0.5]), [255; 3]);
        let marks = Display { marks_clipped: true, ..Display::default() };
        let marked = [[2.0, 0.0, 0.0], [0.5, -0.1, 0.0], [f32::NAN, 0.0, 0.0]].map(|c| displayed(&marks, c));
        assert_eq!(marked, MARKS);
        assert_eq!(shown(marks, [0.5; 3]), shown(Display::default(), [0.5; 3]));
    }

    #[test]
    fn a_picture_for_a_file_looks_as_it_does_on_the_screen_and_its_sky_is_left_out() {
        let display = Display { exposure: 1.0, background: Background::Transparent, ..Display::default() };
        let mut picture = Picture::empty(2, 1);
        for x in 0..2 {
            picture.color[(x, 0)] = [0.2, 0.1, 0.9];
            picture.image[(x, 0)] = 0;
        }
        picture.inverse_depth[(0, 0)] = 0.5;
        picture.inverse_depth[(1, 0)] = 0.0;
        let developed = developed(&display, &picture).unwrap();
        assert_eq!(developed.color[(0, 0)].map(srgb8_from_linear), shown(display, [0.2, 0.1, 0.9]));
        assert_eq!([0, 1].map(|x| developed.shows((x, 0))), [true, false]);
        assert!(super::developed(&Display::default(), &picture).is_none(), "nothing is copied in vain");
    }

    #[test]
    fn a_histogram_counts_every_pixel_and_finds_the_bright_ones() {
        let linear: Grid<[f32; 3]> = Grid::from_fn(100, 1, |x, _| [x as f32 / 10.0, 0.0, f32::NAN]);
        let finite = linear.map(|[r, g, _]| [*r, *g, 0.0]);
        let shown = finite.map(|c| displayed(&Display::default(), *c));
        let histogram = histogram_of(&finite, &shown, |c| *c);
        assert!(histogram.counts.iter().all(|counts| counts.iter().sum::<u32>() == 100));
        assert_eq!((histogram.at_white, histogram.at_black, histogram.not_finite), (90, 1, 0));
        assert!((histogram.bright - 9.9).abs() < 0.11, "{}", histogram.bright);
        assert_eq!(histogram_of(&linear, &shown, |c| *c).not_finite, 100);
    }
}
