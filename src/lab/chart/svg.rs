//! A chart as SVG, put together shape by shape, and as PNG.

use std::fmt::Write;
use std::sync::Arc;

use resvg::{tiny_skia, usvg};

use super::color;
use super::series::Marker;
use overlook_engine::error::{Error, Result};

/// A chart, drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chart {
    /// The picture as SVG; its text is set in Ubuntu.
    pub(super) svg: String,
}

const FAMILY: &str = "Ubuntu";

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
        let fail = |what: String| Error::unsupported("chart", what);
        let mut options = usvg::Options { font_family: FAMILY.to_owned(), ..usvg::Options::default() };
        let fonts = Arc::make_mut(&mut options.fontdb);
        fonts.load_font_data(epaint_default_fonts::UBUNTU_LIGHT.to_vec());
        let tree = usvg::Tree::from_str(&self.svg, &options).map_err(|error| fail(error.to_string()))?;
        let size = tree.size().to_int_size();
        let mut pixels = tiny_skia::Pixmap::new(size.width(), size.height())
            .ok_or_else(|| fail("is too large to be drawn".to_owned()))?;
        resvg::render(&tree, tiny_skia::Transform::identity(), &mut pixels.as_mut());
        pixels.encode_png().map_err(|error| fail(error.to_string()))
    }
}

/// Alignment of text.
#[derive(Clone, Copy)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// A picture under way.
pub(super) struct Svg {
    text: String,
}

impl Svg {
    /// An empty sheet, size in pixels.
    pub(super) fn new(width: f64, height: f64) -> Self {
        let mut svg = Self { text: String::new() };
        let _ = write!(
            svg.text,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" font-family=\"{}\">\n<rect width=\"100%\" height=\"100%\" fill=\"{}\"/>\n",
            FAMILY,
            color::PAPER
        );
        svg
    }

    /// The finished picture.
    pub(super) fn finish(mut self) -> Chart {
        self.text.push_str("</svg>\n");
        Chart { svg: self.text }
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
                color::PAPER
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
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{r}\" fill=\"{color}\" stroke=\"{}\" stroke-width=\"0.8\"/>",
                color::PAPER
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
