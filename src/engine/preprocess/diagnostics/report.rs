//! The report of preprocessing: counts, timings, warnings.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::calibration_warnings::{Suspect, calibration_warnings, shared_warning};
use super::depth_reading::DepthReading;
use super::pair_residuals::PairResiduals;
use super::pair_table::PairTable;
use crate::alignment::Alignment;
use crate::capture::conventions::Finding;
use crate::edits::CutByHand;
use crate::error::{Error, Result};
use crate::preprocess::normals::{self, NormalErrors};
use crate::preprocess::pruning::Rule;
use crate::preprocess::temporal::RangeFacts;
use crate::samples::{ImageFacts, Span};

/// One camera's part of a [`Report`].
#[serde_with::skip_serializing_none]
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
    /// How far pixels range over all frames, and where the tolerances are among them.
    pub ranges: RangeFacts,
    /// Estimated against given normals on the first frame; empty where none are given.
    pub normal_errors: Vec<NormalErrors>,
    /// Median angle between given normals and those of the depth on the first frame, degrees; `None` unless the given normals are used
    /// and the angle shows that they are in another space.
    pub normals_off_degrees: Option<f32>,
}

impl CameraReport {
    /// Its noise between cameras, as a sentence; `None` if none was measured.
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

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_no_number(number: &u64) -> bool {
    *number == 0
}

/// What preprocessing counted and measured. Written into the store and printed by `preprocess --json`.
#[serde_with::skip_serializing_none]
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
    /// How many of them are doubtful; left out of JSON where none is.
    #[serde(skip_serializing_if = "is_no_number")]
    pub samples_doubtful: u64,
    /// Samples dropped, per rule; `static` counts the repetitions that a sample of several frames
    /// represents.
    pub pruned: BTreeMap<String, u64>,
    /// `(loser, winner)`: samples of camera `loser` that were dropped for a sample of camera `winner`. With more than 32 cameras, each
    /// has only the winners that replace most of it.
    pub witnesses: PairTable<u64>,
    /// Per camera, samples that were dropped for a camera that `witnesses` leaves out; empty if it leaves out none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub witnesses_left_out: Vec<u64>,
    /// `(a, b)`: how well the samples of camera `a` fit what camera `b` saw; nothing of a camera itself. With more than 32 cameras,
    /// each is compared with some that may see the same, spread over them.
    pub residuals: PairTable<PairResiduals>,
    /// What the rig got wrong and was mended; `None` where nothing was.
    pub alignment: Option<Alignment>,
    /// How poses and depth would fit far better between cameras than as the capture says, where they would.
    pub conventions: Option<Finding>,
    /// The reading of depth that brings samples far closer together, if the number of agreeing samples does not show it.
    pub better_reading: Option<DepthReading>,
    /// Mixed pixels, with a color blended across a silhouette or a depth between its sides, and what became of them. Those `found`
    /// `yielded` to clean ones, were `dropped`, `outranked` by others that are mixed as well or contradicted, or `kept`. None are
    /// found if the settings keep mixed pixels or the first camera wins. Blended ones are found only if the capture's color is filtered,
    /// flying ones only with agreement, and neither if their neighbors live in shorter spans.
    pub mixed_pixels: BTreeMap<String, u64>,
    /// What was cut by hand, in the order in which it was: it is neither kept, nor in `pruned`, nor without depth.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub cut: Vec<CutByHand>,
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
    #[must_use]
    pub fn without_depth(&self) -> u64 {
        self.cameras.iter().fold(0, |sum, camera| sum.saturating_add(camera.invalid))
    }

