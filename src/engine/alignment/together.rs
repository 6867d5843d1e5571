//! Cameras that are aligned together: poses, exposures and clocks, one after the other, of all of them at once.

use glam::DMat3;
use rayon::prelude::*;

use super::capture_correction::{CaptureCorrection, FrameCorrection};
use super::clock::{self, ClockCorrection};
use super::color_lens_search::LensCorrection;
use super::exposure::{self, GainCorrection, kept_gain};
use super::poses::{self, PoseCorrection};
use super::reference_view::ReferenceView;
use super::regions::set_regions;
use super::rendered::{doubtful_poses, left};
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

    /// The capture as it claims to be, and what was found of it all the same; `None` where that is nothing.
    pub(super) fn left(capture: &Capture, refused: Vec<String>, measured: Vec<String>) -> Option<Self> {
        let is_any = !refused.is_empty() || !measured.is_empty();
        is_any.then(|| Self::refused(capture, Alignment { refused, measured, ..Alignment::default() }))
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

/// What is asked of alignment.
pub(super) struct Asked<'a> {
    pub(super) settings: &'a AlignSettings,
    /// Whether a program rendered the capture, so that it is measured and left as it is.
    pub(super) is_rendered: bool,
}

impl Asked<'_> {
    /// Whether what is found under a setting is left as it is.
    fn is_left(&self, correction: Correction) -> bool {
        self.is_rendered && correction == Correction::Auto
    }
}

/// What was found of all cameras.
struct FoundOfCameras {
    poses: Vec<PoseCorrection>,
    gains: Vec<GainCorrection>,
    clocks: Vec<ClockCorrection>,
    /// What is left as it is, a sentence each.
    measured: Vec<String>,
}

impl FoundOfCameras {
    fn new(problem: &mut Problem, seen: &Capture, asked: &Asked<'_>, job: &Job) -> Result<Self> {
        let settings = asked.settings;
        let mut measured = Vec::new();
        let name = |camera: usize| &seen.cameras[camera].name;
        let mut poses = Vec::new();
        if settings.poses != Correction::Off {
            poses = poses::align_poses(problem, job)?;
        }
        if asked.is_left(settings.poses) {
            let doubtful = doubtful_poses(problem, &mut poses);
            let claimed: Vec<_> = seen.cameras.iter().map(|camera| camera.world_from_camera).collect();
            problem.put_back(&claimed, |camera| doubtful.contains(&camera));
            measured.extend(doubtful.iter().map(|camera| {
                let off = poses[*camera].footprints;
                left(&format!("{}: its pose would be {off:.2} footprints off", name(*camera)), "poses")
            }));
        }
        let mut gains = Vec::new();
        if settings.exposure != Correction::Off {
            gains = exposure::align_gains(problem, &problem.finest_weighing());
        }
        for (camera, gain) in gains.iter_mut().enumerate().filter(|(_, gain)| gain.kept) {
            if asked.is_left(settings.exposure) {
                gain.kept = false;
                let [r, g, b] = gain.log_gain.map(|gain| gain / std::f64::consts::LN_2);
                let what = format!("{}: red {r:+.2}, green {g:+.2}, blue {b:+.2} stops", name(camera));
                measured.push(left(&what, "exposure"));
            }
        }
        let mut clocks = Vec::new();
        if settings.clock != Correction::Off {
            clocks = clock::align_clocks(problem, seen, job)?;
        }
        for (camera, clock) in clocks.iter_mut().enumerate().filter(|(_, clock)| clock.shows()) {
            if asked.is_left(settings.clock) {
                let ClockCorrection { delay, standard_error, .. } = std::mem::take(clock);
                let what = format!("{}: {delay:+.2} ± {standard_error:.2} frames late", name(camera));
                measured.push(left(&what, "clock"));
            }
        }
        Ok(Self { poses, gains, clocks, measured })
    }
}

/// Finds poses, exposures and clocks of a capture that is seen through its color lenses; `None` where it has no such lens and nothing
/// else pays.
pub(super) fn aligned_beside_lenses(
    seen: &Capture,
    mut problem: Problem,
    lenses: &[LensCorrection],
    asked: &Asked<'_>,
    job: &Job,
) -> Result<Option<Aligned>> {
    if problem.pairs.is_empty() && lenses.is_empty() {
        return Ok(None);
    }
    let FoundOfCameras { poses, gains, clocks, measured } =
        FoundOfCameras::new(&mut problem, seen, asked, job)?;
    let is_kept = !lenses.is_empty()
        || poses.iter().any(|pose| pose.kept)
        || gains.iter().any(|gain| gain.kept)
        || clocks.iter().any(ClockCorrection::shows);
    if !is_kept {
        return Ok(Aligned::left(seen, poses::refusals(seen, &poses), measured));
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
    let alignment = Alignment { measured, ..Alignment::new(seen, &problem, &found, before) };
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
