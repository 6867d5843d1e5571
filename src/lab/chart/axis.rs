//! Axes and series: positions of values on the sheet, round numbers for ticks, and points that are drawn alike.

use crate::sweep::Series;

/// How values are spread along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences take equal room.
    Linear,
    /// Equal factors take equal room; values are positive.
    Log,
}

/// Ends of a logarithmic axis less than this factor apart have evenly spaced ticks between them.
const NARROW: f64 = 4.0;

impl Scale {
    /// Round values from `low` to `high`, ascending; about `count` of them where they are evenly spaced.
    #[must_use]
    pub fn ticks(self, low: f64, high: f64, count: usize) -> Vec<f64> {
        if self.is_even(low, high) {
            return multiples(low, high, even_step(low, high, count));
        }
        let steps: &[f64] = match high / low {
            ..12.0 => &[1.0, 1.5, 2.0, 3.0, 5.0, 7.0],
            12.0..400.0 => &[1.0, 2.0, 5.0],
            _ => &[1.0],
        };
        let decades = low.log10().floor() as i32..=high.log10().ceil() as i32;
        let all = decades.flat_map(|decade| steps.iter().map(move |step| step * 10_f64.powi(decade)));
        all.filter(|tick| (low..=high).contains(tick)).collect()
    }

    /// The number at a tick of [`Self::ticks`], with as many decimals as ticks need to differ.
    #[must_use]
    pub fn label(self, tick: f64, low: f64, high: f64, count: usize) -> String {
        if !self.is_even(low, high) {
            return trimmed(tick, (1.0 - tick.log10().floor()).clamp(0.0, 9.0) as usize);
        }
        // A step of a power of ten may have come out a little smaller.
        let decimals = -(even_step(low, high, count).log10() + 1e-9).floor();
        format!("{tick:.*}", decimals.clamp(0.0, 9.0) as usize)
    }

    /// Whether ticks from `low` to `high` lie at equal steps.
    #[must_use]
    pub fn is_even(self, low: f64, high: f64) -> bool {
        self == Self::Linear || high / low < NARROW
    }
}

/// One axis on the sheet.
#[derive(Clone, Copy, Debug)]
pub(super) struct ChartAxis {
    scale: Scale,
    low: f64,
    high: f64,
    /// Positions of `low` and `high` on the sheet, pixels.
    from: f64,
    to: f64,
}

/// Room around the outermost values, as a share of their range.
const MARGIN: f64 = 0.06;

impl ChartAxis {
    /// An axis that shows all values with some room around them, and runs from one place on the sheet to another, in pixels.
    pub(super) fn around(scale: Scale, values: impl Iterator<Item = f64>, from: f64, to: f64) -> Self {
        let spread = |value: f64| if scale == Scale::Log { value.max(1e-12).ln() } else { value };
        let (low, high) = values
            .filter(|value| value.is_finite())
            .map(spread)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        let (low, high) = if low > high { (0.0, 1.0) } else { (low, high) };
        let room = if high > low { MARGIN * (high - low) } else { 0.5 };
        Self { scale, low: low - room, high: high + room, from, to }
    }

    /// Position of a value on the sheet, pixels.
    pub(super) fn at(&self, value: f64) -> f64 {
        let spread = if self.scale == Scale::Log { value.max(1e-12).ln() } else { value };
        self.from + (spread - self.low) / (self.high - self.low) * (self.to - self.from)
    }

    /// Round values along the axis, about `count` of them, ascending.
    pub(super) fn ticks(&self, count: usize) -> Vec<f64> {
        match self.scale {
            Scale::Linear => self.scale.ticks(self.low, self.high, count),
            Scale::Log => self.scale.ticks(self.low.exp(), self.high.exp(), count),
        }
    }
}

/// The smallest step of 1, 2 or 5 times a power of ten that divides the range into at most `count` parts. If fewer than two ticks result,
/// the next finer step is taken, because one tick is no scale.
fn even_step(low: f64, high: f64, count: usize) -> f64 {
    const STEPS: [f64; 5] = [0.5, 1.0, 2.0, 5.0, 10.0];
    let rough = (high - low) / count.max(1) as f64;
    let power = 10_f64.powf(rough.log10().floor());
    let index = (1..4).find(|index| STEPS[*index] * power >= rough).unwrap_or(4);
    let [step, finer] = [power * STEPS[index], power * STEPS[index - 1]];
    if multiples(low, high, step).len() < 2 { finer } else { step }
}

/// The multiples of `step` from `low` to `high`, ascending.
fn multiples(low: f64, high: f64, step: f64) -> Vec<f64> {
    let first = (low / step).ceil() as i64;
    let last = (high / step).floor() as i64;
    (first..=last).map(|index| index as f64 * step).collect()
}

/// A number with at most three decimals, without zeros at its end.
pub(super) fn short(value: f64) -> String {
    trimmed(value, 3)
}

fn trimmed(value: f64, decimals: usize) -> String {
    let digits = format!("{value:.decimals$}");
    if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.').to_owned() } else { digits }
}

/// Shape of a marker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    /// A filled circle.
    Dot,
    /// A filled square.
    Square,
    /// A filled square on its corner.
    Diamond,
    /// A filled triangle that points up.
    Up,
    /// A filled triangle that points down.
    Down,
    /// Two strokes along the diagonals.
    Cross,
    /// Two strokes along the axes.
    Plus,
    /// A star of strokes.
    Star,
    /// A circle that is not filled.
    Ring,
}

