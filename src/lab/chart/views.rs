//! Coverage and accuracy of a model against its number of views.

use super::axis::{ChartAxis, Marker, Scale, short};
use super::svg::{Anchor, BLUE, Chart, FAINT, GRID, INK, RED, Svg};
use crate::tune::ChosenViews;

const SIZE: (f64, f64) = (1100.0, 620.0);
const LEFT: f64 = 90.0;
const RIGHT: f64 = SIZE.0 - 90.0;
const TOP: f64 = 110.0;
const BOTTOM: f64 = SIZE.1 - 70.0;

/// Draws the result of choosing views of a capture.
#[must_use]
pub fn views(capture: &str, chosen: &ChosenViews) -> Chart {
    let mut svg = Svg::new(SIZE.0, SIZE.1);
    svg.text((40.0, 48.0), Anchor::Start, 30.0, INK, &format!("{capture}: the fewest views"));
    let legend = [(40.0, BLUE, "shown of what all views saw, %"), (380.0, RED, "PSNR, dB")];
    for (left, ink, text) in legend {
        svg.line((left, 78.0), (left + 34.0, 78.0), 3.0, ink);
        svg.text((left + 44.0, 83.0), Anchor::Start, 16.0, INK, text);
    }
    let shown: Vec<(f64, f64)> =
        (1_u32..).zip(&chosen.order).map(|(count, view)| (f64::from(count), 100.0 * view.shown)).collect();
    let accurate = || chosen.accuracy.iter().map(|count| (count.views as f64, count.psnr_filled_db));
    let numbers = shown.iter().map(|point| point.0).chain(accurate().map(|point| point.0));
    let x = ChartAxis::around(Scale::Log, numbers, LEFT, RIGHT);
    let share = ChartAxis::around(Scale::Linear, shown.iter().map(|point| point.1), BOTTOM, TOP);
    let db = ChartAxis::around(Scale::Linear, accurate().map(|point| point.1), BOTTOM, TOP);
    for tick in share.ticks(6) {
        svg.line((LEFT, share.at(tick)), (RIGHT, share.at(tick)), 1.0, GRID);
        svg.text((LEFT - 10.0, share.at(tick) + 5.0), Anchor::End, 15.0, BLUE, &short(tick));
    }
    if !chosen.accuracy.is_empty() {
        for tick in db.ticks(6) {
            svg.text((RIGHT + 10.0, db.at(tick) + 5.0), Anchor::Start, 15.0, RED, &short(tick));
        }
    }
    for tick in x.ticks(8).into_iter().filter(|tick| tick.fract() == 0.0) {
        svg.text((x.at(tick), BOTTOM + 24.0), Anchor::Middle, 15.0, FAINT, &short(tick));
    }
    svg.line((LEFT, BOTTOM), (RIGHT, BOTTOM), 1.2, INK);
    svg.text((0.5 * (LEFT + RIGHT), SIZE.1 - 18.0), Anchor::Middle, 16.0, INK, "views");
    let needed = x.at(chosen.needed as f64);
    svg.path(&[(needed, TOP), (needed, BOTTOM)], 1.2, FAINT, "5 5");
    let label = format!("{} needed", chosen.needed);
    svg.text((needed - 8.0, BOTTOM - 10.0), Anchor::End, 15.0, FAINT, &label);
    let at = |axis: &ChartAxis, (number, value): (f64, f64)| (x.at(number), axis.at(value));
    let curve: Vec<(f64, f64)> = shown.iter().map(|point| at(&share, *point)).collect();
    svg.path(&curve, 2.4, BLUE, "");
    let curve: Vec<(f64, f64)> = accurate().map(|point| at(&db, point)).collect();
    svg.path(&curve, 2.4, RED, "");
    for place in curve {
        svg.marker(Marker::Dot, place, 4.5, RED);
    }
    svg.finish()
}
