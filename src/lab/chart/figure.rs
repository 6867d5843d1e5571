//! A figure for print: a picture with a scale bar in it, and below it what its colors mean, and a caption.
//!
//! Lengths on the sheet are pixels of its PNG, so that a picture that is as wide as the figure is drawn pixel by pixel. As SVG and PDF the
//! same sheet has a size in millimeters, and its text stays text.

use std::io::Cursor;

use base64::Engine as _;
use image::{ImageFormat, RgbaImage};

use super::axis::short;
use super::color_bar::{BarLook, ColorBar};
use super::svg::{
    Anchor, Chart, DARK_FAINT, DARK_INK, DARK_PAPER, FAINT, INK, ON_PLATE, PAPER, Print, Svg, hex,
};
use super::type_metrics::{check_letters, lines, text_width};
use overlook_engine::error::{Error, Result};

/// A typographic point, inches.
const POINT: f64 = 1.0 / 72.0;

/// Columns of the narrowest and of the widest figure, pixels.
pub const FIGURE_COLUMNS: [u32; 2] = [64, 16_384];

/// Most pixels of a figure's PNG.
const MOST_PIXELS: u64 = 1 << 28;

/// Width of the longest scale bar, as a share of the picture's.
const LONGEST_BAR: f64 = 0.3;

/// Room between parts, height of a line and side of a swatch, as multiples of the size of the type.
const GAP: f64 = 0.7;
const LINE: f64 = 1.35;
const SWATCH: f64 = 0.8;

/// What a figure is made of.
#[derive(Clone, Debug)]
pub struct Figure {
    /// The picture: sRGB, alpha not premultiplied.
    pub picture: RgbaImage,
    /// Colors and what they mean.
    pub legend: Vec<LegendEntry>,
    /// A scale of colors for numbers.
    pub color_bar: Option<ColorBar>,
    /// A length in the picture.
    pub scale: Option<ScaleBar>,
    /// Empty for none; line breaks stay.
    pub caption: String,
    /// Columns of the figure, [`FIGURE_COLUMNS`].
    pub columns: u32,
    /// Pixels of the figure on an inch of paper, above 0.
    pub dots_per_inch: u32,
    /// Size of the type, typographic points.
    pub type_points: f64,
    /// Light type on dark paper.
    pub is_dark: bool,
}

/// A color of the picture, and what it means.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LegendEntry {
    /// 8-bit sRGB; `None` where the words stand alone.
    pub color: Option<[u8; 3]>,
    /// In words.
    pub name: String,
}

/// What a length of the scene measures in the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct ScaleBar {
    /// Length of one unit, as a share of the picture's width; above 0.
    pub unit_share: f64,
    /// The name of the unit, as in `m`.
    pub unit: String,
    /// How far away it is valid, world units; `None` where everywhere, as in an orthographic picture.
    pub distance: Option<f64>,
}

impl Figure {
    /// The figure, drawn.
    ///
    /// # Errors
    /// `Invalid` where it has no picture, is wider or larger than a PNG may be, or holds a letter that its typeface lacks.
    pub fn chart(&self) -> Result<Chart> {
        let (width, height) = self.picture.dimensions();
        let sizes = FIGURE_COLUMNS[0]..=FIGURE_COLUMNS[1];
        if width == 0 || height == 0 || !sizes.contains(&self.columns) {
            let what = format!(
                "a figure {} px wide cannot be drawn; choose from {} to {}",
                self.columns, FIGURE_COLUMNS[0], FIGURE_COLUMNS[1]
            );
            return Err(Error::invalid("figure", what));
        }
        let names = self.legend.iter().map(|entry| &entry.name);
        let titles = self.color_bar.iter().map(|bar| &bar.title);
        for text in names.chain(titles).chain([&self.caption]) {
            check_letters(text, "figure", "write it otherwise, or leave out the legend")?;
        }
        let type_size = self.type_points * POINT * f64::from(self.dots_per_inch);
        let columns = f64::from(self.columns);
        let picture_height = (columns * f64::from(height) / f64::from(width)).round().max(1.0);
        let mut sheet = Sheet { figure: self, type_size, columns, body: Svg::part(), y: picture_height };
        sheet.picture(picture_height)?;
        sheet.scale_bar(picture_height);
        sheet.color_bar();
        sheet.legend();
        sheet.caption();
        sheet.y += 0.5 * sheet.inset();
        let rows = sheet.y.ceil() as u32;
        if u64::from(rows) * u64::from(self.columns) > MOST_PIXELS {
            return Err(Error::invalid("figure", "is too high to be drawn; make it narrower"));
        }
        let print = Print { columns: self.columns, rows, dots_per_inch: self.dots_per_inch };
        Ok(Svg::printed(print, sheet.paper(), &sheet.body))
    }
}

