//! A sweep: accuracy against bytes, and against time, with the Pareto front of each.

use super::axis::{ChartAxis, Scale, short};
use super::color;
use super::labels::Labels;
use super::series::Marker;
use super::svg::{Anchor, Chart, Svg};
use crate::sweep::{Point, Series, mark_pareto};
use overlook_engine::plural::counted;
use overlook_engine::settings::Kernel;

const BYTES: &str = "samples in the store, MB";
const WIDTH: f64 = 1800.0;
const HEIGHT: f64 = 1080.0;
const TOP: f64 = 110.0;
const BOTTOM: f64 = 800.0;
const BAR: &str = "#c3c9d1";
/// Left and right of the two panels.
const PANELS: [(f64, f64); 2] = [(100.0, 890.0), (980.0, 1770.0)];

fn kernel_color(kernel: Kernel) -> &'static str {
    match kernel {
        Kernel::Point => color::FAINT,
        Kernel::Block => color::ORANGE,
        Kernel::Surfel => color::GREEN,
        Kernel::Gather => color::BLUE,
    }
}

/// Rivals and other programs have a color of their own.
fn point_color(point: &Point) -> &'static str {
    if point.series.is_rival() { color::PINK } else { kernel_color(point.settings.render.kernel) }
}

/// Ends of a point's bar, dB.
fn bar_db(point: &Point) -> [f64; 2] {
    [-1.0, 1.0].map(|sign| point.psnr_filled_db + sign * point.behind_best_db_se)
}

/// Draws a sweep of a capture.
pub fn pareto(capture: &str, points: &[Point]) -> Chart {
    let mut svg = Svg::new(WIDTH, HEIGHT);
    svg.text((40.0, 50.0), Anchor::Start, 30.0, color::INK, &format!("{capture}: accuracy, size and speed"));
    svg.text(
        (40.0, 80.0),
        Anchor::Start,
        17.0, color::FAINT,
        &format!(
            "{} and baselines; PSNR over all pixels that some camera saw, holes filled alike; bars are ± 1 standard error of the \
             difference to the most accurate one",
            counted(points.len(), "setting")
        ),
    );
    let y = ChartAxis::around(Scale::Linear, points.iter().flat_map(bar_db), BOTTOM, TOP);
    let mut panel = |(left, right): (f64, f64), name, cost: fn(&Point) -> f64| {
        let x = ChartAxis::around(Scale::Log, points.iter().map(cost), left, right);
        Panel { name, cost, left, right, x, y }.draw(&mut svg, points);
    };
    panel(PANELS[0], BYTES, Point::megabytes_of_samples);
    panel(PANELS[1], "rendering one view, ms", |point| point.milliseconds);
    svg.upward((38.0, 0.5 * (TOP + BOTTOM)), 18.0, color::INK, "accuracy, PSNR in dB");
    legend(&mut svg, points);
    svg.finish()
}

/// One panel: accuracy against a cost.
struct Panel<'a> {
    /// The cost with its unit.
    name: &'a str,
    cost: fn(&Point) -> f64,
    left: f64,
    right: f64,
    x: ChartAxis,
    y: ChartAxis,
}

