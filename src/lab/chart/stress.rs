//! A stress test: one panel a disturbance, accuracy above and the share of samples kept below, against the dial.

use super::axis::{ChartAxis, ChartSeries, Marker, Scale, series, short};
use super::svg::{Anchor, BLUE, Chart, FAINT, GREEN, GRID, INK, ORANGE, PINK, RED, Svg};
use crate::stress::{LOST_DB, StressPoint, distinct, failures};

const COLUMNS: usize = 5;
const PANEL: (f64, f64) = (370.0, 300.0);
const HEAD: f64 = 130.0;
const COLORS: [&str; 7] = [BLUE, ORANGE, RED, GREEN, PINK, INK, FAINT];

type Methods<'a> = [ChartSeries<'a, &'a str, StressPoint>];

/// Draws a stress test of a capture.
#[must_use]
pub fn stress(capture: &str, points: &[StressPoint]) -> Chart {
    let disturbances = distinct(points.iter().map(|point| point.disturbance.as_str()));
    let methods = series(points, |point| point.method.as_str());
    let rows = disturbances.len().div_ceil(COLUMNS).max(1);
    let mut svg = Svg::new(30.0 + COLUMNS as f64 * PANEL.0, HEAD + 20.0 + rows as f64 * PANEL.1);
    svg.text((40.0, 48.0), Anchor::Start, 30.0, INK, &format!("{capture}: where methods fail"));
    svg.text(
        (40.0, 76.0),
        Anchor::Start,
        16.0, FAINT,
        "above: PSNR in dB over pixels that some camera saw, a cross where 1 dB is lost; below: samples kept, % of all pixels",
    );
    for (index, method) in methods.iter().enumerate() {
        let x = 48.0 + 230.0 * index as f64;
        svg.line((x, 103.0), (x + 34.0, 103.0), 3.0, COLORS[index % COLORS.len()]);
        svg.text((x + 44.0, 108.0), Anchor::Start, 17.0, INK, method.kind);
    }
    for (index, disturbance) in disturbances.iter().enumerate() {
        let corner = (20.0 + (index % COLUMNS) as f64 * PANEL.0, HEAD + (index / COLUMNS) as f64 * PANEL.1);
        let own_points: Vec<StressPoint> =
            points.iter().filter(|point| point.disturbance == *disturbance).cloned().collect();
        panel(&mut svg, corner, &own_points, &methods);
    }
    svg.finish()
}

fn panel(svg: &mut Svg, (left, top): (f64, f64), points: &[StressPoint], methods: &Methods<'_>) {
    let Some(first) = points.first() else { return };
    let (plot_left, plot_right) = (left + 50.0, left + PANEL.0 - 20.0);
    let (accuracy_bottom, kept_top, bottom) = (top + 175.0, top + 190.0, top + 235.0);
    let title = format!("{}, {}", first.disturbance, first.unit);
    svg.text((plot_left, top + 16.0), Anchor::Start, 17.0, INK, &title);
    let dials = distinct(points.iter().map(|point| point.dial));
    // Values of a dial are drawn at equal distances: they were chosen in perceptually equal steps.
    let x =
        ChartAxis::around(Scale::Linear, (0..dials.len()).map(|index| index as f64), plot_left, plot_right);
    let x_of = |dial: f64| {
        let after = dials.iter().position(|known| *known == dial);
        after.map_or(plot_left, |index| x.at(index as f64))
    };
    let y = ChartAxis::around(
        Scale::Linear,
        points.iter().map(|point| point.point.psnr_filled_db),
        accuracy_bottom,
        top + 28.0,
    );
    let kept = ChartAxis::around(
        Scale::Linear,
        points.iter().map(|point| 100.0 * point.kept_share).chain([0.0]),
        bottom,
        kept_top,
    );
    for (axis, count) in [(&y, 4), (&kept, 2)] {
        for tick in axis.ticks(count) {
            svg.line((plot_left, axis.at(tick)), (plot_right, axis.at(tick)), 1.0, GRID);
            svg.text((plot_left - 8.0, axis.at(tick) + 4.0), Anchor::End, 13.0, FAINT, &short(tick));
        }
    }
    for &dial in &dials {
        svg.text((x_of(dial), bottom + 20.0), Anchor::Middle, 13.0, FAINT, &short(dial));
    }
    svg.line((plot_left, bottom), (plot_right, bottom), 1.2, INK);
    svg.line((plot_left, accuracy_bottom), (plot_right, accuracy_bottom), 0.8, FAINT);
    let failures = failures(points);
    for (index, method) in methods.iter().enumerate() {
        let color = COLORS[index % COLORS.len()];
        let own = |point: &&StressPoint| point.disturbance == first.disturbance;
        let of_method = || method.points.iter().copied().filter(own);
        let along = |value: &dyn Fn(&StressPoint) -> f64| {
            of_method().map(|point| (x_of(point.dial), value(point))).collect::<Vec<_>>()
        };
        let accuracy = along(&|point| y.at(point.point.psnr_filled_db));
        svg.path(&accuracy, 2.2, color, "");
        for position in &accuracy {
            svg.marker(Marker::Dot, *position, 3.6, color);
        }
        svg.path(&along(&|point| kept.at(100.0 * point.kept_share)), 1.6, color, "");
        let failed =
            failures.iter().find(|failure| failure.method == method.kind).and_then(|failure| failure.dial);
        if let (Some(dial), Some(start)) = (failed, of_method().next()) {
            let position = (between(&dials, dial, &x_of), y.at(start.point.psnr_filled_db - LOST_DB));
            svg.marker(Marker::Cross, position, 6.0, color);
        }
    }
}

/// Horizontal position of a value between two values of the dial.
fn between(dials: &[f64], dial: f64, x_of: &dyn Fn(f64) -> f64) -> f64 {
    let pair = dials.windows(2).find(|pair| {
        let (low, high) = (pair[0].min(pair[1]), pair[0].max(pair[1]));
        (low..=high).contains(&dial)
    });
    let Some(&[from, to]) = pair else { return x_of(dial) };
    x_of(from) + (dial - from) / (to - from) * (x_of(to) - x_of(from))
}
