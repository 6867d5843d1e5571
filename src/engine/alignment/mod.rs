//! What the rig got wrong: the color lens, poses, exposures and clocks, measured from what several cameras see, and mended where it pays.
//!
//! ```text
//! frames ─ reference views ─ surface samples ─ overlapping pairs ─▶ color lens ─▶ poses ─▶ exposure ─▶ clock ─▶ corrected capture
//!                                             some of them fit, others judge ┘
//! ```
//!
//! Purpose: a rig that is off by a few pixels, or cameras that expose differently, cost more than any setting brings. Samples of a
//! lattice are carried into the other cameras; poses are changed so that the surfaces and colors found there agree. A correction is
//! kept only where samples that took no part in finding it agree better by more than their standard error; a capture that is right
//! keeps every bit. The color lens comes first, since it is the same for all cameras; depth is then carried into the pixels of color.
//!
//! Hundreds of cameras are aligned in groups of neighbors (`grouped.rs`), so that memory is bounded and time grows with their number.
//!
//! Only poses relative to each other are known: most cameras stay where they are, or all move least together. Only ratios of gains are
//! known: the mean stays.

mod capture_correction;
mod clock;
mod color_lens;
mod color_lens_search;
mod exposure;
mod fewest_moves;
mod grouped;
mod judge;
mod normal_equations;
mod pair_medians;
mod poses;
mod reference_view;
mod regions;
mod registered_frames;
mod rendered;
mod report;
mod residuals;
mod solver;
mod surface_extent;
mod surface_samples;
mod tangent_plane;
mod together;
mod view_alignment;

pub use capture_correction::{CameraCorrection, CameraCorrections, CaptureCorrection};
pub(crate) use normal_equations::eigen;
pub use report::{
    AlignedCamera, AlignedClock, AlignedExposure, AlignedLens, AlignedPair, AlignedPose, Alignment,
};
pub use together::Aligned;
pub use view_alignment::align_view;

use crate::capture::conventions::{self, Alternative, Evidence, Finding, Reading};
use crate::capture::{Camera, Capture, in_perspective};
use crate::error::Result;
use crate::job::Job;
use crate::settings::{AlignSettings, Correction};
use color_lens::ColorLens;
use color_lens_search::{FoundLenses, LEAST_CAMERAS, LensCorrection};
use grouped::{aligned_in_groups, groups};
use judge::is_of_one_device;
use rendered::left;
use report::FoundCorrections;
use solver::Problem;
use together::{Asked, aligned_beside_lenses, problem};

/// Cameras that are aligned all at once, at most. A capture with more is aligned one group after the other.
const MOST_CAMERAS: usize = 400;
/// Pixels of one frame of all cameras that are held in memory, at most. A capture with more is aligned in groups as well.
const MOST_PIXELS: usize = 18 << 20;
/// Cameras of a group, with large pictures and with small ones.
const GROUP: [usize; 2] = [8, 96];

/// Why a capture with an orthographic camera is not aligned.
const LEFT_OUT: &str = "only cameras in perspective are aligned; all cameras are left as they are";

