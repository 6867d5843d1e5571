//! What a chart can show along an axis, and the round values that mark it: a handful, on logarithmic axes too.

use std::ops::RangeInclusive;

use egui_plot::GridMark;

use super::text;
use overlook_lab::chart::axis::{multiples, round_steps};
use overlook_lab::sweep::Point;

/// A quantity along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quantity {
    Psnr,
    Ssim,
    Flip,
    Coverage,
    Bytes,
    Samples,
    Milliseconds,
    Seconds,
}

impl Quantity {
    /// Every quantity: name, and whether its axis is logarithmic.
    pub(crate) const ALL: [(Self, &'static str, bool); 8] = [
        (Self::Psnr, "PSNR, holes filled, dB", false),
        (Self::Ssim, "SSIM", false),
        (Self::Flip, "FLIP", false),
        (Self::Coverage, "Coverage", false),
        (Self::Bytes, "Store size", true),
        (Self::Samples, "Samples", true),
        (Self::Milliseconds, "Rendering a view, ms", true),
        (Self::Seconds, "Preprocessing, s", true),
    ];

    pub(crate) fn name(self) -> &'static str {
        Self::ALL.iter().find(|(of, ..)| *of == self).map_or("", |(_, name, _)| name)
    }

    /// Its name with the direction in which it is better, for an axis.
    pub(crate) fn axis_name(self) -> String {
        let better = if self.is_gain() { "higher" } else { "lower" };
        format!("{} ({better} is better)", self.name())
    }

    pub(crate) fn is_gain(self) -> bool {
        matches!(self, Self::Psnr | Self::Ssim | Self::Coverage)
    }

    /// What is lost by it: better where smaller.
    pub(crate) fn cost(self, point: &Point) -> f64 {
        match self {
            // As the front of the command line has it.
            Self::Bytes => point.bytes_of_samples() as f64,
            _ if self.is_gain() => -self.value(point),
            _ => self.value(point),
        }
    }

    /// Its value in words.
    pub(crate) fn words(self, point: &Point) -> String {
        match self {
            Self::Psnr => format!("{:.2}", point.psnr_filled_db),
            Self::Ssim | Self::Flip => format!("{:.3}", self.value(point)),
            Self::Coverage => format!("{:.1} %", 100.0 * point.coverage),
            Self::Bytes => text::bytes(point.bytes),
            Self::Samples => text::count(point.samples),
            Self::Milliseconds | Self::Seconds => text::significant(self.value(point)),
        }
    }

    /// Its value, as its axis shows it.
    pub(crate) fn of(self, point: &Point) -> f64 {
        let value = self.value(point);
        if self.is_log() { value.max(1e-3).log10() } else { value }
    }

    fn value(self, point: &Point) -> f64 {
        match self {
            Self::Psnr => point.psnr_filled_db,
            Self::Ssim => point.ssim,
            Self::Flip => point.flip,
            Self::Coverage => point.coverage,
            Self::Bytes => point.bytes as f64,
            Self::Samples => point.samples as f64,
            Self::Milliseconds => point.milliseconds,
            Self::Seconds => point.seconds_preprocess,
        }
    }

    /// Whether its axis is logarithmic.
    pub(crate) fn is_log(self) -> bool {
        Self::ALL.iter().any(|(of, _, log)| *of == self && *log)
    }
}

/// Marks that are aimed at.
const MARKS: usize = 6;

/// Marks of a logarithmic axis are at least so far apart, in parts of what is aimed at.
const ROOM: f64 = 0.9;

/// Beyond this ratio of its ends a logarithmic axis is marked at 1, 2 and 5 of every power of ten.
const WIDE: f64 = 8.0;

