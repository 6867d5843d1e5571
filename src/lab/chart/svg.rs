//! A chart as SVG, put together shape by shape, and as PNG and PDF.

use std::fmt::Write;
use std::sync::Arc;

use resvg::{tiny_skia, usvg};

use super::axis::Marker;
use super::pdf;
use super::type_metrics::{FAMILY, FONT};
use overlook_engine::error::{Error, Result};

/// Millimeters of an inch.
pub const INCH_MM: f64 = 25.4;

/// A chart, drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chart {
    /// The picture as SVG; its text is set in Ubuntu.
    pub(super) svg: String,
    /// Its size on paper; `None` where it has the size that SVG gives it.
    print: Option<Print>,
}

/// The size of a sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Print {
    /// Columns of its PNG.
    pub(super) columns: u32,
    pub(super) rows: u32,
    /// Pixels on an inch of paper.
    pub(super) dots_per_inch: u32,
}

impl Print {
    /// The attributes of its size on paper.
    fn on_paper(self) -> String {
        let per_pixel = INCH_MM / f64::from(self.dots_per_inch);
        let [width, height] = [self.columns, self.rows].map(|pixels| f64::from(pixels) * per_pixel);
        format!("width=\"{width:.3}mm\" height=\"{height:.3}mm\"")
    }

    /// The attributes of its size in pixels.
    fn in_pixels(self) -> String {
        format!("width=\"{}\" height=\"{}\"", self.columns, self.rows)
    }
}

impl Chart {
    /// The chart as SVG, whose shapes are sharp at any size.
    #[must_use]
    pub fn svg(&self) -> String {
        self.svg.clone()
    }

    /// The chart as PNG.
    ///
    /// # Errors
    ///
    /// `Unsupported` where it is too large to be drawn.
    pub fn png(&self) -> Result<Vec<u8>> {
        // Millimeters are rounded; pixels of a picture are to meet those of the sheet.
        let tree = match self.print {
            Some(print) => tree(&self.svg.replacen(&print.on_paper(), &print.in_pixels(), 1))?,
            None => tree(&self.svg)?,
        };
        let size = tree.size().to_int_size();
        let mut pixels = tiny_skia::Pixmap::new(size.width(), size.height())
            .ok_or_else(|| refusal("is too large to be drawn".to_owned()))?;
        resvg::render(&tree, tiny_skia::Transform::identity(), &mut pixels.as_mut());
        let Some(print) = self.print else {
            return pixels.encode_png().map_err(|error| refusal(error.to_string()));
        };
        // Sheets of paper are opaque, so that premultiplied colors are colors.
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, size.width(), size.height());
        encoder.set_color(png::ColorType::Rgba);
        let per_meter = (f64::from(print.dots_per_inch) / INCH_MM * 1000.0).round() as u32;
        let [xppu, yppu] = [per_meter; 2];
        encoder.set_pixel_dims(Some(png::PixelDimensions { xppu, yppu, unit: png::Unit::Meter }));
        let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(pixels.data()));
        written.map_err(|error| refusal(error.to_string()))?;
        Ok(bytes)
    }

    /// The chart as PDF: shapes are shapes, text is text, in the typeface that is embedded.
    ///
    /// # Errors
    ///
    /// `Unsupported` where the SVG holds what no chart has.
    pub fn pdf(&self) -> Result<Vec<u8>> {
        pdf::of_tree(&tree(&self.svg)?)
    }
}

fn tree(svg: &str) -> Result<usvg::Tree> {
    let mut options = usvg::Options { font_family: FAMILY.to_owned(), ..usvg::Options::default() };
    Arc::make_mut(&mut options.fontdb).load_font_data(FONT.to_vec());
    usvg::Tree::from_str(svg, &options).map_err(|error| refusal(error.to_string()))
}

fn refusal(what: String) -> Error {
    Error::unsupported("chart", what)
}