/// Measures what is wrong with a capture, and mends what pays.
///
/// # Errors
/// Whatever the capture gives (naming file and frame), and `Cancelled`.
pub fn align(capture: &Capture, settings: &AlignSettings, job: &Job) -> Result<Aligned> {
    let cameras = capture.cameras.len();
    if *settings == AlignSettings::OFF || cameras < 2 || capture.frame_count() == 0 {
        return Ok(Aligned::unchanged(capture));
    }
    if let Err(error) = in_perspective(&capture.cameras, "alignment", LEFT_OUT) {
        let why = Alignment { refused: vec![error.to_string()], ..Alignment::default() };
        return Ok(Aligned::refused(capture, why));
    }
    job.start("Aligning cameras", 1);
    let word = capture.source.is_rendered();
    let finds_lenses = settings.lens != Correction::Off;
    let looked = (finds_lenses || word.is_none()).then(|| LookedAt::new(capture, job)).transpose()?;
    let is_rendered =
        word.unwrap_or_else(|| looked.as_ref().is_some_and(|looked| looked.problem.is_rendered()));
    let found = match &looked {
        Some(looked) if finds_lenses => color_lens_search::find_color_lenses(&looked.problem, job)?,
        _ => FoundLenses::default(),
    };
    let FoundLenses { kept: mut lenses, refused } = found;
    let refused: Vec<String> = refused.iter().map(|lens| AlignedLens::new(lens).refusal()).collect();
    let answers_lens =
        refused.is_empty() && looked.as_ref().is_some_and(|looked| looked.problem.is_of_sensor());
    let mut measured = Vec::new();
    if is_rendered && settings.lens == Correction::Auto {
        measured.extend(lenses.drain(..).map(|lens| left(&AlignedLens::new(&lens).sentence(), "lens")));
    }
    let seen = CaptureCorrection::of_lenses(&lenses).seen_through_lenses(capture);
    let asked = Asked { settings, is_rendered };
    let is_lens_alone = AlignSettings { lens: Correction::Off, ..settings.clone() } == AlignSettings::OFF;
    let found = if is_lens_alone {
        let looked = looked.filter(|_| !lenses.is_empty());
        looked.map(|looked| looked.through(&lenses, seen, job)).transpose()?
    } else if let Some(most) = most_together(&seen) {
        let looked = looked.map_or_else(|| LookedAt::new(&seen, job), Ok)?;
        let typical_depth = 1.0 / looked.problem.scale.inverse_depth;
        drop(looked);
        let groups = groups(&seen.cameras, typical_depth, most);
        aligned_in_groups(&seen, &groups, typical_depth, &lenses, &asked, job)?
    } else {
        // The problem of the lens search serves for poses too, unless a lens changed the pictures or cameras were left out.
        let known = looked.filter(|looked| lenses.is_empty() && looked.cameras.len() == cameras);
        let problem = match known {
            Some(looked) => looked.problem,
            None => problem(&seen, None, job)?,
        };
        aligned_beside_lenses(&seen, problem, &lenses, &asked, job)?
    };
    let mut found = with_refusals(found, refused, answers_lens, capture)?;
    if !measured.is_empty() {
        found.alignment.get_or_insert_default().measured.splice(0..0, measured);
    }
    job.advance(1);
    Ok(found)
}

/// `found`, or nothing where the capture is misread: cameras then disagree for that reason. `refused` joins the list of what is left as
/// it is. Where alignment `answers_lens`, a reading of lenses that two sensors of one device may have forbids nothing: it asks what the
/// search for color lenses was asked too, and that one judges what it finds.
fn with_refusals(
    found: Option<Aligned>,
    refused: Vec<String>,
    answers_lens: bool,
    capture: &Capture,
) -> Result<Aligned> {
    if found.is_none() && refused.is_empty() {
        return Ok(Aligned::unchanged(capture));
    }
    let reading = conventions::check(capture)?;
    let is_misread = |other: &Alternative| !answers_lens || !is_of_color_lens(other, &reading, capture);
    if reading.alternative().is_some_and(is_misread) {
        let misread = Alignment { misread: Some(reading), ..Alignment::default() };
        return Ok(Aligned::refused(capture, misread));
    }
    let mut found = found.unwrap_or_else(|| Aligned::unchanged(capture));
    if !refused.is_empty() {
        found.alignment.get_or_insert_default().refused.splice(0..0, refused);
    }
    Ok(found)
}

/// Whether pictures ask for nothing but other lenses, all of which two sensors of one device may have beside those claimed.
fn is_of_color_lens(other: &Alternative, finding: &Finding, capture: &Capture) -> bool {
    let Reading { lens, .. } = other.reading;
    let may_be_of_color = |camera: &Camera| {
        let claimed = camera.intrinsics;
        is_of_one_device(&ColorLens::of_depth(lens.of(&claimed)).unknowns(&claimed, 1.0))
    };
    matches!(other.evidence, Evidence::Pictures { .. })
        && other.reading == Reading { lens, ..finding.claimed }
        && capture.cameras.iter().all(may_be_of_color)
}

