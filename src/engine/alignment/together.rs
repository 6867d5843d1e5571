//! Cameras that are aligned together: poses, exposures and clocks, one after the other, of all of them at once.

use glam::DMat3;
use rayon::prelude::*;

use super::capture_correction::{CaptureCorrection, FrameCorrection};
use super::clock::{self, ClockCorrection};
use super::color_lens_search::LensCorrection;
use super::exposure::{self, kept_gain};
use super::poses;
use super::reference_view::ReferenceView;
use super::regions::set_regions;
use super::report::{Alignment, FoundCorrections};
use super::residuals::ProblemScale;
use super::solver::Problem;
use super::surface_samples::{SurfaceSample, surface_samples};
use crate::capture::Capture;
use crate::capture::overlap::{pairs_by_share, share_seen};
use crate::error::Result;
use crate::job::Job;
use crate::median::median;
use crate::settings::{AlignSettings, Correction};

/// A capture without what was found wrong.
#[derive(Clone, Debug)]
pub struct Aligned {
    /// The corrected capture; the given one if nothing was wrong.
    pub capture: Capture,
    /// What was corrected; `None` where nothing is.
    pub alignment: Option<Alignment>,
    /// The correction that makes it of the given capture.
    pub correction: CaptureCorrection,
}

impl Aligned {
    /// The capture as it claims to be.
    pub(super) fn unchanged(capture: &Capture) -> Self {
        Self { capture: capture.clone(), alignment: None, correction: CaptureCorrection::default() }
    }

    /// The capture as it claims to be, and why.
    pub(super) fn refused(capture: &Capture, why: Alignment) -> Self {
        Self { alignment: Some(why), ..Self::unchanged(capture) }
    }
}

/// Samples of each camera, about; with many cameras fewer.
const SAMPLES: usize = 2400;
const FEWEST_SAMPLES: usize = 1000;
/// Captures of up to this many cameras have all [`SAMPLES`].
const FEW_CAMERAS: usize = 9;

/// Samples of a camera that measure how much another one sees of it, about.
const PROBES: usize = 96;

/// The pairs of source and target that overlap.
fn overlapping_pairs(views: &[ReferenceView], samples: &[Vec<SurfaceSample>]) -> Vec<[usize; 2]> {
    pairs_by_share(views.len(), |source, target| {
        let probes = samples[source].iter().step_by((samples[source].len() / PROBES).max(1));
        let point =
            |probe: &SurfaceSample| views[source].camera.unproject(probe.pixel, 1.0 / probe.inverse_depth);
        let target = &views[target];
        share_seen(probes.map(point), &target.camera, &target.frame.inverse_depth)
    })
}

/// Finds poses, exposures and clocks of a capture that is seen through its color lenses; `None` where it has no such lens and nothing
/// else pays.
pub(super) fn aligned_beside_lenses(
    seen: &Capture,
    mut problem: Problem,
    lenses: &[LensCorrection],
    settings: &AlignSettings,
    job: &Job,
) -> Result<Option<Aligned>> {
    if problem.pairs.is_empty() && lenses.is_empty() {
        return Ok(None);
    }
    let poses =
        if settings.poses == Correction::Auto { poses::align_poses(&mut problem, job)? } else { Vec::new() };
    let gains = if settings.exposure == Correction::Auto {
        exposure::align_gains(&problem, &problem.finest_weighing())
    } else {
        Vec::new()
    };
    let clocks = if settings.clock == Correction::Auto {
        clock::align_clocks(&problem, seen, job)?
    } else {
        Vec::new()
    };
    let is_kept = !lenses.is_empty()
        || poses.iter().any(|pose| pose.kept)
        || gains.iter().any(|gain| gain.kept)
        || clocks.iter().any(ClockCorrection::shows);
    if !is_kept {
        let refused = poses::refusals(seen, &poses);
        return Ok((!refused.is_empty()).then(|| Aligned::refused(seen, Alignment::refused(refused))));
    }
    let before = problem.pair_medians_as_claimed(&seen.cameras);
    let of_camera = |camera: usize| {
        let now = problem.views[camera].camera.world_from_camera.matrix3;
        let then = seen.cameras[camera].world_from_camera.matrix3;
        let log_gain = kept_gain(&gains, camera).map_or([0.0; 3], |gain| gain.log_gain);
        FrameCorrection {
            gain: log_gain.map(|log_gain| log_gain.exp() as f32),
            normal_turn: if now == then { DMat3::IDENTITY } else { now * then.transpose() },
        }
    };
    let found = FoundCorrections { lenses, poses: &poses, gains: &gains, clocks: &clocks };
    let alignment = Alignment::new(seen, &problem, &found, before);
    let is_shifted = clocks.iter().any(|clock| clock.shift != 0);
    let correction = CaptureCorrection {
        cameras: problem.views.iter().map(|view| view.camera.clone()).collect(),
        frames: (0..seen.cameras.len()).map(of_camera).collect(),
        late_frames: if is_shifted { clocks.iter().map(|clock| clock.shift).collect() } else { Vec::new() },
        ..CaptureCorrection::of_lenses(lenses)
    };
    let capture = correction.applied_to_seen(seen);
    Ok(Some(Aligned { capture, alignment: Some(alignment), correction }))
}

/// The problem to solve for a capture. Overlapping pairs are compared, unless `pairs` lists others.
pub(super) fn problem(capture: &Capture, pairs: Option<Vec<[usize; 2]>>, job: &Job) -> Result<Problem> {
    let views = ReferenceView::all_of(capture, job)?;
    let cameras = views.len();
    let count = (SAMPLES * FEW_CAMERAS / cameras).clamp(FEWEST_SAMPLES, SAMPLES);
    let mut samples: Vec<_> = views.par_iter().map(|view| surface_samples(view, count)).collect();
    let pairs = pairs.unwrap_or_else(|| overlapping_pairs(&views, &samples));
    let mut depths: Vec<f64> = samples.iter().flatten().map(|sample| sample.inverse_depth).collect();
    let mut focals: Vec<f64> = views.iter().map(|view| view.camera.intrinsics.fx).collect();
    let scale = ProblemScale {
        inverse_depth: median(&mut depths).unwrap_or(1.0),
        focal: median(&mut focals).unwrap_or(1.0),
    };
    let regions = set_regions(&views, &mut samples, scale.inverse_depth);
    Ok(Problem {
        log_gains: vec![0.0; cameras],
        moved: vec![[0.0; 6]; cameras],
        is_free: vec![true; cameras],
        regions,
        color_alone: false,
        views,
        samples,
        pairs,
        scale,
    })
}
