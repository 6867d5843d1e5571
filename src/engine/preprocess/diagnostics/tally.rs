//! Counts verdicts while preprocessing runs, and makes the report of them.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::depth_reading::DepthReading;
use super::pair_residuals::{PairHistograms, residuals_of};
use super::pair_table::{keeps_all_pairs, others_kept};
use super::report::{CameraReport, DepthNoise, Report, STATIC_RULE};
use crate::capture::Capture;
use crate::median::median_f32;
use crate::preprocess::layers::RatedSamples;
use crate::preprocess::noise::{DEPTH_CLASSES, NoiseBetween, depth_class, depth_of_class};
use crate::preprocess::normals::{self, NormalErrors};
use crate::preprocess::pruning::{LevelVerdicts, Rule};
use crate::preprocess::temporal::{CameraScan, RangeFacts, TemporalScan};
use crate::samples::{ImageFacts, Span};
use crate::settings::{NormalSource, Settings};

/// Bytes of one input pixel as 8-bit color and 32-bit depth.
const RAW_BYTES_PER_PIXEL: u64 = 3 + 4;

fn range_facts(scan: &TemporalScan, settings: &Settings) -> Vec<RangeFacts> {
    let of_camera = |(index, camera): (usize, &CameraScan)| {
        let test = scan.static_test(index, &settings.spans);
        let counted = camera.ranges.as_ref().map(|ranges| ranges.shares(&test));
        counted.or_else(|| camera.shares.clone()).unwrap_or_default().facts(&test)
    };
    scan.cameras.par_iter().enumerate().map(of_camera).collect()
}

/// Counts verdicts while preprocessing runs.
pub(crate) struct Tally {
    report: Report,
}

impl Tally {
    /// Nothing is counted yet. `normal_errors` are those of each camera under `settings`.
    pub(crate) fn new(
        capture: &Capture,
        scan: &TemporalScan,
        normal_errors: &[Vec<NormalErrors>],
        settings: &Settings,
    ) -> Self {
        let frames = capture.frame_count() as u64;
        let cameras: Vec<CameraReport> = capture
            .cameras
            .iter()
            .zip(scan.cameras.iter().zip(range_facts(scan, settings)).zip(normal_errors))
            .map(|(camera, ((scan, ranges), normal_errors))| CameraReport {
                name: camera.name.clone(),
                pixels: camera.intrinsics.pixel_count() as u64 * frames,
                invalid: scan.invalid,
                color_noise_steps: scan.noise.color_steps_overall,
                depth_noise_relative: scan.noise.depth_relative,
                depth_step_relative: scan.depth_step_relative,
                ranges,
                normal_errors: normal_errors.clone(),
                normals_off_degrees: normals::contradiction(normal_errors)
                    .filter(|_| settings.normals.source != NormalSource::Estimated),
                ..CameraReport::default()
            })
            .collect();
        let samples_in = capture.pixel_count();
        let report = Report {
            witnesses: vec![vec![0; cameras.len()]; cameras.len()].into(),
            cameras,
            samples_in,
            bytes_raw: samples_in * RAW_BYTES_PER_PIXEL,
            foreground_per_frame: vec![0; scan.frames],
            ..Report::default()
        };
        Self { report }
    }

    /// Notes the reading of depth that brings the samples of noisy cameras far closer together.
    pub(crate) fn add_reading(&mut self, better: Option<DepthReading>) {
        self.report.better_reading = better;
    }

    /// Notes how noisy a camera with these samples is beside others.
    pub(crate) fn add_noise_of(
        &mut self,
        camera: usize,
        noise: Option<&NoiseBetween>,
        samples: &RatedSamples,
    ) {
        let Some(noise) = noise else { return };
        let mut is_met = [false; DEPTH_CLASSES];
        for facet in samples.geometry.iter().filter(|facet| facet.inverse_depth > 0.0) {
            is_met[depth_class(facet.inverse_depth)] = true;
        }
        let met = (0..DEPTH_CLASSES).rev().filter(|class| is_met[*class]);
        let of_class =
            |class| DepthNoise { depth: depth_of_class(class), relative: noise.depth_relative[class] };
        let report = &mut self.report.cameras[camera];
        report.depth_noise_between = met.map(of_class).collect();
        let mut steps = noise.color_steps;
        report.color_noise_between_steps = median_f32(&mut steps).unwrap_or_default();
    }

