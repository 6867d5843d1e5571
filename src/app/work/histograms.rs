//! The quantities that thresholds cut, as histograms: worked out on a lane for the frame shown.

use std::sync::Arc;

use crate::preprocess::PreparedScan;
use crate::preprocess::inspect::{FrameInspection, PairQuantities, pair_quantities};
use crate::preprocess::noise::granted_range_sigmas;
use crate::preprocess::registration::Outcome;
use crate::preprocess::temporal::{SequenceRanges, StaticTest};
use crate::settings::{Field, Settings, ValueKind};

/// Bars of a histogram.
pub(crate) const BARS: usize = 56;

/// Pairs of samples, and pixels, that are looked at.
const AT_MOST: usize = 30_000;

/// Standard deviations of the difference of two colors that the same-surface test grants.
const COLOR_SIGMAS: f32 = 3.0;

/// On logarithmic axes that begin at 0: the smallest value told apart, as a share of the largest.
const SMALLEST_SHARE: f64 = 1e-4;

/// The axis of a threshold: that of its slider.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ThresholdAxis {
    min: f64,
    max: f64,
    log: bool,
}

impl ThresholdAxis {
    /// The axis of a setting; `None` where it is no number.
    pub(crate) fn of(field: &Field) -> Option<Self> {
        match field.kind {
            ValueKind::Number { min, max, log } => {
                let min = if log { min.max(max * SMALLEST_SHARE) } else { min };
                Some(Self { min, max, log })
            }
            _ => None,
        }
    }

    /// Where a value lies, 0 to 1.
    pub(crate) fn position(self, value: f64) -> f32 {
        let value = value.clamp(self.min, self.max);
        let share = if self.log {
            (value / self.min).ln() / (self.max / self.min).ln()
        } else {
            (value - self.min) / (self.max - self.min)
        };
        share as f32
    }

    /// The value at a place, with three digits: nobody drags more finely.
    pub(crate) fn value(self, position: f32) -> f64 {
        let share = f64::from(position.clamp(0.0, 1.0));
        let value = if self.log {
            self.min * (self.max / self.min).powf(share)
        } else {
            self.min + (self.max - self.min) * share
        };
        let unit = 10_f64.powf(value.abs().max(1e-12).log10().floor() - 2.0);
        ((value / unit).round() * unit).clamp(self.min, self.max)
    }
}

/// The settings that cut something that is counted here.
pub(crate) const CUT: [&str; 5] = [
    "pruning.depth_tolerance",
    "pruning.normal_tolerance",
    "pruning.color_tolerance",
    "spans.color_tolerance",
    "spans.depth_tolerance",
];

/// A quantity over many pixels, cut by a threshold.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ThresholdHistogram {
    /// The setting that cuts it.
    pub path: &'static str,
    /// What is counted.
    pub of: &'static str,
    /// Per bar: what passes all rules, and what does not.
    pub bars: Vec<[u32; 2]>,
    /// Every value, ascending.
    sorted: Vec<f32>,
    /// The frame it is of; `None` where it is of all.
    pub frame: Option<usize>,
    /// What the measured noise explains, in the unit of the axis; `None` where none was measured.
    pub noise: Option<f32>,
}

impl ThresholdHistogram {
    fn new(
        path: &'static str,
        of: &'static str,
        noise: Option<f32>,
        values: Vec<(f32, bool)>,
    ) -> Option<Self> {
        let axis = Settings::fields().find(|field| field.path == path).and_then(ThresholdAxis::of)?;
        let mut bars = vec![[0; 2]; BARS];
        let mut sorted = Vec::with_capacity(values.len());
        for (value, passes) in values {
            if value.is_nan() {
                continue;
            }
            let bar = (axis.position(f64::from(value)) * BARS as f32) as usize;
            bars[bar.min(BARS - 1)][usize::from(!passes)] += 1;
            sorted.push(value);
        }
        sorted.sort_unstable_by(f32::total_cmp);
        Some(Self { path, of, bars, sorted, frame: None, noise: noise.filter(|noise| *noise > 0.0) })
    }

