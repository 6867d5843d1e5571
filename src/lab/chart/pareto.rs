//! A sweep: accuracy against bytes, and against time, or one quantity against another, with the Pareto front of each.
//!
//! Labels beside points, so that none covers another.
//!
//! Purpose: charts name points that are close together. Source: greedy placement among fixed candidate positions (Christensen,
//! Marks, Shieber: An Empirical Study of Algorithms for Point-Feature Label Placement, 1995, section 3). What differs: candidates go
//! on outward, in rows above and below the point, until one is free.

use super::axis::{ChartAxis, Marker, Scale, short};
use super::svg::{Anchor, BLUE, Chart, FAINT, GREEN, GRID, INK, ORANGE, PINK, RED, Svg};
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
        Kernel::Point => FAINT,
        Kernel::Block => ORANGE,
        Kernel::Surfel => GREEN,
        Kernel::Gather => BLUE,
    }
}

/// Rivals and other programs have a color of their own.
fn point_color(point: &Point) -> &'static str {
    if point.series.is_rival() { PINK } else { kernel_color(point.settings.render.kernel) }
}

/// Ends of a point's bar, dB.
fn bar_db(point: &Point) -> [f64; 2] {
    [-1.0, 1.0].map(|sign| point.psnr_filled_db + sign * point.behind_best_db_se)
}

/// Draws a sweep of a capture.
pub fn pareto(capture: &str, points: &[Point]) -> Chart {
    let mut svg = Svg::new(WIDTH, HEIGHT);
    svg.text((40.0, 50.0), Anchor::Start, 30.0, INK, &format!("{capture}: accuracy, size and speed"));
    svg.text(
        (40.0, 80.0),
        Anchor::Start,
        17.0, FAINT,
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
    svg.upward((38.0, 0.5 * (TOP + BOTTOM)), 18.0, INK, &up.name);
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
    svg.text((40.0, 50.0), Anchor::Start, 30.0, INK, &format!("{capture}: what settings cost"));
    let words = format!("{} and baselines, holes filled alike", counted(points.len(), "setting"));
    svg.text((40.0, 80.0), Anchor::Start, 17.0, FAINT, &words);
    let (left, right) = (PANELS[0].0, width - 30.0);
    let x = ChartAxis::around(along.scale, points.iter().map(along.value), left, right);
    let y = ChartAxis::around(up.scale, points.iter().map(up.value), BOTTOM, TOP);
    let panel = Panel { along, up, left, right, x, y };
    panel.axes(&mut svg);
    if has_front {
        panel.front(&mut svg, points.to_vec());
    }
    panel.points(&mut svg, points, start);
    svg.upward((38.0, 0.5 * (TOP + BOTTOM)), 18.0, INK, &up.name);
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
            labels.draw(svg, self.position(point), 8.0, 14.0, PINK, &point.label);
        }
        for point in points.iter().filter(|point| point.series == Series::Reference) {
            let (x, y) = self.position(point);
            svg.marker(Marker::Ring, (x, y), 13.0, INK);
            svg.text((x + 18.0, y - 14.0), Anchor::Start, 17.0, INK, start);
        }
    }

    fn axes(&self, svg: &mut Svg) {
        let Self { left, right, x, y, .. } = self;
        let (left, right) = (*left, *right);
        for tick in y.ticks(8) {
            svg.line((left, y.at(tick)), (right, y.at(tick)), 1.0, GRID);
            svg.text((left - 10.0, y.at(tick) + 5.0), Anchor::End, 15.0, FAINT, &short(tick));
        }
        for tick in x.ticks(7) {
            svg.line((x.at(tick), TOP), (x.at(tick), BOTTOM), 1.0, GRID);
            svg.text((x.at(tick), BOTTOM + 24.0), Anchor::Middle, 15.0, FAINT, &short(tick));
        }
        svg.line((left, BOTTOM), (right, BOTTOM), 1.5, INK);
        svg.line((left, TOP), (left, BOTTOM), 1.5, INK);
        svg.text((0.5 * (left + right), BOTTOM + 54.0), Anchor::Middle, 18.0, INK, &self.along.name);
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
const FRONT_COLOR: &str = RED;
const FRONT_DASHES: &str = "7 5";

/// What kernels, the front and series look like, on a sheet of a width; `front` says what is on the front, if it is drawn.
fn legend(svg: &mut Svg, width: f64, points: &[Point], start: &str, front: Option<&str>) {
    let (mut x, y) = (100.0, BOTTOM + 110.0);
    svg.text((x, y), Anchor::Start, 16.0, FAINT, "kernel");
    x += 80.0;
    for kernel in Kernel::ALL.iter().rev() {
        if points.iter().any(|point| !point.series.is_rival() && point.settings.render.kernel == *kernel) {
            svg.marker(Marker::Dot, (x, y - 5.0), 7.0, kernel_color(*kernel));
            svg.text((x + 15.0, y), Anchor::Start, 16.0, INK, kernel.name());
            x += 110.0;
        }
    }
    if let Some(front) = front {
        svg.path(&[(x + 20.0, y - 5.0), (x + 70.0, y - 5.0)], FRONT_WIDTH, FRONT_COLOR, FRONT_DASHES);
        svg.text((x + 82.0, y), Anchor::Start, 16.0, INK, &format!("Pareto front: {front}"));
    }
    let (mut x, mut y) = (180.0, y + 40.0);
    svg.text((100.0, y), Anchor::Start, 16.0, FAINT, "samples");
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
            if series.is_rival() { PINK } else { INK },
        );
        if series == Series::Reference {
            svg.marker(Marker::Ring, (x, y - 5.0), 11.0, INK);
        }
        let name = if series == Series::Reference { start } else { series.name() };
        svg.text((x + 18.0, y), Anchor::Start, 16.0, INK, name);
        x += 340.0;
    }
}

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
