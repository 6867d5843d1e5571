//! A comparison as its view shows it, so that a figure shows the same.

use std::sync::Arc;

use egui::ColorImage;

use super::comparison::{CompareInView, CompareLook, CompareMeasure, CompareMode, ShownComparison};

/// Which pictures are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ShownSides {
    /// The left one, the right one or their difference, by its index.
    One(usize),
    /// The left one up to so many columns of the part in view, then the right one.
    Wiped(usize),
    Beside,
}

/// What a figure of a comparison is drawn from.
#[derive(Clone, Debug)]
pub(crate) struct ComparisonFigure {
    /// Left, right and their difference, of one size.
    pub images: [Arc<ColorImage>; 3],
    /// Of the two sides.
    pub names: [String; 2],
    pub mode: CompareMode,
    pub in_view: CompareInView,
    /// What the map of the difference shows.
    pub measure: CompareMeasure,
    /// The difference at the map's upper end, in the unit of the measure.
    pub range: f32,
    /// Whether the map is that of the dark theme.
    pub dark: bool,
}

impl ComparisonFigure {
    pub(crate) fn of(compared: &ShownComparison, look: &CompareLook, dark: bool) -> Self {
        let comparison = &compared.comparison;
        let [left, right] = comparison.images.clone();
        Self {
            images: [left, right, comparison.difference.clone()],
            names: compared.names.clone(),
            mode: look.mode,
            in_view: look.in_view,
            measure: comparison.measure,
            range: comparison.range,
            dark,
        }
    }

    /// The part in view in pixels: the first column and row, columns and rows.
    pub(crate) fn part(&self) -> [usize; 4] {
        let [width, height] = self.images[0].size;
        let span = |from: f32, to: f32, side: usize| {
            let first = ((from * side as f32).floor().max(0.0) as usize).min(side.saturating_sub(1));
            let end = ((to * side as f32).ceil().max(0.0) as usize).clamp(first + 1, side.max(first + 1));
            (first, end - first)
        };
        let part = self.in_view.part;
        let (left, columns) = span(part.left(), part.right(), width);
        let (top, rows) = span(part.top(), part.bottom(), height);
        [left, top, columns, rows]
    }

    pub(crate) fn shown(&self) -> ShownSides {
        match self.mode {
            CompareMode::Difference => ShownSides::One(2),
            CompareMode::Beside => ShownSides::Beside,
            CompareMode::Flip | CompareMode::Wipe if self.in_view.flipped => ShownSides::One(1),
            CompareMode::Flip => ShownSides::One(0),
            CompareMode::Wipe => {
                let [left, _, columns, _] = self.part();
                let line = (self.in_view.line * self.images[0].size[0] as f32).round() - left as f32;
                if line <= 0.0 {
                    ShownSides::One(1)
                } else if line >= columns as f32 {
                    ShownSides::One(0)
                } else {
                    ShownSides::Wiped(line as usize)
                }
            }
        }
    }
}