impl Marker {
    /// The marker of a point of a sweep.
    #[must_use]
    pub fn of(series: Series) -> Self {
        match series {
            Series::Reference | Series::Variation => Self::Dot,
            Series::NoPruning | Series::TriangleMesh => Self::Up,
            Series::FirstCamera | Series::NearestCamera => Self::Down,
            Series::FirstCameraAtCount | Series::LayeredDepthImage => Self::Diamond,
            Series::Random => Self::Cross,
            Series::VoxelGrid | Series::Tsdf => Self::Square,
            Series::SingleCamera => Self::Plus,
            Series::Paper | Series::External => Self::Star,
        }
    }
}

/// Points of a chart that are drawn alike.
pub struct ChartSeries<'a, K, P> {
    /// What they have in common.
    pub kind: K,
    /// In the order given.
    pub points: Vec<&'a P>,
}

/// Groups points by their kind, kinds in the order in which they first come.
pub fn series<'a, K: PartialEq, P>(points: &'a [P], kind: impl Fn(&'a P) -> K) -> Vec<ChartSeries<'a, K, P>> {
    let mut all: Vec<ChartSeries<'a, K, P>> = Vec::new();
    for point in points {
        let kind = kind(point);
        match all.iter_mut().find(|series| series.kind == kind) {
            Some(series) => series.points.push(point),
            None => all.push(ChartSeries { kind, points: vec![point] }),
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_lie_within() {
        let axis = ChartAxis::around(Scale::Linear, [21.3, 27.1].into_iter(), 100.0, 0.0);
        assert_eq!(axis.ticks(8), [21.0, 22.0, 23.0, 24.0, 25.0, 26.0, 27.0]);
        assert!(axis.at(21.0) > axis.at(27.0));
        let axis = ChartAxis::around(Scale::Log, [0.9, 30.0].into_iter(), 0.0, 100.0);
        assert_eq!(axis.ticks(6), [1.0, 2.0, 5.0, 10.0, 20.0]);
        assert!((axis.at(2.0) - axis.at(1.0) - (axis.at(20.0) - axis.at(10.0))).abs() < 1e-9);
        assert_eq!(
            ["1", "0.25", "20", "0"],
            [1.0, 0.25, 20.0, 0.0].map(short).each_ref().map(String::as_str)
        );
    }

    #[test]
    fn ticks_that_lie_close_together_are_told_apart_by_their_decimals() {
        let labels = |scale: Scale, low: f64, high: f64| -> Vec<String> {
            scale.ticks(low, high, 6).into_iter().map(|tick| scale.label(tick, low, high, 6)).collect()
        };
        assert_eq!(labels(Scale::Linear, 0.951, 0.976), ["0.955", "0.960", "0.965", "0.970", "0.975"]);
        assert_eq!(labels(Scale::Linear, 0.000_3, 0.002_3), ["0.0005", "0.0010", "0.0015", "0.0020"]);
        assert_eq!(labels(Scale::Linear, 22.4, 28.1), ["23", "24", "25", "26", "27", "28"]);
        assert_eq!(labels(Scale::Log, 4.01, 4.06)[..3], ["4.01", "4.02", "4.03"]);
        assert_eq!(labels(Scale::Log, 2.2, 8.1), ["3", "4", "5", "6", "7", "8"]);
        assert_eq!(labels(Scale::Log, 0.9, 8.0), ["1", "1.5", "2", "3", "5", "7"]);
        let labels_of_small = ["0.001", "0.0015", "0.002", "0.003", "0.005", "0.007", "0.01"];
        assert_eq!(labels(Scale::Log, 0.000_9, 0.010_5), labels_of_small);
        assert_eq!(labels(Scale::Log, 0.02, 0.3), ["0.02", "0.05", "0.1", "0.2"]);
        assert_eq!(labels(Scale::Log, 0.9, 1.1e4), ["1", "10", "100", "1000", "10000"]);
    }

    #[test]
    fn an_axis_from_zero_has_a_tick_beside_it() {
        for high in [0.07, 0.9, 1.0, 2.3, 4.4, 9.0, 13.0, 47.0, 93.0] {
            let axis = ChartAxis::around(Scale::Linear, [0.0, high].into_iter(), 0.0, 1.0);
            let ticks = axis.ticks(2);
            assert!((2..=4).contains(&ticks.len()), "{high}: {ticks:?}");
        }
    }

    #[test]
    fn a_single_value_and_none_have_an_axis_too() {
        for values in [vec![3.0], vec![], vec![f64::NAN]] {
            for scale in [Scale::Linear, Scale::Log] {
                let axis = ChartAxis::around(scale, values.iter().copied(), 0.0, 1.0);
                assert!(axis.at(3.0).is_finite() && axis.ticks(5).len() < 40);
            }
        }
    }

    #[test]
    fn points_of_a_kind_are_one_series_in_the_order_given() {
        let all = series(&[3, 1, 5, 2], |number| number % 2);
        let all: Vec<_> = all.into_iter().map(|series| (series.kind, series.points)).collect();
        assert_eq!(all, [(1, vec![&3, &1, &5]), (0, vec![&2])]);
    }
}
