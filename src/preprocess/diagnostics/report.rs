//! The report of preprocessing: counts, timings, warnings.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::calibration_warnings::{calibration_warnings, shared_warning};
use super::depth_reading::{DepthReading, better_reading};
use super::pair_residuals::PairResiduals;
use super::suspect::Suspect;
use crate::alignment::Alignment;
use crate::capture::conventions::{self, DepthClaim, Finding, PoseConvention};
use crate::capture::{Camera, Capture, INVALID_INVERSE_DEPTH};
use crate::error::{Error, Result};
use crate::preprocess::layers::{CameraLayer, Rate};
use crate::preprocess::noise::{DEPTH_CLASSES, depth_class, depth_of_class};
use crate::preprocess::normals::{self, NormalErrors};
use crate::preprocess::pruning::{Decided, Rule, Verdict};
use crate::preprocess::temporal::{CameraScan, ROOT, RangeFacts, TemporalScan};
use crate::samples::{ImageFacts, Span};
use crate::settings::{NormalSource, Settings};

/// One camera's part of a [`Report`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct CameraReport {
    /// The camera's name.
    pub name: String,
    /// Pixels of all its frames.
    pub pixels: u64,
    /// Pixels without depth, over all frames.
    pub invalid: u64,
    /// Pixels that are static over the whole sequence.
    pub background_pixels: u64,
    /// Samples kept for all frames together.
    pub background_kept: u64,
    /// Samples that hold for fewer than all frames, before pruning.
    pub foreground_pixels: u64,
    /// Those of them that are kept.
    pub foreground_kept: u64,
    /// Measured color noise: standard deviation over time of static pixels, 8-bit sRGB steps, median over the picture.
    pub color_noise_steps: f32,
    /// Measured depth noise: relative standard deviation over time of static pixels.
    pub depth_noise_relative: f32,
    /// Measured depth noise between cameras, relative standard deviation, from the nearest depth to the farthest; empty where it is
    /// too small to matter, or not measured.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub depth_noise_between: Vec<DepthNoise>,
    /// Measured color noise between cameras: standard deviation, 8-bit sRGB steps, median over brightness; 0 where depth is not
    /// noisy between cameras, or it is not measured.
    #[serde(skip_serializing_if = "is_zero")]
    pub color_noise_between_steps: f32,
    /// Quantization step of depth as recorded, relative; 0 where it is exact to `f32`.
    pub depth_step_relative: f32,
    /// How far pixels range over all frames, and where the tolerances lie among them.
    pub ranges: RangeFacts,
    /// Estimated against given normals on the first frame; empty where none are given.
    pub normal_errors: Vec<NormalErrors>,
    /// How far half of the given normals are off those of the depth on the first frame, degrees, where that is so far that they
    /// must be in another space, and they are used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normals_off_degrees: Option<f32>,
}

impl CameraReport {
    /// What was measured of its noise between cameras, as a sentence; `None` where that is nothing.
    #[must_use]
    pub fn noise_between(&self) -> Option<String> {
        let [near, far] = [self.depth_noise_between.first()?, self.depth_noise_between.last()?];
        Some(format!(
            "Beside other cameras depth noise {:.1e} at {:.3} to {:.1e} at {:.3}, relative; color noise {:.1} steps.",
            near.relative, near.depth, far.relative, far.depth, self.color_noise_between_steps
        ))
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_zero(number: &f32) -> bool {
    *number == 0.0
}

/// Noise at one depth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DepthNoise {
    /// Planar z, in the capture's unit.
    pub depth: f32,
    /// Relative standard deviation of depths about as large.
    pub relative: f32,
}

/// Samples kept in one span.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SpanReport {
    /// The frames.
    pub span: Span,
    /// Samples kept, all cameras.
    pub samples: u64,
}

/// What preprocessing counted and measured. Written into the store and printed by `preprocess --json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Report {
    /// Per camera, in the capture's order.
    pub cameras: Vec<CameraReport>,
    /// Per span that holds samples, longest first.
    pub spans: Vec<SpanReport>,
    /// Samples kept that hold at each frame but not at all, all cameras.
    pub foreground_per_frame: Vec<u64>,
    /// Pixels of all frames of all cameras.
    pub samples_in: u64,
    /// Samples kept.
    pub samples_kept: u64,
    /// Samples dropped, per rule; `static` counts the repetitions that a sample of several frames
    /// represents.
    pub pruned: BTreeMap<String, u64>,
    /// `witnesses[loser][winner]`: samples of camera `loser` that were dropped for a sample of camera `winner`.
    pub witnesses: Vec<Vec<u64>>,
    /// `rate_disputes[a][b]`: samples of whose point the paper's rate names camera `a` as the best-sampled and the footprint
    /// (its longest side where that decides, else its area) another camera, `b`.
    pub rate_disputes: Vec<Vec<u64>>,
    /// `residuals[a][b]`: how well the samples of camera `a` fit what camera `b` saw; nothing of a camera itself.
    pub residuals: Vec<Vec<PairResiduals>>,
    /// What the rig got wrong and was mended; `None` where nothing was.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alignment: Option<Alignment>,
    /// How poses and depth would fit far better between cameras than as the capture says, where they would.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub conventions: Option<Finding>,
    /// How depth would fit far better by how far samples are apart, where agreement does not tell.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub better_reading: Option<DepthReading>,
    /// Mixed pixels, whose color is blended across a silhouette or whose depth lies between its sides, and what became of them: of
    /// those `found` some `yielded` to clean ones, were `dropped`, `outranked` by others that are mixed as well or contradicted, or
    /// `kept`. They are not looked for where mixed pixels are kept or the first camera wins, blended ones only where the capture's
    /// color is filtered, flying ones only where other cameras are asked, and those whose neighbors live in shorter spans go unseen.
    pub mixed_pixels: BTreeMap<String, u64>,
    /// All input pixels as 8-bit color and 32-bit depth.
    pub bytes_raw: u64,
    /// The kept samples in memory.
    pub bytes_memory: u64,
    /// Wall-clock seconds of the whole preprocessing.
    pub seconds: f64,
}

