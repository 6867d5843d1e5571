//! Counts the quantities that thresholds cut, at the frame shown.

use crate::app::model::window::DockView;
use crate::app::model::{Message, Same, State};
use crate::app::rooms::settings::ThresholdHistogram;
use crate::app::work::worker::Wanted;
use overlook_engine::median::median_f32;
use overlook_engine::preprocess::PreparedScan;
use overlook_engine::preprocess::inspect::{FrameInspection, PairQuantities, pair_quantities};
use overlook_engine::preprocess::noise::{CameraNoise, granted_range_sigmas};
use overlook_engine::preprocess::registration::Outcome;
use overlook_engine::preprocess::temporal::{SequenceRanges, StaticTest};
use overlook_engine::settings::{PruningSettings, Settings};

/// Largest number of pairs of samples, and of pixels, that are counted.
const AT_MOST: usize = 30_000;

/// Standard deviations of the difference of two colors that the same-surface test grants.
const COLOR_SIGMAS: f32 = 3.0;

/// What histograms are made from.
#[derive(Clone, PartialEq)]
pub(crate) struct HistogramRequest {
    pub scene: u64,
    pub inspection: Same<FrameInspection>,
    pub scan: Option<Same<PreparedScan>>,
    pub settings: Settings,
}

impl Wanted for HistogramRequest {
    fn wanted(state: &State) -> Option<Self> {
        let is_seen = state.shows(DockView::Thresholds) && !state.timeline.playing && state.has_capture();
        let inspected = state.doc.inspected.as_ref().filter(|_| is_seen)?;
        Some(Self {
            scene: state.doc.scene.as_ref()?.id,
            inspection: Same(inspected.inspection.clone()),
            scan: state.doc.scan.clone().map(Same),
            settings: inspected.settings.clone(),
        })
    }
}

/// All histograms of the frame shown.
pub(crate) fn histograms(request: &HistogramRequest) -> Message {
    let HistogramRequest { scene, inspection, scan, settings } = request;
    let scan = scan.as_deref().map(|scan| &**scan);
    let median = |of: fn(&CameraNoise) -> f32| {
        let mut all: Vec<f32> = scan?.cameras.iter().map(|camera| of(&camera.noise)).collect();
        median_f32(&mut all)
    };
    // Standard deviations: steps of 255, and shares of the depth; `None` where they were not measured.
    let color = median(|noise| noise.color_steps_overall);
    let depth = median(|noise| noise.depth_relative);
    let mut found: Vec<_> = of_pairs(inspection, &settings.pruning, color).into_iter().flatten().collect();
    for histogram in &mut found {
        histogram.frame = Some(inspection.frame);
    }
    if let Some(scan) = scan {
        found.extend(of_ranges(scan, settings, [color, depth]).into_iter().flatten());
    }
    Message::Histograms { scene: *scene, histograms: found }
}

/// Histograms of what the same-surface test compares.
fn of_pairs(
    inspection: &FrameInspection,
    pruning: &PruningSettings,
    color_noise: Option<f32>,
) -> [Option<ThresholdHistogram>; 3] {
    let pairs = pair_quantities(inspection, AT_MOST);
    let near = |pair: &PairQuantities| pair.depth_tolerance_needed <= pruning.depth_tolerance;
    let facing = |pair: &PairQuantities| {
        pair.normal_angle_degrees.is_nan() || pair.normal_angle_degrees <= pruning.normal_tolerance
    };
    let passes = |pair: &PairQuantities| matches!(pair.outcome, Outcome::Same(_));
    let counted = |wanted: &dyn Fn(&PairQuantities) -> bool, value: &dyn Fn(&PairQuantities) -> f32| {
        pairs.iter().filter(|pair| wanted(pair)).map(|pair| (value(pair), passes(pair))).collect()
    };
    [
        ThresholdHistogram::new(
            "pruning.depth_tolerance",
            "pairs of samples, by the tolerance that they need beside what noise explains",
            None,
            counted(&|_| true, &|pair| pair.depth_tolerance_needed),
        ),
        ThresholdHistogram::new(
            "pruning.normal_tolerance",
            "pairs of samples at one depth",
            None,
            counted(&near, &|pair| pair.normal_angle_degrees),
        ),
        ThresholdHistogram::new(
            "pruning.color_tolerance",
            "pairs of samples at one depth that face one way",
            color_noise.map(|noise| noise * COLOR_SIGMAS * std::f32::consts::SQRT_2),
            counted(&|pair| near(pair) && facing(pair), &|pair| pair.color_difference_steps),
        ),
    ]
}

/// Histograms of the ranges of color and depth over all frames.
fn of_ranges(
    scan: &PreparedScan,
    settings: &Settings,
    noise: [Option<f32>; 2],
) -> [Option<ThresholdHistogram>; 2] {
    let granted = granted_range_sigmas(scan.frames);
    let [color_noise, depth_noise] = noise.map(|noise| Some(noise? * granted));
    let [color, depth] = ranges(scan, settings);
    [
        ThresholdHistogram::new(
            "spans.color_tolerance",
            "pixels, by the range of their color over all frames",
            color_noise,
            color,
        ),
        ThresholdHistogram::new(
            "spans.depth_tolerance",
            "pixels, by the range of their depth over all frames",
            depth_noise,
            depth,
        ),
    ]
}

/// A range, and whether it is within the tolerance.
type Granted = (f32, bool);

/// Ranges of color and of depth over all frames, each with whether it is within the tolerance, for pixels spread over all cameras.
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

/// Ranges of single pixels, which are known for the paper's two lengths.
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

/// Values for the counts of bins, which are known for the tree of spans: about `room` of them in all, spread evenly in the logarithm
/// between the ends of each bin.
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

    #[test]
    fn counts_are_spread_between_their_ends() {
        let bins = [([0.0, 0.0], 50), ([1.0, 2.0], 100), ([2.0, 4.0], 50)];
        let values: Vec<f32> = spread(bins.into_iter(), 100).collect();
        assert_eq!(values.len(), 100);
        assert_eq!(values.iter().filter(|value| **value == 0.0).count(), 25);
        assert_eq!(values.iter().filter(|value| (1.0..2.0).contains(*value)).count(), 50);
        assert!(values.is_sorted());
    }
}