    /// Whether anything was counted.
    pub(crate) fn is_empty(&self) -> bool {
        self.sorted.is_empty()
    }

    /// How many values lie within a threshold, and how many beyond.
    pub(crate) fn sides(&self, threshold: f64) -> (usize, usize) {
        let within = self.sorted.partition_point(|value| f64::from(*value) <= threshold);
        (within, self.sorted.len() - within)
    }
}

/// All histograms of the frame shown.
pub(crate) fn histograms(
    inspection: &FrameInspection,
    scan: Option<&Arc<PreparedScan>>,
    settings: &Settings,
) -> Vec<ThresholdHistogram> {
    let pairs = pair_quantities(inspection, AT_MOST);
    let pruning = &settings.pruning;
    let near = |pair: &PairQuantities| pair.plane_distance_footprints <= pruning.depth_tolerance;
    let facing = |pair: &PairQuantities| {
        pair.normal_angle_degrees.is_nan() || pair.normal_angle_degrees <= pruning.normal_tolerance
    };
    let passes = |pair: &PairQuantities| matches!(pair.outcome, Outcome::Same(_));
    let of_pairs = |wanted: &dyn Fn(&PairQuantities) -> bool, value: &dyn Fn(&PairQuantities) -> f32| {
        pairs.iter().filter(|pair| wanted(pair)).map(|pair| (value(pair), passes(pair))).collect()
    };
    let noise = |of: &dyn Fn(&crate::preprocess::noise::CameraNoise) -> f32| {
        let mut all: Vec<f32> = scan?.cameras.iter().map(|camera| of(&camera.noise)).collect();
        all.sort_unstable_by(f32::total_cmp);
        all.get(all.len() / 2).copied()
    };
    let focal = inspection.samples.cameras.first().map_or(1.0, |camera| camera.intrinsics.fx as f32);
    let depth_noise = noise(&|noise| noise.depth_relative);
    let color_noise = noise(&|noise| noise.color_steps_overall);
    let mut found = vec![
        ThresholdHistogram::new(
            "pruning.depth_tolerance",
            "pairs of samples whose cameras both recorded something there",
            // A footprint is depth over focal length.
            depth_noise.map(|noise| noise * focal),
            of_pairs(&|_| true, &|pair| pair.plane_distance_footprints),
        ),
        ThresholdHistogram::new(
            "pruning.normal_tolerance",
            "pairs of samples at one depth",
            None,
            of_pairs(&near, &|pair| pair.normal_angle_degrees),
        ),
        ThresholdHistogram::new(
            "pruning.color_tolerance",
            "pairs of samples at one depth that face one way",
            color_noise.map(|noise| noise * COLOR_SIGMAS * std::f32::consts::SQRT_2),
            of_pairs(&|pair| near(pair) && facing(pair), &|pair| pair.color_difference_steps),
        ),
    ];
    for histogram in found.iter_mut().flatten() {
        histogram.frame = Some(inspection.frame);
    }
    if let Some(scan) = scan {
        let granted = granted_range_sigmas(scan.frames);
        let [color, depth] = ranges(scan, settings);
        found.push(ThresholdHistogram::new(
            "spans.color_tolerance",
            "pixels, by the range of their color over all frames",
            color_noise.map(|noise| noise * granted),
            color,
        ));
        found.push(ThresholdHistogram::new(
            "spans.depth_tolerance",
            "pixels, by the range of their depth over all frames",
            depth_noise.map(|noise| noise * granted),
            depth,
        ));
    }
    found.into_iter().flatten().collect()
}

/// A range, and whether it is granted.
type Granted = (f32, bool);

