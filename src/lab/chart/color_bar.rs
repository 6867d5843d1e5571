//! A scale of colors for numbers: a bar with ticks, below a picture.

use image::RgbaImage;

use super::axis::Scale;
use super::svg::{Anchor, FAINT, INK, PAPER, Print, Svg, hex};
use super::type_metrics::text_width;
use overlook_engine::capture::ValueChannel;
use overlook_engine::error::{Error, Result};
use overlook_engine::render::ValueColors;
use overlook_engine::settings::ValueScale;

/// Colors of a bar of values.
const STEPS: usize = 256;

/// About as many ticks as a bar of values has.
const TICKS: usize = 6;

/// Room above the bar, its height and that of a tick, as multiples of the size of the type.
const GAP: f64 = 0.7;
const BAR: f64 = 0.7;
const TICK: f64 = 0.2;
const LINE: f64 = 1.35;

/// Columns of a picture for each pixel of type below it, and the smallest and largest type there, pixels: it has to be read on a screen.
const COLUMNS_PER_TYPE: f64 = 45.0;
const TYPE: [f64; 2] = [11.0, 28.0];

/// Dots an inch of a bar that has no size on paper.
const SCREEN_DOTS: u32 = 96;

/// Colors from one end of a range of numbers to the other.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorBar {
    /// What the numbers are; empty for nothing.
    pub title: String,
    /// 8-bit sRGB, evenly spaced from the low end to the high one.
    pub colors: Vec<[u8; 3]>,
    /// What is written where: shares of the bar's length, 0 to 1, ascending.
    pub ticks: Vec<(f64, String)>,
}

/// How a bar is drawn; lengths in pixels.
pub(super) struct BarLook {
    pub(super) columns: f64,
    /// Room that text keeps at both sides.
    pub(super) inset: f64,
    pub(super) type_size: f64,
    pub(super) ink: &'static str,
    pub(super) faint: &'static str,
}

impl ColorBar {
    /// The bar of a channel of values, with round numbers at its ticks.
    #[must_use]
    pub fn of_values(channel: &ValueChannel, colors: &ValueColors) -> Self {
        let shade = |step: usize| colors.color(colors.value_at((step as f32 + 0.5) / STEPS as f32));
        let unit = if channel.unit.is_empty() { String::new() } else { format!(" ({})", channel.unit) };
        Self {
            title: format!("{}{unit}", channel.name),
            colors: (0..STEPS).map(shade).collect(),
            ticks: ticks(colors),
        }
    }

    /// Draws the bar from `top` down, and gives where it ends.
    pub(super) fn draw(&self, body: &mut Svg, top: f64, look: &BarLook) -> f64 {
        let size = look.type_size;
        let mut y = top + GAP * size;
        if !self.title.is_empty() {
            y += size;
            body.text((look.inset, y - 0.15 * size), Anchor::Start, size, look.ink, &self.title);
            y += (LINE - 1.0) * size;
        }
        let step = look.columns / self.colors.len().max(1) as f64;
        for (nth, color) in self.colors.iter().enumerate() {
            let left = nth as f64 * step;
            // A little overlap closes the seams that anti-aliasing would leave.
            let width = (step + 0.5).min(look.columns - left);
            body.rectangle([left, y, width, BAR * size], &hex(*color));
        }
        y += BAR * size;
        let mut free = f64::NEG_INFINITY;
        for (share, text) in self.ticks.iter().filter(|(_, text)| !text.is_empty()) {
            let (at, half) = (share * look.columns, text_width(text, size) / 2.0);
            let middle = at.min(look.columns - look.inset - half).max(look.inset + half);
            if middle - half < free {
                continue;
            }
            free = middle + half + 0.8 * size;
            if (half..=look.columns - half).contains(&at) {
                body.line((at, y), (at, y + TICK * size), 0.08 * size, look.faint);
            }
            body.text((middle, y + (1.0 + TICK) * size), Anchor::Middle, size, look.faint, text);
        }
        y + (1.3 + TICK) * size
    }

    /// Rows of [`Self::strip`]: an even number, so that films stay whole.
    #[must_use]
    pub fn strip_rows(columns: usize) -> usize {
        let bar = Self { title: "T".to_owned(), colors: Vec::new(), ticks: Vec::new() };
        let rows = bar.draw(&mut Svg::part(), 0.0, &strip_look(columns));
        (rows.ceil() as usize).next_multiple_of(2)
    }

    /// The bar alone, opaque, for below a picture of so many columns.
    ///
    /// # Errors
    /// As [`Chart::png`](super::Chart::png).
    pub fn strip(&self, columns: usize) -> Result<RgbaImage> {
        let mut body = Svg::part();
        self.draw(&mut body, 0.0, &strip_look(columns));
        Strip { columns, rows: Self::strip_rows(columns) }.png_of(&body)
    }
}

/// What lies below a picture on a screen, pixels.
pub(super) struct Strip {
    pub(super) columns: usize,
    pub(super) rows: usize,
}