/// Marks between `low` and `high`, which for a logarithmic axis are decimal logarithms.
pub(crate) fn marks((low, high): (f64, f64), log: bool) -> Vec<GridMark> {
    // All of them equally strong.
    let step_size = (high - low) / MARKS as f64;
    if !(step_size.is_finite() && step_size > 0.0) {
        return Vec::new();
    }
    let values = if !log {
        round_values(low, high)
    } else if 10_f64.powf(high - low) < WIDE {
        let values = round_values(10_f64.powf(low), 10_f64.powf(high)).into_iter();
        let mut last = f64::NEG_INFINITY;
        // Toward the upper end they come closer together than their labels are wide.
        let has_room = |value: &f64| {
            let fits = value - last >= ROOM * step_size;
            last = if fits { *value } else { last };
            fits
        };
        values.filter(|value| *value > 0.0).map(f64::log10).filter(has_room).collect()
    } else {
        let decades = low.floor() as i32..=high.ceil() as i32;
        let whole = high - low > MARKS as f64 / 2.0;
        let factors: &[f64] = if whole { &[1.0] } else { &[1.0, 2.0, 5.0] };
        decades
            .flat_map(|decade| factors.iter().map(move |factor| f64::from(decade) + factor.log10()))
            .collect()
    };
    let inside = values.into_iter().filter(|value| (low..=high).contains(value));
    inside.map(|value| GridMark { value, step_size }).collect()
}

/// The value at a mark of the axis that shows `range`, with as many decimals as its marks need to differ.
pub(crate) fn label(mark: GridMark, range: &RangeInclusive<f64>, log: bool) -> String {
    let shown = |value: f64| if log { 10_f64.powf(value) } else { value };
    let (low, high) = (shown(*range.start()), shown(*range.end()));
    let value = shown(mark.value);
    if (log && high / low >= WIDE) || high <= low {
        return text::significant(value);
    }
    // A step of a power of ten may have come out a little smaller.
    let decimals = -(round_steps(low, high, MARKS)[0].log10() + 1e-9).floor();
    format!("{value:.*}", decimals.clamp(0.0, 9.0) as usize)
}

fn round_values(low: f64, high: f64) -> Vec<f64> {
    multiples(low, high, round_steps(low, high, MARKS)[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(low: f64, high: f64, log: bool) -> Vec<f64> {
        let value = |mark: GridMark| if log { 10_f64.powf(mark.value) } else { mark.value };
        marks((low, high), log).into_iter().map(|mark| (value(mark) * 1e6).round() / 1e6).collect()
    }

    #[test]
    fn axes_are_marked_at_round_values() {
        assert_eq!(values(22.4, 28.1, false), [23.0, 24.0, 25.0, 26.0, 27.0, 28.0]);
        assert_eq!(values(3.1_f64.log10(), 4.2_f64.log10(), true), [3.2, 3.4, 3.6, 3.8, 4.0, 4.2]);
        assert_eq!(values(2.2_f64.log10(), 8.1_f64.log10(), true), [3.0, 4.0, 5.0, 7.0]);
        assert_eq!(values(0.9_f64.log10(), 60_f64.log10(), true), [1.0, 2.0, 5.0, 10.0, 20.0, 50.0]);
        assert_eq!(values(0.0, 4.0, true), [1.0, 10.0, 100.0, 1000.0, 10000.0]);
        assert_eq!(marks((1.0, 1.0), false), []);
    }

    #[test]
    fn marks_that_lie_close_together_are_told_apart_by_their_decimals() {
        let labels = |low: f64, high: f64, log: bool| -> Vec<String> {
            marks((low, high), log).into_iter().map(|mark| label(mark, &(low..=high), log)).collect()
        };
        assert_eq!(labels(0.951, 0.976, false), ["0.955", "0.960", "0.965", "0.970", "0.975"]);
        assert_eq!(labels(0.000_3, 0.002_3, false), ["0.0005", "0.0010", "0.0015", "0.0020"]);
        assert_eq!(labels(22.4, 28.1, false), ["23", "24", "25", "26", "27", "28"]);
        assert_eq!(labels(4.01_f64.log10(), 4.06_f64.log10(), true)[..3], ["4.01", "4.02", "4.03"]);
        assert_eq!(labels(0.02_f64.log10(), 0.3_f64.log10(), true), ["0.0200", "0.0500", "0.10", "0.20"]);
    }
}
