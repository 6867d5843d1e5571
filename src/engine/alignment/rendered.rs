//! What a program rendered: its poses, lenses, exposures and clocks are exact, whatever the pictures seem to show.
//!
//! Purpose: lines of one width in pixels, highlights and lamps that go with the camera make exact pictures differ as wrong exposures
//! and poses would. A source that says that it has no noise is taken at its word. Of others depth decides: a sensor's is rough, and no two
//! of its views agree to a part of a footprint. Nor do two views of things of one size in pixels, which lie elsewhere for each camera; a
//! background of one color tells what draws them.
//!
//! Where depth is exact, surfaces agree exactly under the right pose. A pose that leaves them apart is not the right one, however much
//! nearer it brings them.

use rayon::prelude::*;

use super::poses::PoseCorrection;
use super::reference_view::ReferenceView;
use super::solver::Problem;
use super::surface_samples::has_exact_depth;

/// The share of the pairs of cameras that have to agree, so that one wrong pose does not hide that the others are exact.
const AGREEING_PAIRS: f64 = 0.25;
/// The share of the pairs of one camera that have to agree under another pose, and how exactly: things of one size in pixels stay apart.
const AGREEING_PAIRS_OF_ONE: f64 = 0.75;
const CORRECTED_FOOTPRINTS: f64 = 0.1;
/// A pose that is off by less shows in no picture, and things of one size in pixels are taken for as much, footprints.
const LEAST_OFF_FOOTPRINTS: f64 = 0.5;
/// A pose that pays and is off by this much is wrong: drawing that goes with the camera moves what exact views show by less, footprints.
const FAR_OFF_FOOTPRINTS: f64 = 2.0;
/// It has to bring surfaces this much nearer to each other, as a share of their distances: a light that goes with the camera changes colors
/// alone.
const FAR_OFF_FALL: f64 = 0.75;
/// How far apart the surfaces of two exact views are at most, by the median, footprints.
const EXACT_FOOTPRINTS: f64 = 0.3;
/// Pixels without depth that tell what the background is, as a share of a view.
const LEAST_BACKGROUND: f64 = 0.01;

impl Problem {
    /// Whether pictures show that a program rendered it.
    pub(super) fn is_rendered(&self) -> bool {
        if self.pairs.is_empty() {
            return false;
        }
        let backgrounds: Vec<bool> = self.views.par_iter().filter_map(has_drawn_background).collect();
        let is_drawn = !backgrounds.is_empty() && !backgrounds.contains(&false);
        let is_exact = |(view, samples): (&ReferenceView, &Vec<_>)| has_exact_depth(view, samples.len());
        is_drawn
            || self.views.par_iter().zip(&self.samples).all(is_exact)
                && agree(self.pair_medians(), AGREEING_PAIRS, EXACT_FOOTPRINTS)
    }

    /// Whether most depth is that of a sensor: rougher than rounding makes it, or full of holes.
    pub(super) fn is_of_sensor(&self) -> bool {
        let views = self.views.par_iter().zip(&self.samples);
        2 * views.filter(|(view, samples)| !has_exact_depth(view, samples.len())).count() > self.views.len()
    }
}

/// Whether this share of the pairs agree within so many footprints, by what [`Problem::pair_medians`] gives of them.
fn agree(medians: impl IntoIterator<Item = [f64; 2]>, share: f64, footprints: f64) -> bool {
    let mut distances: Vec<f64> = medians.into_iter().map(|[distance, _]| distance).collect();
    distances.sort_by(f64::total_cmp);
    let agreeing = (distances.len() as f64 * share) as usize;
    distances.get(agreeing).is_some_and(|distance| *distance < footprints)
}

/// Whether most pixels without a surface have exactly one color, as in no photograph, beside depth in full floating point numbers, as of no
/// sensor; `None` where too few have none. Black without depth is what masks leave of photographs: it tells nothing. Black that is infinitely
/// far does.
fn has_drawn_background(view: &ReferenceView) -> Option<bool> {
    let pixels = view.frame.color.as_slice().iter().zip(view.frame.inverse_depth.as_slice());
    let background = pixels.filter(|(_, inverse_depth)| **inverse_depth <= 0.0);
    // What more than half of them are is left where each of another color takes one away.
    let (mut most, mut left, mut all, mut far) = (None, 0, 0, 0);
    for (color, inverse_depth) in background.clone() {
        if left == 0 {
            most = Some(color);
        }
        left = if most == Some(color) { left + 1 } else { left - 1 };
        all += 1;
        far += usize::from(*inverse_depth == 0.0);
    }
    let of_one_color = background.filter(|(color, _)| Some(*color) == most).count();
    let is_black = most.is_some_and(|color| color.iter().all(|channel| channel.to_f32() == 0.0));
    let is_drawn = 2 * of_one_color > all && (far == all || !is_black);
    let is_enough = all as f64 >= LEAST_BACKGROUND * view.frame.color.as_slice().len() as f64;
    is_enough.then_some(is_drawn && view.frame.depth_step_relative == 0.0)
}

/// The words for what is measured of what a program rendered, and left as it is.
pub(super) fn left(what: &str, setting: &str) -> String {
    format!("{what}; left as it is, as a program rendered it: align.{setting} = on corrects it all the same")
}

/// Takes back the poses of what a program rendered that are not wrong beyond doubt, and gives the numbers of their cameras. The problem has
/// the poses that were found.
pub(super) fn doubtful_poses(problem: &Problem, poses: &mut [PoseCorrection]) -> Vec<usize> {
    if !poses.iter().any(|pose| pose.kept) {
        return Vec::new();
    }
    let medians = problem.pair_medians();
    let agrees = |camera: usize| {
        let of_camera = problem.pairs.iter().zip(&medians).filter(|(pair, _)| pair.contains(&camera));
        agree(of_camera.map(|(_, medians)| *medians), AGREEING_PAIRS_OF_ONE, CORRECTED_FOOTPRINTS)
    };
    let is_doubtful = |camera: usize, pose: &PoseCorrection| {
        let falls = pose.distances.pays() && pose.distances.after < FAR_OFF_FALL * pose.distances.before;
        let is_far_off = pose.footprints > FAR_OFF_FOOTPRINTS && falls;
        let is_sure = is_far_off || pose.distances.is_beyond_doubt();
        pose.kept && !(is_sure && pose.footprints > LEAST_OFF_FOOTPRINTS && agrees(camera))
    };
    let doubtful = poses.iter().enumerate().filter(|(camera, pose)| is_doubtful(*camera, pose));
    let doubtful: Vec<usize> = doubtful.map(|(camera, _)| camera).collect();
    for camera in &doubtful {
        poses[*camera].kept = false;
    }
    doubtful
}
