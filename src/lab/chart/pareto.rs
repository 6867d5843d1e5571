//! A sweep: accuracy against bytes, and against time, or one quantity against another, with the Pareto front of each.

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
/// The sheet with one panel, which has fewer entries of the legend in a row.
const NARROW: [f64; 2] = [1300.0, 1120.0];

/// A quantity along an axis.
pub struct ChartQuantity<'a> {
    /// Its name with its unit.
    pub name: String,
    /// How its values are spread.
    pub scale: Scale,
    /// Its value at a point: finite, and positive where its scale is logarithmic.
    pub value: &'a dyn Fn(&Point) -> f64,
    /// Whether more of it is better.
    pub is_gain: bool,
}

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
    let up = ChartQuantity {
        name: "accuracy, PSNR in dB".to_owned(),
        scale: Scale::Linear,
        value: &|point| point.psnr_filled_db,
        is_gain: true,
    };
    let y = ChartAxis::around(Scale::Linear, points.iter().flat_map(bar_db), BOTTOM, TOP);
    let mut panel = |(left, right): (f64, f64), name: &str, cost: fn(&Point) -> f64| {
        let x = ChartAxis::around(Scale::Log, points.iter().map(cost), left, right);
        let along = ChartQuantity { name: name.to_owned(), scale: Scale::Log, value: &cost, is_gain: false };
        let panel = Panel { along: &along, up: &up, left, right, x, y };
        panel.axes(&mut svg);
        panel.front(&mut svg, points.to_vec());
        panel.bars(&mut svg, points);
        panel.points(&mut svg, points, "default");
    };
    panel(PANELS[0], BYTES, Point::megabytes_of_samples);
    panel(PANELS[1], "rendering one view, ms", |point| point.milliseconds);
    svg.upward((38.0, 0.5 * (TOP + BOTTOM)), 18.0, color::INK, &up.name);
    legend(&mut svg, WIDTH, points, Series::Reference.name(), Some("nothing is both cheaper and closer"));
    svg.finish()
}

/// Draws one quantity of a sweep of a capture against another, along and up. `start` names the settings that the sweep started from.
#[must_use]
pub fn tradeoff(
    capture: &str,
    points: &[Point],
    [along, up]: &[ChartQuantity<'_>; 2],
    start: &str,
    has_front: bool,
) -> Chart {
    let [width, height] = NARROW;
    let mut svg = Svg::new(width, height);
    svg.text((40.0, 50.0), Anchor::Start, 30.0, color::INK, &format!("{capture}: what settings cost"));
    let words = format!("{} and baselines, holes filled alike", counted(points.len(), "setting"));
    svg.text((40.0, 80.0), Anchor::Start, 17.0, color::FAINT, &words);
    let (left, right) = (PANELS[0].0, width - 30.0);
    let x = ChartAxis::around(along.scale, points.iter().map(along.value), left, right);
    let y = ChartAxis::around(up.scale, points.iter().map(up.value), BOTTOM, TOP);
    let panel = Panel { along, up, left, right, x, y };
    panel.axes(&mut svg);
    if has_front {
        panel.front(&mut svg, points.to_vec());
    }
    panel.points(&mut svg, points, start);
    svg.upward((38.0, 0.5 * (TOP + BOTTOM)), 18.0, color::INK, &up.name);
    legend(&mut svg, width, points, start, has_front.then_some("nothing is better in both"));
    svg.finish()
}

/// One panel: a quantity against another.
struct Panel<'a> {
    along: &'a ChartQuantity<'a>,
    up: &'a ChartQuantity<'a>,
    left: f64,
    right: f64,
    x: ChartAxis,
    y: ChartAxis,
}