    /// Counts the verdicts on the samples of one camera over one span, which is that of all frames if it `is_root`.
    pub(crate) fn add(&mut self, span: Span, is_root: bool, camera: usize, decided: &LevelVerdicts) {
        let kept = self.count(camera, decided);
        let samples = decided.pixels.len() as u64;
        if span.len() > 1 {
            *self.report.pruned.entry(STATIC_RULE.to_owned()).or_default() +=
                samples * (span.len() as u64 - 1);
        }
        let counts = &mut self.report.cameras[camera];
        if is_root {
            counts.background_pixels += samples;
            counts.background_kept += kept;
            return;
        }
        counts.foreground_pixels += samples;
        counts.foreground_kept += kept;
        for at_frame in &mut self.report.foreground_per_frame[span.start as usize..span.end as usize] {
            *at_frame += kept;
        }
    }

    /// Samples kept.
    fn count(&mut self, camera: usize, decided: &LevelVerdicts) -> u64 {
        let mut by_rule = [0_u64; Rule::ALL.len()];
        for verdict in &decided.verdicts {
            by_rule[verdict.rule as usize] += 1;
            if !verdict.is_kept()
                && let Some(count) = self.report.witnesses.get_mut(camera, verdict.witness_camera as usize)
            {
                *count += 1;
            }
        }
        let [yielded, dropped] = [Rule::MixedYields, Rule::MixedDropped].map(|rule| by_rule[rule as usize]);
        let mixed = [
            ("found", decided.mixed),
            ("yielded", yielded),
            ("dropped", dropped),
            ("outranked", decided.mixed.saturating_sub(yielded + dropped + decided.mixed_kept)),
            ("kept", decided.mixed_kept),
        ];
        for (name, count) in mixed {
            *self.report.mixed_pixels.entry(name.to_owned()).or_default() += count;
        }
        let mut kept = 0;
        for (rule, count) in Rule::ALL.into_iter().zip(by_rule) {
            if rule.keeps() {
                kept += count;
            } else if count > 0 {
                *self.report.pruned.entry(rule.name().to_owned()).or_default() += count;
            }
        }
        kept
    }

    /// The counts: a report without facts about the images.
    pub(crate) fn into_report(self) -> Report {
        self.report
    }
}

/// Counts and residuals of a run of frames. All are whole numbers that add up, or the same for all runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct RunCounts {
    /// Without what the images say, and without residuals.
    pub(crate) report: Report,
    pub(crate) readings: PairHistograms,
}

impl RunCounts {
    /// Adds the counts of another run of the same capture.
    pub(crate) fn add(&mut self, other: &Self) {
        let (all, more) = (&mut self.report, &other.report);
        add_each(&mut all.foreground_per_frame, &more.foreground_per_frame);
        add_named(&mut all.pruned, &more.pruned);
        add_named(&mut all.mixed_pixels, &more.mixed_pixels);
        for (loser, winner, more) in more.witnesses.iter() {
            if let Some(all) = all.witnesses.get_mut(loser, winner) {
                *all += more;
            }
        }
        for (all, more) in all.cameras.iter_mut().zip(&more.cameras) {
            all.background_pixels += more.background_pixels;
            all.background_kept += more.background_kept;
            all.foreground_pixels += more.foreground_pixels;
            all.foreground_kept += more.foreground_kept;
        }
        for (all, more) in self.readings.iter_mut().zip(&other.readings) {
            if let Some(more) = more {
                let all = all.get_or_insert_default();
                all.iter_mut().zip(more.iter()).for_each(|(all, more)| all.add(more));
            }
        }
    }

    /// The report of all runs of this many cameras, given the images that are kept.
    pub(crate) fn finish<'a>(self, cameras: usize, images: impl Iterator<Item = &'a ImageFacts>) -> Report {
        let Self { mut report, readings } = self;
        report.count_images(images);
        report.residuals = residuals_of(&readings, cameras);
        if !keeps_all_pairs(cameras) {
            report.witnesses_left_out = report.witnesses.keep_largest(others_kept(cameras));
        }
        report
    }
}

fn add_each(all: &mut [u64], more: &[u64]) {
    all.iter_mut().zip(more).for_each(|(all, more)| *all += more);
}

fn add_named(all: &mut BTreeMap<String, u64>, more: &BTreeMap<String, u64>) {
    for (name, count) in more {
        *all.entry(name.clone()).or_default() += count;
    }
}
