//! Axes: positions of values on the sheet, and round numbers for ticks.

/// How values are spread along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scale {
    Linear,
    /// Equal factors take equal room; values are positive.
    Log,
}

/// One axis on the sheet.
#[derive(Clone, Copy, Debug)]
pub(super) struct ChartAxis {
    scale: Scale,
    low: f64,
    high: f64,
    /// Where `low` and `high` lie on the sheet.
    from: f64,
    to: f64,
}

/// Room around the outermost values, as a share of their range.
const MARGIN: f64 = 0.06;

impl ChartAxis {
    /// An axis that shows all values, with some room around them.
    pub(super) fn around(scale: Scale, values: impl Iterator<Item = f64>, (from, to): (f64, f64)) -> Self {
        let spread = |value: f64| if scale == Scale::Log { value.max(1e-12).ln() } else { value };
        let (low, high) = values
            .filter(|value| value.is_finite())
            .map(spread)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        let (low, high) = if low > high { (0.0, 1.0) } else { (low, high) };
        let room = if high > low { MARGIN * (high - low) } else { 0.5 };
        Self { scale, low: low - room, high: high + room, from, to }
    }

    /// Where a value lies on the sheet.
    pub(super) fn at(&self, value: f64) -> f64 {
        let spread = if self.scale == Scale::Log { value.max(1e-12).ln() } else { value };
        self.from + (spread - self.low) / (self.high - self.low) * (self.to - self.from)
    }

    /// Round values along the axis, about `count` of them, ascending.
    pub(super) fn ticks(&self, count: usize) -> Vec<f64> {
        match self.scale {
            Scale::Linear => linear_ticks(self.low, self.high, count),
            Scale::Log => {
                let (low, high) = (self.low.exp(), self.high.exp());
                if high / low < 4.0 {
                    return linear_ticks(low, high, count);
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
        }
    }
}

fn linear_ticks(low: f64, high: f64, count: usize) -> Vec<f64> {
    let [step, finer] = round_steps(low, high, count);
    let ticks = multiples(low, high, step);
    // One tick is no scale.
    if ticks.len() < 2 { multiples(low, high, finer) } else { ticks }
}

/// The smallest step of 1, 2 or 5 times a power of ten that divides the range into at most `count` parts, and the next
/// finer one.
#[must_use]
pub fn round_steps(low: f64, high: f64, count: usize) -> [f64; 2] {
    const STEPS: [f64; 5] = [0.5, 1.0, 2.0, 5.0, 10.0];
    let rough = (high - low) / count.max(1) as f64;
    let power = 10_f64.powf(rough.log10().floor());
    let step = (1..4).find(|index| STEPS[*index] * power >= rough).unwrap_or(4);
    [power * STEPS[step], power * STEPS[step - 1]]
}

/// The multiples of `step` from `low` to `high`, ascending.
#[must_use]
pub fn multiples(low: f64, high: f64, step: f64) -> Vec<f64> {
    let first = (low / step).ceil() as i64;
    let last = (high / step).floor() as i64;
    (first..=last).map(|index| index as f64 * step).collect()
}

/// A number without zeros at its end.
pub(super) fn short(value: f64) -> String {
    let digits = format!("{value:.3}");
    if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.').to_owned() } else { digits }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_lie_within() {
        let axis = ChartAxis::around(Scale::Linear, [21.3, 27.1].into_iter(), (100.0, 0.0));
        assert_eq!(axis.ticks(8), [21.0, 22.0, 23.0, 24.0, 25.0, 26.0, 27.0]);
        assert!(axis.at(21.0) > axis.at(27.0));
        let axis = ChartAxis::around(Scale::Log, [0.9, 30.0].into_iter(), (0.0, 100.0));
        assert_eq!(axis.ticks(6), [1.0, 2.0, 5.0, 10.0, 20.0]);
        assert!((axis.at(2.0) - axis.at(1.0) - (axis.at(20.0) - axis.at(10.0))).abs() < 1e-9);
        assert_eq!(
            ["1", "0.25", "20", "0"],
            [1.0, 0.25, 20.0, 0.0].map(short).each_ref().map(String::as_str)
        );
    }

    #[test]
    fn an_axis_from_zero_has_a_tick_beside_it() {
        for high in [0.07, 0.9, 1.0, 2.3, 4.4, 9.0, 13.0, 47.0, 93.0] {
            let axis = ChartAxis::around(Scale::Linear, [0.0, high].into_iter(), (0.0, 1.0));
            let ticks = axis.ticks(2);
            assert!((2..=4).contains(&ticks.len()), "{high}: {ticks:?}");
        }
    }

    #[test]
    fn a_single_value_and_none_have_an_axis_too() {
        for values in [vec![3.0], vec![], vec![f64::NAN]] {
            for scale in [Scale::Linear, Scale::Log] {
                let axis = ChartAxis::around(scale, values.iter().copied(), (0.0, 1.0));
                assert!(axis.at(3.0).is_finite() && axis.ticks(5).len() < 40);
            }
        }
    }
}