    /// Counts the images that are kept.
    pub(crate) fn count_images<'a>(&mut self, images: impl Iterator<Item = &'a ImageFacts>) {
        let mut spans = BTreeMap::<_, u64>::new();
        (self.samples_kept, self.samples_doubtful, self.bytes_memory) = (0, 0, 0);
        for image in images {
            *spans.entry((Reverse(image.span.len()), image.span)).or_default() += image.samples as u64;
            self.samples_kept += image.samples as u64;
            self.samples_doubtful += image.doubtful as u64;
            self.bytes_memory += image.bytes as u64;
        }
        self.spans = spans.into_iter().map(|((_, span), samples)| SpanReport { span, samples }).collect();
    }

    /// Notes what was cut by hand, which left these images. A sample that is gone, or holds at fewer frames than before, repeats as
    /// many pixels less.
    pub(crate) fn note_cut<'a>(
        &mut self,
        cut: CutByHand,
        images: impl Iterator<Item = &'a ImageFacts> + Clone,
    ) {
        let kept = self.samples_kept;
        self.count_images(images.clone());
        let repeated = (cut.sample_pixels + self.samples_kept).saturating_sub(kept);
        if let Some(of_rule) = self.pruned.get_mut(STATIC_RULE) {
            *of_rule = of_rule.saturating_sub(repeated);
        }
        let frames = self.foreground_per_frame.len();
        self.foreground_per_frame.fill(0);
        for camera in &mut self.cameras {
            (camera.background_kept, camera.foreground_kept) = (0, 0);
        }
        for image in images {
            let samples = image.samples as u64;
            let Some(camera) = self.cameras.get_mut(image.camera as usize) else { continue };
            if image.span.len() == frames {
                camera.background_kept += samples;
                continue;
            }
            camera.foreground_kept += samples;
            for at_frame in self
                .foreground_per_frame
                .iter_mut()
                .take(image.span.end as usize)
                .skip(image.span.start as usize)
            {
                *at_frame += samples;
            }
        }
        self.cut.push(cut);
    }

    /// Notes how else the capture is to be read, which explains what samples say of depth alone.
    pub(crate) fn note_conventions(&mut self, found: Option<&Finding>) {
        if let Some(found) = found {
            self.conventions = Some(found.clone());
            self.better_reading = None;
        }
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
        // Where all are read otherwise than meant, no camera is to blame by itself.
        if let Some(reading) = self.conventions.as_ref().and_then(Finding::warning) {
            return normals.into_iter().chain([(Suspect::Depth, reading)]).collect();
        }
        if let Some(shared) = shared_warning(&self.residuals, self.noise_footprints()) {
            // Cameras that are noisy beside each other disagree whatever their depth is taken for.
            let reading = self.better_reading.map(|found| format!("; {}", found.sentence()));
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

/// Name under which [`Report::pruned`] counts repetitions in time.
pub const STATIC_RULE: &str = "static";

/// What became of all pixels of all frames of all cameras. Each is counted once: the shares add up to [`PixelAccount::pixels`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct PixelAccount {
    /// All of them.
    pub pixels: u64,
    /// Kept as samples.
    pub kept: u64,
    /// Repetitions over time, which a kept or dropped sample of several frames stands for.
    pub repeated: u64,
    /// Dropped for a kept sample of another camera that shows the same point.
    pub redundant: u64,
    /// Dropped because color or depth is blended across an edge.
    pub mixed: u64,
    /// Dropped because more cameras look past them than confirm them.
    pub contradicted: u64,
    /// Without depth: neither kept nor dropped.
    pub without_depth: u64,
    /// Cut by hand: pixels before pruning, and those that deleted samples stood for.
    pub cut: u64,
}

impl PixelAccount {
    /// What became of the pixels of one frame, by the rule that decided each. Nothing repeats in it, and what is cut by hand before pruning has
    /// no depth there.
    #[must_use]
    pub fn of_frame(rules: impl Iterator<Item = Rule>) -> Self {
        let mut account = Self::default();
        for rule in rules {
            account.pixels += 1;
            let part = match rule {
                Rule::NoSample => &mut account.without_depth,
                Rule::MixedYields | Rule::MixedDropped => &mut account.mixed,
                Rule::Contradicted => &mut account.contradicted,
                rule if rule.keeps() => &mut account.kept,
                _ => &mut account.redundant,
            };
            *part += 1;
        }
        account
    }

    /// What is not kept, whatever the reason.
    #[must_use]
    pub fn not_kept(&self) -> u64 {
        self.pixels.saturating_sub(self.kept)
    }

    /// What a kept sample represents: over time, or of another camera.
    #[must_use]
    pub fn represented(&self) -> u64 {
        self.repeated + self.redundant
    }

    /// The sum of all shares, which is [`PixelAccount::pixels`].
    #[must_use]
    pub fn sum(&self) -> u64 {
        let Self { pixels: _, kept, repeated, redundant, mixed, contradicted, without_depth, cut } = *self;
        kept + repeated + redundant + mixed + contradicted + without_depth + cut
    }
}

impl Report {
    /// What became of every pixel.
    #[must_use]
    pub fn pixel_account(&self) -> PixelAccount {
        let of = |name: &str| self.pruned.get(name).copied().unwrap_or_default();
        let [mixed_yields, mixed_dropped, contradicted] =
            [Rule::MixedYields, Rule::MixedDropped, Rule::Contradicted].map(|rule| of(rule.name()));
        let (repeated, mixed) = (of(STATIC_RULE), mixed_yields + mixed_dropped);
        let dropped: u64 = self.pruned.values().sum();
        PixelAccount {
            pixels: self.samples_in,
            kept: self.samples_kept,
            repeated,
            redundant: dropped.saturating_sub(repeated + mixed + contradicted),
            mixed,
            contradicted,
            without_depth: self.without_depth(),
            cut: self.cut.iter().map(|cut| cut.pixels + cut.sample_pixels).sum(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_with_an_entry_that_this_version_does_not_know_is_read() {
        let report = Report { samples_in: 9, samples_kept: 5, ..Report::default() };
        let json = report.to_json().unwrap().replacen('{', r#"{"rate_disputes":[[0,4],[2,0]],"#, 1);
        assert_eq!(Report::from_json(&json, "report").unwrap(), report);
    }
}
