//! Several captures: by how much settings and methods are ahead of the default, against their bytes.

use super::axis::{ChartAxis, Marker, Scale, short};
use super::pareto::Labels;
use super::svg::{Anchor, BLUE, Chart, FAINT, GRID, INK, ORANGE, PINK, Svg};
use crate::sweep::Series;
use crate::trial::MeanEstimate;

const WIDTH: f64 = 1300.0;
const HEIGHT: f64 = 640.0;
const PLOT: [f64; 4] = [90.0, 60.0, 1270.0, 560.0];

/// A setting or method over all captures.
pub(crate) struct TogetherPoint {
    pub(crate) label: String,
    pub(crate) series: Series,
    /// As a share of the default's.
    pub(crate) bytes: f64,
    /// Lead over the default, mean over captures.
    pub(crate) ahead_db: MeanEstimate,
}

/// Draws all captures together.
pub(crate) fn together(points: &[TogetherPoint]) -> Chart {
    let [left, top, right, bottom] = PLOT;
    let mut svg = Svg::new(WIDTH, HEIGHT);
    svg.text((left, 34.0), Anchor::Start, 20.0, INK, "Mean difference to the default, over captures");
    let bar = |point: &TogetherPoint| {
        [-1.0, 1.0].map(|sign| point.ahead_db.mean + sign * point.ahead_db.standard_error)
    };
    let y = ChartAxis::around(Scale::Linear, points.iter().flat_map(bar).chain([0.0]), bottom, top);
    let x = ChartAxis::around(Scale::Log, points.iter().map(|point| point.bytes), left, right);
    for tick in y.ticks(8) {
        svg.line((left, y.at(tick)), (right, y.at(tick)), 1.0, GRID);
        svg.text((left - 10.0, y.at(tick) + 5.0), Anchor::End, 14.0, FAINT, &short(tick));
    }
    for tick in x.ticks(8) {
        svg.line((x.at(tick), top), (x.at(tick), bottom), 1.0, GRID);
        svg.text((x.at(tick), bottom + 22.0), Anchor::Middle, 14.0, FAINT, &short(tick));
    }
    svg.line((left, y.at(0.0)), (right, y.at(0.0)), 1.2, INK);
    svg.text(
        (0.5 * (left + right), bottom + 50.0),
        Anchor::Middle,
        16.0,
        INK,
        "bytes, as a share of the default's",
    );
    svg.upward((30.0, 0.5 * (top + bottom)), 16.0, INK, "dB ahead of the default");
    let mut labels = Labels::new(PLOT);
    for point in points {
        let at = (x.at(point.bytes), y.at(point.ahead_db.mean));
        let [low, high] = bar(point).map(|end| y.at(end));
        svg.line((at.0, low), (at.0, high), 0.8, FAINT);
        let (marker, ink) = match point.series {
            Series::Reference => (Marker::Ring, INK),
            Series::Variation => (Marker::Dot, BLUE),
            series if series.is_rival() => (Marker::Square, PINK),
            _ => (Marker::Diamond, ORANGE),
        };
        svg.marker(marker, at, 6.0, ink);
        if point.series != Series::Variation {
            labels.draw(&mut svg, at, 6.0, 12.0, ink, &point.label);
        }
    }
    svg.finish()
}