impl Panel<'_> {
    fn position(&self, point: &Point) -> (f64, f64) {
        (self.x.at((self.cost)(point)), self.y.at(point.psnr_filled_db))
    }

    fn draw(&self, svg: &mut Svg, points: &[Point]) {
        self.axes(svg);
        self.front(svg, points.to_vec());
        for point in points {
            let (x, _) = self.position(point);
            let [low, high] = bar_db(point).map(|end| self.y.at(end));
            svg.line((x, low), (x, high), 0.8, BAR);
        }
        for (is_baseline, radius) in [(false, 5.0), (true, 8.0)] {
            for point in points.iter().filter(|point| point.series.is_baseline() == is_baseline) {
                let shape = Marker::of(point.series);
                svg.marker(shape, self.position(point), radius, point_color(point));
            }
        }
        let mut labels = Labels::new([self.left, TOP, self.right, BOTTOM]);
        for point in points.iter().filter(|point| point.series == Series::External) {
            labels.draw(svg, self.position(point), 8.0, 14.0, color::PINK, &point.label);
        }
        for point in points.iter().filter(|point| point.series == Series::Reference) {
            let (x, y) = self.position(point);
            svg.marker(Marker::Ring, (x, y), 13.0, color::INK);
            svg.text((x + 18.0, y - 14.0), Anchor::Start, 17.0, color::INK, "default");
        }
    }

    fn axes(&self, svg: &mut Svg) {
        let Self { left, right, x, y, .. } = self;
        let (left, right) = (*left, *right);
        for tick in y.ticks(8) {
            svg.line((left, y.at(tick)), (right, y.at(tick)), 1.0, color::GRID);
            svg.text((left - 10.0, y.at(tick) + 5.0), Anchor::End, 15.0, color::FAINT, &short(tick));
        }
        for tick in x.ticks(7) {
            svg.line((x.at(tick), TOP), (x.at(tick), BOTTOM), 1.0, color::GRID);
            svg.text((x.at(tick), BOTTOM + 24.0), Anchor::Middle, 15.0, color::FAINT, &short(tick));
        }
        svg.line((left, BOTTOM), (right, BOTTOM), 1.5, color::INK);
        svg.line((left, TOP), (left, BOTTOM), 1.5, color::INK);
        svg.text((0.5 * (left + right), BOTTOM + 54.0), Anchor::Middle, 18.0, color::INK, self.name);
    }

    /// The staircase along the points of the Pareto front.
    fn front(&self, svg: &mut Svg, mut best: Vec<Point>) {
        mark_pareto(&mut best, self.cost, |point| point.psnr_filled_db);
        best.retain(|point| point.pareto);
        best.sort_by(|a, b| (self.cost)(a).total_cmp(&(self.cost)(b)));
        let mut steps: Vec<(f64, f64)> = Vec::new();
        for (x, y) in best.iter().map(|point| self.position(point)) {
            if let Some(&(_, before)) = steps.last() {
                steps.push((x, before));
            }
            steps.push((x, y));
        }
        if let Some(&(_, last)) = steps.last() {
            steps.push((self.right, last));
        }
        svg.path(&steps, FRONT_WIDTH, FRONT_COLOR, FRONT_DASHES);
    }
}

/// The front's line.
const FRONT_WIDTH: f64 = 2.2;
const FRONT_COLOR: &str = color::RED;
const FRONT_DASHES: &str = "7 5";

fn legend(svg: &mut Svg, points: &[Point]) {
    let (mut x, y) = (100.0, BOTTOM + 110.0);
    svg.text((x, y), Anchor::Start, 16.0, color::FAINT, "kernel");
    x += 80.0;
    for kernel in Kernel::ALL.iter().rev() {
        if points.iter().any(|point| !point.series.is_rival() && point.settings.render.kernel == *kernel) {
            svg.marker(Marker::Dot, (x, y - 5.0), 7.0, kernel_color(*kernel));
            svg.text((x + 15.0, y), Anchor::Start, 16.0, color::INK, kernel.name());
            x += 110.0;
        }
    }
    svg.path(&[(x + 20.0, y - 5.0), (x + 70.0, y - 5.0)], FRONT_WIDTH, FRONT_COLOR, FRONT_DASHES);
    let words = "Pareto front: nothing is both cheaper and closer";
    svg.text((x + 82.0, y), Anchor::Start, 16.0, color::INK, words);
    let (mut x, mut y) = (180.0, y + 40.0);
    svg.text((100.0, y), Anchor::Start, 16.0, color::FAINT, "samples");
    for series in Series::ALL {
        if !points.iter().any(|point| point.series == series) {
            continue;
        }
        if x > 1450.0 {
            (x, y) = (180.0, y + 34.0);
        }
        svg.marker(
            Marker::of(series),
            (x, y - 5.0),
            if series.is_baseline() { 8.0 } else { 6.0 },
            if series.is_rival() { color::PINK } else { color::INK },
        );
        if series == Series::Reference {
            svg.marker(Marker::Ring, (x, y - 5.0), 11.0, color::INK);
        }
        svg.text((x + 18.0, y), Anchor::Start, 16.0, color::INK, series.name());
        x += 340.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial::{Trial, TrialResult};
    use overlook_engine::settings::Settings;

    #[test]
    fn the_bars_of_uncertain_points_stay_within_the_panel() {
        let measured = TrialResult { bytes: 1, milliseconds: 1.0, ..TrialResult::default() };
        let point = |psnr_filled_db, behind_best_db_se| Point {
            psnr_filled_db,
            behind_best_db_se,
            ..Point::new(&Trial::new("t", Settings::default()), Series::Variation, &measured)
        };
        let chart = pareto("scene", &[point(30.0, 4.0), point(30.5, 0.1)]);
        let bars: Vec<&str> = chart.svg.lines().filter(|line| line.contains(BAR)).collect();
        assert_eq!(bars.len(), 4, "two points in two panels");
        for bar in bars {
            let path = bar.split('"').nth(1).unwrap().replace(['M', 'L'], " ");
            let numbers: Vec<f64> = path.split_whitespace().map(|number| number.parse().unwrap()).collect();
            assert!([numbers[1], numbers[3]].iter().all(|y| (TOP..=BOTTOM).contains(y)), "{bar}");
        }
    }
}
