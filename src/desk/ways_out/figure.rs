//! Figures for print.

pub(crate) use super::figure_options::{DOTS_PER_INCH, FigureOf, FigureOptions, FigureWidth, Unit, one_of};
use super::shared::{FileKind, Needs, Options, Scope, Size, WayOut};
use crate::text::significant;

pub(crate) const WAY: WayOut = WayOut {
    name: "Figure",
    used: "A picture for print, with what its colors mean, a scale bar and a caption: PDF, SVG or PNG.",
    button: "Save the figure…",
    command: "figure",
    about: "A figure for print: a picture with what its colors mean, a scale bar and a caption, as PDF, SVG or PNG",
    kind: |_| &FIGURE,
    size,
    write: None,
};

/// A figure of a view.
pub(crate) const FIGURE: FileKind = FileKind {
    needs: Needs::Figure,
    ..FileKind::of_samples("Share a figure", &["pdf", "svg", "png"], "figure")
};

/// Bytes of a figure without its picture.
const EMPTY_FIGURE: f64 = 15e3;

/// Its picture as PNG takes nearly all of it.
fn size(scope: &Scope, options: &Options) -> Size {
    let Some(picture) = scope.facts.picture else { return Size::missing("once the view rests") };
    let size = picture.png_bytes * picture.share_of(scope.figure_size);
    let millimeters = significant(options.figure.width_mm());
    Size::about(size + EMPTY_FIGURE, format!("{millimeters} mm, {} px wide", options.figure.columns()))
}