/// A figure under way: what is drawn, and down to where, pixels.
struct Sheet<'a> {
    figure: &'a Figure,
    type_size: f64,
    columns: f64,
    body: Svg,
    y: f64,
}

impl Sheet<'_> {
    /// Room at the sides of what stands below the picture: on dark paper type does not touch the edge.
    fn inset(&self) -> f64 {
        if self.figure.is_dark { 0.6 * self.type_size } else { 0.0 }
    }

    fn paper(&self) -> &'static str {
        if self.figure.is_dark { DARK_PAPER } else { PAPER }
    }

    fn ink(&self) -> &'static str {
        if self.figure.is_dark { DARK_INK } else { INK }
    }

    fn faint(&self) -> &'static str {
        if self.figure.is_dark { DARK_FAINT } else { FAINT }
    }

    fn picture(&mut self, height: f64) -> Result<()> {
        let mut png = Cursor::new(Vec::new());
        let written = self.figure.picture.write_to(&mut png, ImageFormat::Png);
        written.map_err(|error| Error::invalid("figure", error.to_string()))?;
        let png = base64::engine::general_purpose::STANDARD.encode(png.into_inner());
        self.body.picture([0.0, 0.0, self.columns, height], &png);
        Ok(())
    }

    /// In the lower left corner of the picture, on a plate that is readable over every color.
    fn scale_bar(&mut self, picture_height: f64) {
        let Some(scale) = &self.figure.scale else { return };
        let per_unit = scale.unit_share * self.columns;
        let Some(length) = round_below(LONGEST_BAR * self.columns / per_unit) else { return };
        let mut text = format!("{} {}", length_text(length), scale.unit);
        if let Some(distance) = scale.distance {
            text = format!("{text}, at {} {}", significant(distance), scale.unit);
        }
        let (size, bar) = (self.type_size, length * per_unit);
        let (edge, inset) = (GAP * size, 0.5 * size);
        let width = bar.max(text_width(&text, size)) + 2.0 * inset;
        let height = size * (LINE + 0.9);
        let (left, top) = (edge, picture_height - edge - height);
        // A picture that is too small for it has none.
        if top < 0.0 || left + width > self.columns {
            return;
        }
        self.body.plate([left, top, width, height], 0.25 * size);
        let (x, y) = (left + inset, top + height - 0.55 * size);
        let stroke = 0.14 * size;
        self.body.line((x, y), (x + bar, y), stroke, ON_PLATE);
        for x in [x, x + bar] {
            self.body.line((x, y - 0.25 * size), (x, y + 0.25 * size), stroke, ON_PLATE);
        }
        self.body.text((x, top + 1.05 * size), Anchor::Start, size, ON_PLATE, &text);
    }

    fn color_bar(&mut self) {
        let Some(bar) = &self.figure.color_bar else { return };
        let look = BarLook {
            columns: self.columns,
            inset: self.inset(),
            type_size: self.type_size,
            ink: self.ink(),
            faint: self.faint(),
        };
        self.y = bar.draw(&mut self.body, self.y, &look);
    }

    /// Entries side by side, in as many rows as they need.
    fn legend(&mut self) {
        let entries = &self.figure.legend;
        if entries.is_empty() {
            return;
        }
        let size = self.type_size;
        self.y += GAP * size;
        let (first, end) = (self.inset(), self.columns - self.inset());
        let mut x = first;
        self.y += size;
        for LegendEntry { color, name } in entries {
            let sign = if color.is_some() { (SWATCH + 0.4) * size } else { 0.0 };
            let width = sign + text_width(name, size);
            if x > first && x + width > end {
                x = first;
                self.y += LINE * size;
            }
            if let Some(color) = color {
                self.body.rectangle([x, self.y - SWATCH * size, SWATCH * size, SWATCH * size], &hex(*color));
            }
            self.body.text((x + sign, self.y), Anchor::Start, size, self.ink(), name);
            x += width + 1.4 * size;
        }
        self.y += 0.35 * size;
    }

    fn caption(&mut self) {
        let size = self.type_size;
        let lines = lines(&self.figure.caption, size, self.columns - 2.0 * self.inset());
        if lines.is_empty() {
            return;
        }
        self.y += GAP * size;
        for line in lines {
            self.y += LINE * size;
            self.body.text((self.inset(), self.y - 0.35 * size), Anchor::Start, size, self.ink(), &line);
        }
    }
}