/// How many cameras of a capture are aligned together at most; `None` where all are.
fn most_together(capture: &Capture) -> Option<usize> {
    let largest = capture.cameras.iter().map(|camera| camera.intrinsics.pixel_count()).max();
    let affordable = MOST_PIXELS / largest.unwrap_or(1).max(1);
    let is_few = capture.cameras.len() <= affordable.clamp(GROUP[0], MOST_CAMERAS);
    (!is_few).then(|| affordable.clamp(GROUP[0], GROUP[1]))
}

/// Cameras among which a shared color lens is looked for, at most: an even choice of them all, so that memory is bounded.
const MOST_LENS_CAMERAS: usize = 24;
/// Pixels of these cameras, at most.
const MOST_LENS_PIXELS: usize = 16 << 20;

/// The cameras among which a color lens is looked for.
struct LookedAt {
    /// Their indices.
    cameras: Vec<usize>,
    problem: Problem,
}

impl LookedAt {
    fn new(capture: &Capture, job: &Job) -> Result<Self> {
        let all = capture.cameras.len();
        let largest = capture.cameras.iter().map(|camera| camera.intrinsics.pixel_count()).max();
        let affordable = MOST_LENS_PIXELS / largest.unwrap_or(1).max(1);
        let count = affordable.clamp(LEAST_CAMERAS, MOST_LENS_CAMERAS).min(all);
        let cameras: Vec<usize> = (0..count).map(|index| index * all / count).collect();
        let problem = problem(&Self::of(capture, &cameras), None, job)?;
        Ok(Self { cameras, problem })
    }

    fn of(capture: &Capture, cameras: &[usize]) -> Capture {
        capture.with_cameras(|index, _| cameras.contains(&index))
    }

    /// The capture with nothing but lenses corrected, through which `seen` is seen.
    fn through(self, lenses: &[LensCorrection], seen: Capture, job: &Job) -> Result<Aligned> {
        let before = self.problem.pair_medians();
        let problem = problem(&Self::of(&seen, &self.cameras), Some(self.problem.pairs), job)?;
        let mut alignment = Alignment::new(&seen, &problem, &FoundCorrections::of_lenses(lenses), before);
        for pair in &mut alignment.pairs {
            pair.source = self.cameras[pair.source];
            pair.target = self.cameras[pair.target];
        }
        let correction = CaptureCorrection::of_lenses(lenses);
        Ok(Aligned { capture: seen, alignment: Some(alignment), correction })
    }
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;

    use super::*;
    use crate::demo::{Demo, DemoSpec};
    use crate::settings::CaptureSettings;
    use color_lens::UNKNOWNS;

    #[test]
    fn a_color_lens_is_kept_where_no_cameras_overlap_once_they_have_it() {
        let demo = Demo::new(&DemoSpec::new("orrery").cameras(2).frames(1).size((48, 36))).unwrap();
        // The second camera claims to look away from what the first one sees.
        let capture = demo.capture(&CaptureSettings::default()).with_changed_cameras(|index, camera| {
            if index == 1 {
                camera.world_from_camera *= DAffine3::from_rotation_y(std::f64::consts::PI);
            }
        });
        let claimed = capture.cameras[0].intrinsics;
        let lens = LensCorrection {
            claimed,
            found: ColorLens::of_depth(claimed).scaled(0.9),
            free: &[0],
            standard_errors: [0.0; UNKNOWNS],
            moved_px: 1.0,
            judgment: judge::Judgment::default(),
        };
        let (settings, job) = (AlignSettings::default(), Job::new());
        let aligned = |lenses: &[LensCorrection]| {
            let seen = CaptureCorrection::of_lenses(lenses).seen_through_lenses(&capture);
            let problem = problem(&seen, None, &job).unwrap();
            assert!(problem.pairs.is_empty());
            let asked = Asked { settings: &settings, is_rendered: false };
            aligned_beside_lenses(&seen, problem, lenses, &asked, &job).unwrap()
        };
        assert!(aligned(&[]).is_none());
        let found = aligned(&[lens]).unwrap();
        assert_eq!(found.alignment.unwrap().lenses.len(), 1);
        for capture in [&found.capture, &found.correction.applied(&capture)] {
            assert_eq!(capture.cameras[0].intrinsics.fx, 0.9 * claimed.fx);
            assert!(capture.frame(0, 0).is_ok());
        }
    }
}