impl Report {
    /// This report as a store keeps it: JSON, with [`Report::seconds`] as 0, so that the same input gives the same bytes.
    ///
    /// # Errors
    /// `Invalid` where a number is not finite: JSON has no such numbers, so that the report would not come back as it is.
    pub fn to_json(&self) -> Result<String> {
        let invalid = |what: &str| Error::invalid("report", what);
        let timeless = Self { seconds: 0.0, ..self.clone() };
        let json = serde_json::to_string(&timeless).map_err(|error| invalid(&error.to_string()))?;
        if Self::from_json(&json, "report")? == timeless {
            Ok(json)
        } else {
            Err(invalid("it holds a number that is not finite"))
        }
    }

    /// Reads what [`Report::to_json`] wrote; `place` is named in errors.
    ///
    /// # Errors
    /// `Invalid` where it is no such report.
    pub fn from_json(json: &str, place: &str) -> Result<Self> {
        serde_json::from_str(json).map_err(|error| Error::invalid(place, format!("report: {error}")))
    }

    /// Pixels of all frames of all cameras that have no depth: they are neither kept nor dropped.
    pub(crate) fn without_depth(&self) -> u64 {
        self.cameras.iter().fold(0, |sum, camera| sum.saturating_add(camera.invalid))
    }

    /// Warnings about cameras that do not fit the others, and about normals that do not fit the depth.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        self.suspects().into_iter().map(|(_, sentence)| sentence).collect()
    }

    /// Whether depth is noisy between cameras.
    #[must_use]
    pub fn is_noisy(&self) -> bool {
        self.cameras.iter().any(|camera| !camera.depth_noise_between.is_empty())
    }

    /// The warnings, each with what is suspect.
    #[must_use]
    pub fn suspects(&self) -> Vec<(Suspect, String)> {
        let off = self
            .cameras
            .iter()
            .filter_map(|camera| Some((camera.name.as_str(), camera.normals_off_degrees?)));
        let normals = normals::normal_space_warning(&off.collect::<Vec<_>>());
        let normals = normals.map(|sentence| (Suspect::Normals, sentence));
        if let Some(shared) = shared_warning(&self.residuals, self.noise_footprints()) {
            // Cameras that are noisy beside each other disagree whatever their depth is taken for.
            let found = self.conventions.as_ref().and_then(Finding::warning);
            let found = found.or(self.better_reading.map(DepthReading::sentence));
            let reading = found.map(|found| format!("; {found}"));
            if reading.is_some() || !self.is_noisy() {
                let sentence = shared.sentence() + &reading.unwrap_or_default();
                return normals.into_iter().chain([(Suspect::Depth, sentence)]).collect();
            }
        }
        let warnings = calibration_warnings(&self.residuals).into_iter();
        let sentences = warnings.filter_map(|warning| {
            let suspect = if warning.over_time { Suspect::Clock } else { Suspect::Pose };
            Some((suspect, warning.sentence(&self.cameras.get(warning.camera)?.name)))
        });
        normals.into_iter().chain(sentences).collect()
    }

    /// How far noise and rounding of depth put most samples off each other, about, in footprints: with a lens of some sixty degrees
    /// a footprint is a share of the depth that a picture as wide as high has columns.
    fn noise_footprints(&self) -> f32 {
        /// Two samples of which each is off, and a plane through neighbors that are.
        const MOST: f32 = 4.0;
        let frames = self.foreground_per_frame.len().max(1) as f32;
        let of_camera = |camera: &CameraReport| {
            let relative = camera.depth_noise_relative.max(camera.depth_step_relative);
            MOST * relative * (camera.pixels as f32 / frames).sqrt()
        };
        self.cameras.iter().map(of_camera).fold(0.0, f32::max)
    }
}

/// Bytes of one input pixel as 8-bit color and 32-bit depth.
const RAW_BYTES_PER_PIXEL: u64 = 3 + 4;