/// Ranges over all frames of color and of depth, each with whether it is granted, for pixels spread over all cameras.
fn ranges(scan: &PreparedScan, settings: &Settings) -> [Vec<Granted>; 2] {
    let [mut color, mut depth] = [Vec::new(), Vec::new()];
    let tests = (0..scan.cameras.len()).map(|index| scan.static_test(index, &settings.spans));
    for (camera, test) in scan.cameras.iter().zip(tests) {
        let room = AT_MOST / scan.cameras.len();
        if let Some(ranges) = &camera.ranges {
            let (color_of, depth_of) = of_pixels(ranges, &test, settings, room);
            color.extend(color_of);
            depth.extend(depth_of);
        } else if let Some(shares) = &camera.shares {
            let within = |granted: f32| move |range: f32| (range, range <= granted);
            color.extend(spread(shares.color_bins(), room).map(within(test.granted_color())));
            depth.extend(spread(shares.depth_bins(), room).map(within(test.granted_depth())));
        }
    }
    [color, depth]
}

/// Of the paper's two lengths, the ranges of single pixels are known.
fn of_pixels(
    ranges: &SequenceRanges,
    test: &StaticTest,
    settings: &Settings,
    room: usize,
) -> (Vec<Granted>, Vec<Granted>) {
    let is_static = ranges.static_pixels(&settings.spans, test);
    let stride = is_static.len().div_ceil(room.max(1)).max(1);
    let values = ranges.color_steps().zip(ranges.depth_relative.as_slice());
    let values = values.zip(is_static).step_by(stride).filter(|((_, depth), _)| depth.is_finite());
    values.map(|((color, depth), is_static)| ((color, is_static), (*depth, is_static))).unzip()
}

/// Of the tree of spans, counts between two ends are known: as many values, scaled down to about `room` of them, and spread
/// evenly in the logarithm.
fn spread(bins: impl Iterator<Item = ([f32; 2], u64)>, room: usize) -> impl Iterator<Item = f32> {
    let bins: Vec<_> = bins.collect();
    let total = bins.iter().map(|(_, count)| count).sum::<u64>().max(1);
    let scale = (room as f64 / total as f64).min(1.0);
    bins.into_iter().flat_map(move |([low, high], count)| {
        let values = (count as f64 * scale).round() as u32;
        (0..values).map(move |nth| {
            let share = (f64::from(nth) + 0.5) / f64::from(values);
            if low > 0.0 { low * (high / low).powf(share as f32) } else { high * share as f32 }
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(path: &str) -> ThresholdAxis {
        Settings::fields().find(|field| field.path == path).and_then(ThresholdAxis::of).unwrap()
    }

    #[test]
    fn a_place_on_the_axis_and_its_value_belong_together() {
        for path in ["pruning.depth_tolerance", "pruning.normal_tolerance", "spans.depth_tolerance"] {
            let axis = axis(path);
            for step in 0..=20 {
                let position = step as f32 / 20.0;
                let again = axis.position(axis.value(position));
                assert!((again - position).abs() < 0.01, "{path}: {position} {again}");
            }
        }
    }

    #[test]
    fn counts_are_spread_between_their_ends() {
        let bins = [([0.0, 0.0], 50), ([1.0, 2.0], 100), ([2.0, 4.0], 50)];
        let values: Vec<f32> = spread(bins.into_iter(), 100).collect();
        assert_eq!(values.len(), 100);
        assert_eq!(values.iter().filter(|value| **value == 0.0).count(), 25);
        assert_eq!(values.iter().filter(|value| (1.0..2.0).contains(*value)).count(), 50);
        assert!(values.is_sorted());
    }

    #[test]
    fn every_value_lies_on_one_side_of_the_threshold() {
        let values = (0..100).map(|i| (i as f32, i < 40)).chain([(f32::NAN, true)]).collect();
        let histogram = ThresholdHistogram::new("pruning.normal_tolerance", "tests", None, values).unwrap();
        assert_eq!(histogram.sides(29.5), (30, 70));
        assert_eq!(histogram.bars.iter().flatten().sum::<u32>(), 100);
        assert_eq!(histogram.bars.iter().map(|bar| bar[0]).sum::<u32>(), 40);
    }
}