impl Panel<'_> {
    fn position(&self, point: &Point) -> (f64, f64) {
        (self.x.at((self.along.value)(point)), self.y.at((self.up.value)(point)))
    }

    fn bars(&self, svg: &mut Svg, points: &[Point]) {
        for point in points {
            let (x, _) = self.position(point);
            let [low, high] = bar_db(point).map(|end| self.y.at(end));
            svg.line((x, low), (x, high), 0.8, BAR);
        }
    }

    fn points(&self, svg: &mut Svg, points: &[Point], start: &str) {
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
            svg.text((x + 18.0, y - 14.0), Anchor::Start, 17.0, color::INK, start);
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
        svg.text((0.5 * (left + right), BOTTOM + 54.0), Anchor::Middle, 18.0, color::INK, &self.along.name);
    }

    /// The staircase along the points of the Pareto front. A step is as good as the point from which less of one quantity is had for
    /// nothing of the other: at its left where more along is better, else at its right.
    fn front(&self, svg: &mut Svg, mut best: Vec<Point>) {
        let sign = |is_wanted: bool| if is_wanted { 1.0 } else { -1.0 };
        let (cost, gain) = (sign(!self.along.is_gain), sign(self.up.is_gain));
        mark_pareto(
            &mut best,
            |point| cost * (self.along.value)(point),
            |point| gain * (self.up.value)(point),
        );
        best.retain(|point| point.pareto);
        best.sort_by(|a, b| (self.along.value)(a).total_cmp(&(self.along.value)(b)));
        let mut steps: Vec<(f64, f64)> = Vec::new();
        for (x, y) in best.iter().map(|point| self.position(point)) {
            match steps.last() {
                Some(&(before, _)) if self.along.is_gain => steps.push((before, y)),
                Some(&(_, before)) => steps.push((x, before)),
                None if self.along.is_gain => steps.push((self.left, y)),
                None => {}
            }
            steps.push((x, y));
        }
        if let Some(&(_, last)) = steps.last().filter(|_| !self.along.is_gain) {
            steps.push((self.right, last));
        }
        svg.path(&steps, FRONT_WIDTH, FRONT_COLOR, FRONT_DASHES);
    }
}

/// The front's line.
const FRONT_WIDTH: f64 = 2.2;
const FRONT_COLOR: &str = color::RED;
const FRONT_DASHES: &str = "7 5";

/// What kernels, the front and series look like, on a sheet of a width; `front` says what is on the front, if it is drawn.
fn legend(svg: &mut Svg, width: f64, points: &[Point], start: &str, front: Option<&str>) {
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
    if let Some(front) = front {
        svg.path(&[(x + 20.0, y - 5.0), (x + 70.0, y - 5.0)], FRONT_WIDTH, FRONT_COLOR, FRONT_DASHES);
        svg.text((x + 82.0, y), Anchor::Start, 16.0, color::INK, &format!("Pareto front: {front}"));
    }
    let (mut x, mut y) = (180.0, y + 40.0);
    svg.text((100.0, y), Anchor::Start, 16.0, color::FAINT, "samples");
    for series in Series::ALL {
        if !points.iter().any(|point| point.series == series) {
            continue;
        }
        if x > width - 350.0 {
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
        let name = if series == Series::Reference { start } else { series.name() };
        svg.text((x + 18.0, y), Anchor::Start, 16.0, color::INK, name);
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

    #[test]
    fn any_quantity_is_drawn_against_any_other_and_the_front_has_the_best_of_both() {
        let point = |ssim, seconds_preprocess, psnr_filled_db| Point {
            psnr_filled_db,
            ssim,
            seconds_preprocess,
            ..Point::new(&Trial::new("t", Settings::default()), Series::Variation, &TrialResult::default())
        };
        let points = [point(0.9, 10.0, 20.0), point(0.8, 1.0, 20.0), point(0.7, 5.0, 20.0)];
        let axes = [
            ChartQuantity {
                name: "SSIM".to_owned(),
                scale: Scale::Linear,
                value: &|point| point.ssim,
                is_gain: true,
            },
            ChartQuantity {
                name: "Pruning, s".to_owned(),
                scale: Scale::Log,
                value: &|point| point.seconds_preprocess,
                is_gain: false,
            },
        ];
        let chart = tradeoff("scene", &points, &axes, "mine", true);
        for words in ["SSIM", "Pruning, s", "Pareto front: nothing is better in both"] {
            assert!(chart.svg.contains(words), "{words}");
        }
        let front = chart.svg.lines().find(|line| line.contains("stroke-dasharray=\"7 5\"")).unwrap();
        // From the left edge to the fast one, and up to the similar one: the third is beaten in both.
        assert_eq!(front.matches('L').count(), 3, "{front}");
        assert!(!tradeoff("scene", &points, &axes, "mine", false).svg.contains("Pareto front"));
    }
}
