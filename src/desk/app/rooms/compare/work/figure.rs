//! A comparison as one picture.

use egui::{Color32, ColorImage};

use crate::app::rooms::compare::model::{ComparisonFigure, ShownSides};

/// Columns of the line between two pictures.
const LINE: usize = 2;

/// What the view shows, a pixel for each pixel of the pictures.
pub(crate) fn image(figure: &ComparisonFigure) -> ColorImage {
    let [left, top, columns, rows] = figure.part();
    let width = figure.images[0].size[0];
    let pixel = |side: usize, x: usize, y: usize| figure.images[side].pixels[(top + y) * width + left + x];
    let drawn = |columns: usize, color: &dyn Fn(usize, usize) -> Color32| {
        let pixels = (0..rows).flat_map(|y| (0..columns).map(move |x| color(x, y)));
        ColorImage::new([columns, rows], pixels.collect())
    };
    match figure.shown() {
        ShownSides::One(side) => drawn(columns, &|x, y| pixel(side, x, y)),
        ShownSides::Wiped(line) => drawn(columns, &|x, y| {
            let is_line = (line.saturating_sub(LINE / 2)..line + LINE / 2).contains(&x);
            if is_line { Color32::WHITE } else { pixel(usize::from(x >= line), x, y) }
        }),
        ShownSides::Beside => drawn(2 * columns + LINE, &|x, y| match x.checked_sub(columns) {
            None => pixel(0, x, y),
            Some(beyond) => beyond.checked_sub(LINE).map_or(Color32::WHITE, |x| pixel(1, x, y)),
        }),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use egui::{Rect, pos2};

    use super::*;
    use crate::app::rooms::compare::model::{CompareInView, CompareMeasure, CompareMode};

    /// Pictures of eight by four pixels: column and row in red and green, the side in blue.
    fn figure(mode: CompareMode, in_view: CompareInView) -> ComparisonFigure {
        let image = |side: u8| {
            let pixels = (0..32).map(|at| Color32::from_rgb(at % 8, at / 8, side)).collect();
            Arc::new(ColorImage::new([8, 4], pixels))
        };
        ComparisonFigure {
            images: [image(0), image(1), image(2)],
            names: ["a".to_owned(), "b".to_owned()],
            mode,
            in_view,
            measure: CompareMeasure::Steps,
            range: 9.0,
            dark: true,
        }
    }

    #[test]
    fn each_way_of_comparing_draws_what_its_view_shows() {
        let view = CompareInView::default();
        let drawn = |mode, in_view| image(&figure(mode, in_view));
        let side = |image: &ColorImage, x: usize| image.pixels[x].b();
        assert_eq!(side(&drawn(CompareMode::Difference, view), 3), 2);
        assert_eq!(side(&drawn(CompareMode::Flip, view), 3), 0);
        let flipped = CompareInView { flipped: true, ..view };
        assert_eq!(side(&drawn(CompareMode::Flip, flipped), 3), 1);
        assert_eq!(side(&drawn(CompareMode::Wipe, flipped), 0), 1);
        let wiped = drawn(CompareMode::Wipe, view);
        assert_eq!([0, 2, 3, 4, 5].map(|x| side(&wiped, x)), [0, 0, 255, 255, 1]);
        let beside = drawn(CompareMode::Beside, view);
        assert_eq!(beside.size, [18, 4]);
        assert_eq!([7, 8, 9, 10].map(|x| side(&beside, x)), [0, 255, 255, 1]);
    }

    #[test]
    fn only_the_part_in_view_is_drawn_and_a_line_beside_it_is_not() {
        let part = Rect::from_min_max(pos2(0.5, 0.25), pos2(1.0, 0.75));
        let in_view = |line| CompareInView { part, line, ..CompareInView::default() };
        let wiped = image(&figure(CompareMode::Wipe, in_view(0.25)));
        assert_eq!(wiped.size, [4, 2]);
        assert_eq!(wiped.pixels[0], Color32::from_rgb(4, 1, 1), "the line is left of what is seen");
        let left = image(&figure(CompareMode::Wipe, in_view(1.2)));
        assert!(left.pixels.iter().all(|pixel| pixel.b() == 0));
    }
}