/// Name under which [`Report::pruned`] counts repetitions in time.
pub const STATIC_RULE: &str = "static";

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
    frames: u64,
    rate: Rate,
    depth_claim: DepthClaim,
    pose_convention: PoseConvention,
    /// Whether nothing was counted yet: the span of all frames comes first, also where a frame is as long.
    is_first: bool,
}

impl Tally {
    /// Nothing is counted yet. `normal_errors` are those of each camera under `settings`.
    pub(crate) fn new(
        (capture, scan): (&Capture, &TemporalScan),
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
            witnesses: vec![vec![0; cameras.len()]; cameras.len()],
            rate_disputes: vec![vec![0; cameras.len()]; cameras.len()],
            cameras,
            samples_in,
            bytes_raw: samples_in * RAW_BYTES_PER_PIXEL,
            foreground_per_frame: vec![0; scan.frames],
            ..Report::default()
        };
        let rate = Rate::resolve(settings.pruning.rate, &capture.cameras);
        let (depth_claim, pose_convention) = (capture.source.depth_claim(), capture.source.pose_convention());
        Self { report, frames, rate, depth_claim, pose_convention, is_first: true }
    }

    /// Notes how noisy cameras are beside each other, and, where they are, whether depth fits better if it is read otherwise.
    pub(crate) fn add_noise_between(&mut self, cameras: &[Camera], layers: &[CameraLayer]) {
        if layers.iter().any(|layer| layer.noise_between.is_some()) {
            let claim = (self.depth_claim, self.pose_convention);
            let found = conventions::check_pictures(cameras, claim, |camera, pixel| {
                let is_lasting = layers[camera].level[pixel] == ROOT;
                if is_lasting { layers[camera].inverse_depth[pixel] } else { INVALID_INVERSE_DEPTH }
            });
            self.report.conventions = Some(found).filter(|found| found.warning().is_some());
            if self.report.conventions.is_none() {
                self.report.better_reading = better_reading(cameras, layers);
            }
        }
        for (camera, layer) in self.report.cameras.iter_mut().zip(layers) {
            let Some(noise) = &layer.noise_between else { continue };
            let mut is_met = [false; DEPTH_CLASSES];
            for &inverse_depth in layer.inverse_depth.iter().filter(|inverse_depth| **inverse_depth > 0.0) {
                is_met[depth_class(inverse_depth)] = true;
            }
            let met = (0..DEPTH_CLASSES).rev().filter(|class| is_met[*class]);
            let of_class =
                |class| DepthNoise { depth: depth_of_class(class), relative: noise.depth_relative[class] };
            camera.depth_noise_between = met.map(of_class).collect();
            let mut steps = noise.color_steps;
            steps.sort_unstable_by(f32::total_cmp);
            camera.color_noise_between_steps = steps[steps.len() / 2];
        }
    }

    /// Counts what was decided on the samples of one span.
    pub(crate) fn add(&mut self, span: Span, decided: &[Decided]) {
        let mut kept_in_span = 0;
        let is_root = span.len() as u64 == self.frames && self.is_first;
        self.is_first = false;
        for (camera, decided) in decided.iter().enumerate() {
            let kept = self.count(camera, decided);
            let samples = decided.pixels.len() as u64;
            kept_in_span += kept;
            if span.len() > 1 {
                *self.report.pruned.entry(STATIC_RULE.to_owned()).or_default() +=
                    samples * (span.len() as u64 - 1);
            }
            let counts = &mut self.report.cameras[camera];
            let (pixels_of, kept_of) = if is_root {
                (&mut counts.background_pixels, &mut counts.background_kept)
            } else {
                (&mut counts.foreground_pixels, &mut counts.foreground_kept)
            };
            *pixels_of += samples;
            *kept_of += kept;
        }
        if !is_root {
            let at_frames = &mut self.report.foreground_per_frame[span.start as usize..span.end as usize];
            for kept in at_frames {
                *kept += kept_in_span;
            }
        }
    }

    /// Samples kept.
    fn count(&mut self, camera: usize, decided: &Decided) -> u64 {
        let mut by_rule = [0_u64; Rule::ALL.len()];
        for verdict in &decided.verdicts {
            by_rule[verdict.rule as usize] += 1;
            if !verdict.is_kept() && verdict.witness_camera != Verdict::NO_CAMERA {
                self.report.witnesses[camera][verdict.witness_camera as usize] += 1;
            }
        }
        for dispute in &decided.disputes {
            let (used, other) = (dispute.camera as usize, dispute.other_camera as usize);
            let (paper, footprint) = if self.rate == Rate::Paper { (used, other) } else { (other, used) };
            self.report.rate_disputes[paper][footprint] += 1;
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

    pub(crate) fn finish<'a>(mut self, images: impl Iterator<Item = &'a ImageFacts>) -> Report {
        let mut spans = BTreeMap::<_, u64>::new();
        for image in images {
            *spans.entry((std::cmp::Reverse(image.span.len()), image.span)).or_default() +=
                image.samples as u64;
            self.report.samples_kept += image.samples as u64;
            self.report.bytes_memory += image.bytes as u64;
        }
        self.report.spans =
            spans.into_iter().map(|((_, span), samples)| SpanReport { span, samples }).collect();
        self.report
    }
}
