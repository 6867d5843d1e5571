//! Counts the quantities that thresholds cut, at the frame shown.

use super::requests::HistogramRequest;
use crate::app::model::{Message, ThresholdHistogram};
use overlook_engine::median::median_f32;
use overlook_engine::preprocess::PreparedScan;
use overlook_engine::preprocess::inspect::{PairQuantities, pair_quantities};
use overlook_engine::preprocess::noise::granted_range_sigmas;
use overlook_engine::preprocess::registration::Outcome;
use overlook_engine::preprocess::temporal::{SequenceRanges, StaticTest};
use overlook_engine::settings::Settings;

/// Largest number of pairs of samples, and of pixels, that are counted.
const AT_MOST: usize = 30_000;

/// Standard deviations of the difference of two colors that the same-surface test grants.
const COLOR_SIGMAS: f32 = 3.0;

/// All histograms of the frame shown.
pub(crate) fn histograms(request: &HistogramRequest) -> Message {
    let HistogramRequest { scene, inspection, scan, settings } = request;
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
    let noise = |of: &dyn Fn(&overlook_engine::preprocess::noise::CameraNoise) -> f32| {
        let mut all: Vec<f32> = scan.as_ref()?.cameras.iter().map(|camera| of(&camera.noise)).collect();
        median_f32(&mut all)
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
    Message::Histograms { scene: *scene, histograms: found.into_iter().flatten().collect() }
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