/// The largest of 1, 2 and 5 times a power of ten that is not above a number; `None` where there is none.
fn round_below(most: f64) -> Option<f64> {
    if !(most.is_finite() && most > 0.0) {
        return None;
    }
    let power = 10_f64.powf(most.log10().floor());
    // A power of ten may have come out a little larger than it is.
    [5.0, 2.0, 1.0, 0.5].map(|step| step * power).into_iter().find(|length| *length <= most)
}

/// A round length, without the digits that its binary form adds.
fn length_text(length: f64) -> String {
    let decimals = (-length.log10().floor()).clamp(0.0, 12.0) as usize;
    format!("{length:.decimals$}")
}

/// Three digits.
fn significant(value: f64) -> String {
    let decimals = (2.0 - value.abs().max(1e-12).log10().floor()).clamp(0.0, 12.0) as usize;
    let digits = format!("{value:.decimals$}");
    digits.parse().map_or(digits, short)
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(in crate::chart) fn figure() -> Figure {
        Figure {
            picture: RgbaImage::from_fn(40, 30, |x, y| image::Rgba([6 * x as u8, 8 * y as u8, 90, 255])),
            legend: vec![
                LegendEntry { color: Some([10, 20, 30]), name: "kept & shown".to_owned() },
                LegendEntry { color: None, name: "dropped 12.5 %".to_owned() },
            ],
            color_bar: Some(ColorBar {
                title: String::new(),
                colors: vec![[0, 0, 0], [90, 90, 90], [255, 255, 255]],
                ticks: vec![(0.0, "1/8".to_owned()), (0.5, "r = 1".to_owned()), (1.0, "8".to_owned())],
            }),
            scale: Some(ScaleBar { unit_share: 0.21, unit: "m".to_owned(), distance: Some(3.214) }),
            caption: "What one camera keeps of what it saw.".to_owned(),
            columns: 800,
            dots_per_inch: 300,
            type_points: 8.0,
            is_dark: false,
        }
    }

    #[test]
    fn the_sheet_has_the_size_that_was_asked_for_and_its_text_is_text() {
        let chart = figure().chart().unwrap();
        let svg = chart.svg();
        for text in ["kept &amp; shown", "dropped 12.5 %", "r = 1", "1 m, at 3.21 m", "What one camera keeps"]
        {
            assert!(svg.contains(text), "{text} is missing");
        }
        assert!(svg.contains("width=\"67.733mm\""), "{}", &svg[..200]);
        let png = image::load_from_memory(&chart.png().unwrap()).unwrap().to_rgb8();
        assert_eq!(png.width(), 800);
        assert!(png.height() > 600 && png.height() < 1000, "{}", png.height());
        // Pixels of the picture are drawn as large squares, nothing is blended.
        for (x, y) in [(3, 2), (20, 7), (36, 15)] {
            let [red, green] = [6 * x as u8, 8 * y as u8];
            assert_eq!(png.get_pixel(20 * x + 10, 20 * y + 10).0, [red, green, 90]);
        }
    }

    #[test]
    fn a_picture_as_wide_as_the_figure_is_drawn_pixel_by_pixel() {
        let picture =
            RgbaImage::from_fn(200, 120, |x, y| image::Rgba([x as u8, 2 * y as u8, (x ^ y) as u8, 255]));
        let figure = Figure { picture: picture.clone(), columns: 200, scale: None, ..figure() };
        let png = image::load_from_memory(&figure.chart().unwrap().png().unwrap()).unwrap().to_rgba8();
        assert!(picture.enumerate_pixels().all(|(x, y, pixel)| png.get_pixel(x, y) == pixel));
    }

    #[test]
    fn lengths_are_round_and_a_figure_that_cannot_be_drawn_is_refused() {
        let lengths = [0.0432, 1.0, 7.3, 480.0].map(|most| length_text(round_below(most).unwrap()));
        assert_eq!(lengths, ["0.02", "1", "5", "200"]);
        assert_eq!([0.012_34, 3.2, 1234.0].map(significant), ["0.012", "3.2", "1234"]);
        assert!(round_below(f64::NAN).is_none() && round_below(0.0).is_none());
        assert!(Figure { columns: 10, ..figure() }.chart().is_err());
        assert!(Figure { picture: RgbaImage::new(0, 0), ..figure() }.chart().is_err());
    }

    #[test]
    fn a_letter_that_the_typeface_lacks_is_refused_by_name_and_umlauts_are_not() {
        let with = |caption: &str| Figure { caption: caption.to_owned(), ..figure() }.chart();
        let said = with("seen from 日本").unwrap_err().to_string();
        assert!(said.contains("no letter '日' (U+65E5)"), "{said}");
        assert!(with("Größe:\n½ ± 0.2 µm — Żółw, Ωμέγα, Привет").is_ok());
    }
}