/// Alignment of text.
#[derive(Clone, Copy)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// The beginning of a sheet that is filled with the color of its paper.
fn opened(size: &str, [width, height]: [f64; 2], paper: &str) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" {size} viewBox=\"0 0 {width} {height}\" font-family=\"{FAMILY}, sans-serif\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"{paper}\"/>\n"
    )
}

/// A picture under way.
pub(super) struct Svg {
    text: String,
}

impl Svg {
    /// An empty sheet, size in pixels.
    pub(super) fn new(width: f64, height: f64) -> Self {
        let size = format!("width=\"{width}\" height=\"{height}\"");
        Self { text: opened(&size, [width, height], PAPER) }
    }

    /// Shapes that are put on a sheet later.
    pub(super) fn part() -> Self {
        Self { text: String::new() }
    }

    /// The finished picture.
    pub(super) fn finish(mut self) -> Chart {
        self.text.push_str("</svg>\n");
        Chart { svg: self.text, print: None }
    }

    /// A part as a sheet of its own, with a size on paper; its lengths are pixels of the PNG.
    pub(super) fn printed(print: Print, paper: &str, part: &Self) -> Chart {
        let mut text = opened(&print.on_paper(), [print.columns, print.rows].map(f64::from), paper);
        text.push_str(&part.text);
        text.push_str("</svg>\n");
        Chart { svg: text, print: Some(print) }
    }

    /// A picture, PNG in Base64, whose pixels stay squares however large they are; left, top, width and height.
    pub(super) fn picture(&mut self, [left, top, width, height]: [f64; 4], png: &str) {
        let _ = writeln!(
            self.text,
            "<image x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\" preserveAspectRatio=\"none\" \
             image-rendering=\"optimizeSpeed\" style=\"image-rendering:pixelated\" href=\"data:image/png;base64,{png}\"/>"
        );
    }

    /// A filled rectangle; left, top, width and height.
    pub(super) fn rectangle(&mut self, [left, top, width, height]: [f64; 4], color: &str) {
        let _ = writeln!(
            self.text,
            "<rect x=\"{left:.2}\" y=\"{top:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" fill=\"{color}\"/>"
        );
    }

    /// What text on a picture stands on; left, top, width and height, and the radius of its corners.
    pub(super) fn plate(&mut self, [left, top, width, height]: [f64; 4], radius: f64) {
        let _ = writeln!(
            self.text,
            "<rect x=\"{left:.2}\" y=\"{top:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" rx=\"{radius:.2}\" \
             fill=\"{PLATE}\" fill-opacity=\"0.72\"/>"
        );
    }

    pub(super) fn text(&mut self, (x, y): (f64, f64), anchor: Anchor, size: f64, color: &str, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let escaped = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
        let _ = writeln!(
            self.text,
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" font-size=\"{size}\" fill=\"{color}\">{escaped}</text>"
        );
    }

    /// Text that reads upward, centered.
    pub(super) fn upward(&mut self, (x, y): (f64, f64), size: f64, color: &str, text: &str) {
        let _ = write!(self.text, "<g transform=\"translate({x:.1} {y:.1}) rotate(-90)\">");
        self.text((0.0, 0.0), Anchor::Middle, size, color, text);
        self.text.push_str("</g>\n");
    }

    pub(super) fn line(&mut self, from: (f64, f64), to: (f64, f64), width: f64, color: &str) {
        self.path(&[from, to], width, color, "");
    }

    /// A line through points; `dash` as in SVG, empty for a whole line.
    pub(super) fn path(&mut self, points: &[(f64, f64)], width: f64, color: &str, dash: &str) {
        let mut steps = String::new();
        for (index, (x, y)) in points.iter().enumerate() {
            let _ = write!(steps, "{}{x:.1} {y:.1}", if index == 0 { 'M' } else { 'L' });
        }
        let _ = writeln!(
            self.text,
            "<path d=\"{steps}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{width}\" stroke-linejoin=\"round\" \
             stroke-linecap=\"round\" stroke-dasharray=\"{dash}\"/>"
        );
    }

