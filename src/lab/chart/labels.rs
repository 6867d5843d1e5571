//! Labels beside points, so that none covers another.
//!
//! Purpose: charts name points that are close together. Source: greedy placement among fixed candidate positions (Christensen,
//! Marks, Shieber: An Empirical Study of Algorithms for Point-Feature Label Placement, 1995, section 3). What differs: candidates go
//! on outward, in rows above and below the point, until one is free.

use super::svg::{Anchor, Svg};

/// Mean width of a letter, as a share of the size of the type: Ubuntu Light's digits and lower case.
const LETTER_WIDTH: f64 = 0.52;
/// Height of a row of type, the same.
const ROW_HEIGHT: f64 = 1.15;
/// Rows above and below a point that are tried.
const ROWS: u32 = 40;

/// Left, top, right, bottom, pixels.
type Rectangle = [f64; 4];

/// The labels of one plot.
pub(super) struct Labels {
    plot: Rectangle,
    taken: Vec<Rectangle>,
}

impl Labels {
    /// No label yet. Labels stay within `plot` if a place there is free.
    pub(super) fn new(plot: Rectangle) -> Self {
        Self { plot, taken: Vec::new() }
    }

    /// Writes a label beside a point whose marker has this radius; a line joins a distant label to its point.
    pub(super) fn draw(
        &mut self,
        svg: &mut Svg,
        point: (f64, f64),
        radius: f64,
        size: f64,
        ink: &str,
        text: &str,
    ) {
        let width = LETTER_WIDTH * size * text.chars().count() as f64;
        let rows = (0..=ROWS)
            .flat_map(|row| if row == 0 { vec![0.0] } else { vec![-f64::from(row), f64::from(row)] });
        let candidates = rows.flat_map(|row| {
            [Anchor::Start, Anchor::End].map(|anchor| {
                let left = match anchor {
                    Anchor::End => point.0 - radius - 4.0 - width,
                    _ => point.0 + radius + 4.0,
                };
                let top = point.1 + (row - 0.5) * ROW_HEIGHT * size;
                (row, anchor, [left, top, left + width, top + ROW_HEIGHT * size])
            })
        });
        let candidates: Vec<_> = candidates.collect();
        let free = candidates.iter().find(|(.., place)| self.is_free(place));
        let Some((row, anchor, place)) = free.or(candidates.first()).copied() else { return };
        self.taken.push(place);
        let x = if matches!(anchor, Anchor::End) { place[2] } else { place[0] };
        let baseline = place[3] - 0.3 * size;
        if row.abs() > 1.0 {
            svg.line(point, (x, 0.5 * (place[1] + place[3])), 0.6, ink);
        }
        svg.text((x, baseline), anchor, size, ink, text);
    }

    fn is_free(&self, place: &Rectangle) -> bool {
        let [left, top, right, bottom] = self.plot;
        let is_inside = place[0] >= left && place[1] >= top && place[2] <= right && place[3] <= bottom;
        is_inside && !self.taken.iter().any(|other| overlap(place, other))
    }
}

fn overlap(a: &Rectangle, b: &Rectangle) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_of_points_that_lie_together_do_not_cover_each_other_and_stay_within_the_plot() {
        let plot = [0.0, 0.0, 600.0, 400.0];
        let mut labels = Labels::new(plot);
        let mut svg = Svg::new(600.0, 400.0);
        for index in 0..16_u32 {
            let at = (590.0 - f64::from(index % 3), 200.0 + f64::from(index % 2));
            labels.draw(&mut svg, at, 6.0, 12.0, "#000", &format!("method {index}"));
        }
        assert_eq!(labels.taken.len(), 16);
        for (index, a) in labels.taken.iter().enumerate() {
            assert!(a[0] >= plot[0] && a[1] >= plot[1] && a[2] <= plot[2] && a[3] <= plot[3], "{a:?}");
            assert!(labels.taken[index + 1..].iter().all(|b| !overlap(a, b)), "{a:?}");
        }
    }

    #[test]
    fn a_label_alone_stands_to_the_right_of_its_point() {
        let mut labels = Labels::new([0.0, 0.0, 600.0, 400.0]);
        labels.draw(&mut Svg::new(600.0, 400.0), (100.0, 100.0), 6.0, 12.0, "#000", "alone");
        assert_eq!(labels.taken[0][0], 110.0);
    }
}