impl Strip {
    /// What is drawn, opaque.
    pub(super) fn png_of(&self, body: &Svg) -> Result<RgbaImage> {
        let (columns, rows) = (self.columns as u32, self.rows as u32);
        let png = Svg::printed(Print { columns, rows, dots_per_inch: SCREEN_DOTS }, PAPER, body).png()?;
        let read = image::load_from_memory(&png);
        read.map(image::DynamicImage::into_rgba8)
            .map_err(|error| Error::invalid("below a picture", error.to_string()))
    }
}

/// How what lies below a picture of so many columns is drawn.
pub(super) fn strip_look(columns: usize) -> BarLook {
    let type_size = (columns as f64 / COLUMNS_PER_TYPE).clamp(TYPE[0], TYPE[1]).round();
    let inset = 0.5 * type_size;
    BarLook { columns: columns as f64, inset, type_size, ink: INK, faint: FAINT }
}

/// Round numbers within the range of some colors, and where they lie.
fn ticks(colors: &ValueColors) -> Vec<(f64, String)> {
    let [low, high] = colors.range().map(f64::from);
    let scale = if colors.scale() == ValueScale::Log { Scale::Log } else { Scale::Linear };
    let largest = low.abs().max(high.abs());
    let text = |tick: f64| {
        // Ends of f32 leave no digits behind the point, or too many before it.
        if (1e-3..1e6).contains(&largest) && (scale == Scale::Linear || low >= 1e-3) {
            scale.label(tick, low, high, TICKS)
        } else {
            exponential(tick, (high - low) / TICKS as f64)
        }
    };
    // A round end of f32 lies beside the round number.
    let slack = if scale == Scale::Linear { 1e-6 * (high - low) } else { 0.0 };
    let found = scale.ticks(low - slack, high + slack, TICKS);
    found.into_iter().filter_map(|tick| Some((colors.share_of(tick as f32)?, text(tick)))).collect()
}

/// A number as in 2.5e-7, with the digits that tell it from one that is `step` away.
fn exponential(number: f64, step: f64) -> String {
    if number.abs() < step * 1e-6 {
        return "0".to_owned();
    }
    let digits = (number.abs().log10().floor() - step.log10().floor()).clamp(0.0, 7.0) as usize;
    let text = format!("{number:.digits$e}");
    match text.split_once('e') {
        Some((mantissa, power)) if mantissa.contains('.') => {
            format!("{}e{power}", mantissa.trim_end_matches('0').trim_end_matches('.'))
        }
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use overlook_engine::settings::Colormap;

    fn bar(scale: ValueScale, range: [f32; 2]) -> ColorBar {
        let channel = ValueChannel {
            name: "pressure".to_owned(),
            unit: "Pa".to_owned(),
            range,
            tolerance: 0.0,
            is_exact: true,
        };
        ColorBar::of_values(&channel, &ValueColors::new(Colormap::Viridis, scale, range).unwrap())
    }

    fn texts(scale: ValueScale, range: [f32; 2]) -> Vec<String> {
        bar(scale, range).ticks.into_iter().map(|(_, text)| text).collect()
    }

    #[test]
    fn ticks_are_round_numbers_that_differ_at_every_magnitude() {
        assert_eq!(texts(ValueScale::Linear, [0.0, 5000.0]), ["0", "1000", "2000", "3000", "4000", "5000"]);
        assert_eq!(texts(ValueScale::Linear, [-2e-12, 2e-12]), ["-2e-12", "-1e-12", "0", "1e-12", "2e-12"]);
        assert_eq!(texts(ValueScale::Linear, [1.5e9, 1.7e9])[..2], ["1.5e9", "1.55e9"]);
        assert_eq!(texts(ValueScale::Log, [1.0, 100.0]), ["1", "2", "5", "10", "20", "50", "100"]);
        assert_eq!(texts(ValueScale::Log, [1e-6, 1e-3])[..2], ["1e-6", "1e-5"]);
        let shares: Vec<f64> =
            bar(ValueScale::Log, [1.0, 100.0]).ticks.iter().map(|(share, _)| *share).collect();
        assert!((shares[3] - 0.5).abs() < 1e-6 && shares.is_sorted());
    }

    #[test]
    fn a_strip_is_as_wide_as_its_picture_opaque_and_shows_colors_and_text() {
        let strip = bar(ValueScale::Linear, [0.0, 5000.0]).strip(640).unwrap();
        assert_eq!(strip.dimensions(), (640, ColorBar::strip_rows(640) as u32));
        assert!((40..80).contains(&strip.height()) && strip.pixels().all(|pixel| pixel[3] == 255));
        let colors: std::collections::HashSet<_> = strip.pixels().map(|pixel| pixel.0).collect();
        assert!(colors.len() > 200, "{}", colors.len());
        assert!(bar(ValueScale::Linear, [0.0, 5000.0]).strip(64).is_ok());
    }
}
