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
//! Of poses only those of cameras relative to each other are known: most cameras stay where they are. Of gains only ratios are
//! known: the mean stays.

mod capture_correction;
mod clock;
mod color_lens;
mod color_lens_matches;
mod color_lens_search;
mod corrected_frames;
mod derived_frames;
mod exposure;
mod judge;
mod median;
mod normal_equations;
mod overlaps;
mod picture_numbers;
mod poses;
mod reference_view;
mod registered_frames;
mod report;
mod residuals;
mod shifted_frames;
mod solver;
mod surface_samples;
mod view_alignment;
mod view_corrections;

pub use capture_correction::CaptureCorrection;
pub use report::{
    AlignedCamera, AlignedClock, AlignedExposure, AlignedLens, AlignedPair, AlignedPose, Alignment,
};
pub use view_alignment::align_view;
pub use view_corrections::{CameraCorrection, CorrectedViews, Foretelling, Proven, ViewCorrections};

use glam::DMat3;
use rayon::prelude::*;

use crate::capture::Capture;
use crate::error::Result;
use crate::job::Job;
use crate::settings::{AlignSettings, Correction};
use clock::ClockCorrection;
use color_lens_search::{LEAST_CAMERAS, LensCorrection};
use corrected_frames::FrameCorrection;
use median::median;
use overlaps::overlapping_pairs;
use reference_view::ReferenceView;
use residuals::Scale;
use solver::Problem;
use surface_samples::surface_samples;

/// A capture without what was found wrong.
#[derive(Clone, Debug)]
pub struct Aligned {
    /// The capture; the one that was given where nothing is corrected.
    pub capture: Capture,
    /// What was corrected; `None` where nothing is.
    pub alignment: Option<Alignment>,
    /// What makes the one of the other.
    pub correction: CaptureCorrection,
}

/// Samples of each camera, about; with many cameras fewer.
const SAMPLES: usize = 2400;
const FEWEST_SAMPLES: usize = 1000;
/// Cameras up to which nothing is spared.
const FEW_CAMERAS: usize = 9;
/// Poses and exposures of more cameras are taken as they are: the unknowns of all of them are solved for at once.
const MOST_CAMERAS: usize = 400;