    /// A marker of a radius, filled with a color and outlined in white.
    pub(super) fn marker(&mut self, marker: Marker, (x, y): (f64, f64), radius: f64, color: &str) {
        let r = radius;
        let polygon = |corners: &[(f64, f64)]| {
            let corners: Vec<String> =
                corners.iter().map(|(dx, dy)| format!("{:.1},{:.1}", x + r * dx, y + r * dy)).collect();
            format!(
                "<polygon points=\"{}\" fill=\"{color}\" stroke=\"{}\" stroke-width=\"1\"/>",
                corners.join(" "),
                PAPER
            )
        };
        let strokes = |ends: &[[(f64, f64); 2]]| {
            let mut steps = String::new();
            for [from, to] in ends {
                let _ = write!(
                    steps,
                    "M{:.1} {:.1}L{:.1} {:.1}",
                    x + r * from.0,
                    y + r * from.1,
                    x + r * to.0,
                    y + r * to.1
                );
            }
            format!(
                "<path d=\"{steps}\" stroke=\"{color}\" stroke-width=\"2.4\" stroke-linecap=\"round\" fill=\"none\"/>"
            )
        };
        let shape = match marker {
            Marker::Dot => format!(
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{r}\" fill=\"{color}\" stroke=\"{PAPER}\" stroke-width=\"0.8\"/>"
            ),
            Marker::Ring => format!(
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{r}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2.4\"/>"
            ),
            Marker::Square => polygon(&[(-0.85, -0.85), (0.85, -0.85), (0.85, 0.85), (-0.85, 0.85)]),
            Marker::Diamond => polygon(&[(0.0, -1.15), (1.15, 0.0), (0.0, 1.15), (-1.15, 0.0)]),
            Marker::Up => polygon(&[(0.0, -1.1), (1.05, 0.8), (-1.05, 0.8)]),
            Marker::Down => polygon(&[(0.0, 1.1), (1.05, -0.8), (-1.05, -0.8)]),
            Marker::Star => {
                let corner = |index: usize| {
                    let reach = if index.is_multiple_of(2) { 1.3 } else { 0.55 };
                    let angle = std::f64::consts::PI * (index as f64 / 5.0 - 0.5);
                    (reach * angle.cos(), reach * angle.sin())
                };
                polygon(&std::array::from_fn::<_, 10, _>(corner))
            }
            Marker::Cross => strokes(&[[(-0.8, -0.8), (0.8, 0.8)], [(-0.8, 0.8), (0.8, -0.8)]]),
            Marker::Plus => strokes(&[[(-1.0, 0.0), (1.0, 0.0)], [(0.0, -1.0), (0.0, 1.0)]]),
        };
        self.text.push_str(&shape);
        self.text.push('\n');
    }
}

pub(super) const INK: &str = "#22262b";
pub(super) const FAINT: &str = "#6b7480";
pub(super) const GRID: &str = "#e4e7eb";
pub(super) const PAPER: &str = "#ffffff";
pub(super) const DARK_PAPER: &str = "#171b21";
pub(super) const DARK_INK: &str = "#e4e8ee";
pub(super) const DARK_FAINT: &str = "#9ba7b6";
/// Under text on a picture, and that text.
pub(super) const PLATE: &str = "#0b0d10";
pub(super) const ON_PLATE: &str = "#ffffff";
pub(super) const BLUE: &str = "#0072b2";
pub(super) const ORANGE: &str = "#e69f00";
pub(super) const GREEN: &str = "#009e73";
pub(super) const PINK: &str = "#cc79a7";
pub(super) const RED: &str = "#d55e00";

/// An 8-bit sRGB color as SVG writes it.
pub(super) fn hex([red, green, blue]: [u8; 3]) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}
