//! What the rig got wrong: poses and exposures, measured from what several cameras see, and mended where it pays.
//!
//! ```text
//! frames ─ reference views ─ surface samples ─ overlapping pairs ─▶ poses ─▶ exposure ─▶ corrected capture
//!                                    half of them fit, half judge ┘
//! ```
//!
//! Purpose: a rig that is off by a few pixels, or cameras that expose differently, cost more than any setting brings. Samples of a
//! lattice are carried into the other cameras; poses are changed so that the surfaces and colors found there agree. A correction is
//! kept only where samples that took no part in finding it agree better by more than their standard error; a capture that is right
//! keeps every bit.
//!
//! Of poses only those of cameras relative to each other are known: most cameras stay where they are. Of gains only ratios are
//! known: the mean stays.

mod corrected_frames;
mod exposure;
mod judge;
mod median;
mod normal_equations;
mod overlaps;
mod poses;
mod reference_view;
mod report;
mod residuals;
mod solver;
mod surface_samples;
mod view_alignment;

pub use report::{AlignedCamera, AlignedExposure, AlignedPair, AlignedPose, Alignment};
pub use view_alignment::align_view;

use glam::DMat3;
use rayon::prelude::*;

use crate::capture::Capture;
use crate::error::Result;
use crate::job::Job;
use crate::settings::{AlignSettings, Correction};
use corrected_frames::{FrameCorrection, corrected};
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
}

/// Samples of each camera, about; with many cameras fewer.
const SAMPLES: usize = 2400;
const FEWEST_SAMPLES: usize = 1000;
/// Cameras up to which nothing is spared.
const FEW_CAMERAS: usize = 9;
/// More cameras are taken as they are: the unknowns of all of them are solved for at once.
const MOST_CAMERAS: usize = 400;

/// Measures what is wrong with a capture, and mends what pays.
///
/// # Errors
/// Whatever the capture gives (naming file and frame), and `Cancelled`.
pub fn align(capture: &Capture, settings: &AlignSettings, job: &Job) -> Result<Aligned> {
    let unchanged = Aligned { capture: capture.clone(), alignment: None };
    let is_off = [settings.poses, settings.exposure].iter().all(|part| *part == Correction::Off);
    let cameras = capture.cameras.len();
    if is_off || !(2..=MOST_CAMERAS).contains(&cameras) || capture.frame_count() == 0 {
        return Ok(unchanged);
    }
    job.start("Aligning cameras", 1);
    let mut problem = problem(capture, job)?;
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
    job.advance(1);
    let is_kept = poses.iter().any(|pose| pose.kept) || gains.iter().any(|gain| gain.kept);
    if !is_kept {
        return Ok(unchanged);
    }
    let corrections = (0..cameras).map(|camera| {
        let now = problem.views[camera].camera.world_from_camera.matrix3;
        let then = capture.cameras[camera].world_from_camera.matrix3;
        let gain = gains.get(camera).filter(|gain| gain.kept);
        FrameCorrection {
            gain: gain.map_or([1.0; 3], |gain| gain.log_gain.map(|log_gain| log_gain.exp() as f32)),
            normal_turn: if now == then { DMat3::IDENTITY } else { now * then.transpose() },
        }
    });
    let alignment = Alignment::new((capture, &problem), &poses, &gains, before);
    let cameras = problem.views.iter().map(|view| view.camera.clone()).collect();
    let capture = corrected(capture, cameras, corrections.collect());
    Ok(Aligned { capture, alignment: Some(alignment) })
}

fn problem(capture: &Capture, job: &Job) -> Result<Problem> {
    let views = ReferenceView::all_of(capture, job)?;
    let cameras = views.len();
    let count = (SAMPLES * FEW_CAMERAS / cameras).clamp(FEWEST_SAMPLES, SAMPLES);
    let samples: Vec<_> = views.par_iter().map(|view| surface_samples(view, count)).collect();
    let pairs = overlapping_pairs(&views, &samples);
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