/// Measures what is wrong with a capture, and mends what pays.
///
/// # Errors
/// Whatever the capture gives (naming file and frame), and `Cancelled`.
pub fn align(capture: &Capture, settings: &AlignSettings, job: &Job) -> Result<Aligned> {
    let mut correction = CaptureCorrection::default();
    let unchanged = Aligned { capture: capture.clone(), alignment: None, correction: correction.clone() };
    let cameras = capture.cameras.len();
    if *settings == AlignSettings::OFF || cameras < 2 || capture.frame_count() == 0 {
        return Ok(unchanged);
    }
    job.start("Aligning cameras", 1);
    let (lenses, looked) = if settings.lens == Correction::Auto {
        let looked = LookedAt::new(capture, job)?;
        (color_lens_search::find_color_lenses(&looked.problem, job)?, Some(looked))
    } else {
        (Vec::new(), None)
    };
    correction.lenses = lenses.iter().map(|lens| (lens.claimed, lens.found)).collect();
    let registered = correction.seen_through_lenses(capture);
    let capture = &registered;
    let is_lens_alone = AlignSettings { lens: Correction::Off, ..settings.clone() } == AlignSettings::OFF;
    if is_lens_alone || cameras > MOST_CAMERAS {
        job.advance(1);
        let Some(looked) = looked.filter(|_| !lenses.is_empty()) else { return Ok(unchanged) };
        let alignment = looked.alignment(capture, &lenses, job)?;
        return Ok(Aligned { capture: registered, alignment: Some(alignment), correction });
    }
    // What a lens was looked for in is what poses are solved for, where no lens changed it and no camera was left out.
    let known = looked.filter(|looked| lenses.is_empty() && looked.cameras.len() == cameras);
    let mut problem = match known {
        Some(looked) => looked.problem,
        None => problem(capture, None, job)?,
    };
    if problem.pairs.is_empty() {
        return Ok(unchanged);
    }
    let before = problem.pair_medians();
    let poses =
        if settings.poses == Correction::Auto { poses::align_poses(&mut problem, job)? } else { Vec::new() };
    let gains = if settings.exposure == Correction::Auto {
        exposure::align_gains(&problem, &problem.finest_weighing())
    } else {
        Vec::new()
    };
    let clocks = if settings.clock == Correction::Auto {
        clock::align_clocks(&problem, capture, job)?
    } else {
        Vec::new()
    };
    job.advance(1);
    let is_kept = !lenses.is_empty()
        || poses.iter().any(|pose| pose.kept)
        || gains.iter().any(|gain| gain.kept)
        || clocks.iter().any(ClockCorrection::shows);
    if !is_kept {
        return Ok(unchanged);
    }
    let of_camera = |camera: usize| {
        let now = problem.views[camera].camera.world_from_camera.matrix3;
        let then = capture.cameras[camera].world_from_camera.matrix3;
        let gain = gains.get(camera).filter(|gain| gain.kept);
        FrameCorrection {
            gain: gain.map_or([1.0; 3], |gain| gain.log_gain.map(|log_gain| log_gain.exp() as f32)),
            normal_turn: if now == then { DMat3::IDENTITY } else { now * then.transpose() },
        }
    };
    let corrections = (0..cameras).map(of_camera).collect();
    let alignment = Alignment::new((capture, &problem), &lenses, &poses, (&gains, &clocks), before);
    correction.cameras = problem.views.iter().map(|view| view.camera.clone()).collect();
    correction.frames = corrections;
    if clocks.iter().any(|clock| clock.shift != 0) {
        correction.late_frames = clocks.iter().map(|clock| clock.shift).collect();
    }
    let capture = correction.applied_to_seen(capture);
    Ok(Aligned { capture, alignment: Some(alignment), correction })
}

/// Cameras that tell a lens that all share, and their pixels; more are evenly chosen from, so that memory is bounded.
const MOST_LENS_CAMERAS: usize = 24;
const MOST_LENS_PIXELS: usize = 16 << 20;

/// The cameras that a lens is looked for in.
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

    /// What was corrected where nothing but lenses was looked for; `capture` is seen through them.
    fn alignment(self, capture: &Capture, lenses: &[LensCorrection], job: &Job) -> Result<Alignment> {
        let before = self.problem.pair_medians();
        let seen = Self::of(capture, &self.cameras);
        let problem = problem(&seen, Some(self.problem.pairs), job)?;
        let mut alignment = Alignment::new((capture, &problem), lenses, &[], (&[], &[]), before);
        for pair in &mut alignment.pairs {
            pair.source = self.cameras[pair.source];
            pair.target = self.cameras[pair.target];
        }
        Ok(alignment)
    }
}

/// What is solved for. Without `pairs` those that overlap are compared.
fn problem(capture: &Capture, pairs: Option<Vec<[usize; 2]>>, job: &Job) -> Result<Problem> {
    let views = ReferenceView::all_of(capture, job)?;
    let cameras = views.len();
    let count = (SAMPLES * FEW_CAMERAS / cameras).clamp(FEWEST_SAMPLES, SAMPLES);
    let samples: Vec<_> = views.par_iter().map(|view| surface_samples(view, count)).collect();
    let pairs = pairs.unwrap_or_else(|| overlapping_pairs(&views, &samples));
    let mut depths: Vec<f64> = samples.iter().flatten().map(|sample| sample.inverse_depth).collect();
    let mut focals: Vec<f64> = views.iter().map(|view| view.camera.intrinsics.fx).collect();
    let scale = Scale {
        inverse_depth: median(&mut depths).unwrap_or(1.0),
        focal: median(&mut focals).unwrap_or(1.0),
    };
    Ok(Problem {
        log_gains: vec![0.0; cameras],
        moved: vec![[0.0; 6]; cameras],
        is_free: vec![true; cameras],
        color_alone: false,
        views,
        samples,
        pairs,
        scale,
    })
}
