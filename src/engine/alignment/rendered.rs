//! What a program rendered: its poses, lenses, exposures and clocks are exact, whatever the pictures seem to show.
//!
//! Purpose: lines of one width in pixels, highlights and lamps that go with the camera make exact pictures differ as wrong exposures
//! and poses would. A source that says that it has no noise is taken at its word. Of others depth decides: a sensor's is rough, and no two
//! of its views agree to a part of a footprint.

use rayon::prelude::*;

use super::poses::PoseCorrection;
use super::solver::Problem;
use super::surface_samples::has_exact_depth;

/// The share of the pairs of cameras that have to agree, so that one wrong pose does not hide that the others are exact.
const AGREEING_PAIRS: f64 = 0.25;
/// A pose that pays and is off by this much is wrong: drawing that goes with the camera moves what exact views show by less, footprints.
const FAR_OFF_FOOTPRINTS: f64 = 2.0;
/// It has to bring surfaces this much nearer to each other, as a share of their distances: a light that goes with the camera changes colors
/// alone.
const FAR_OFF_FALL: f64 = 0.75;
/// How far apart the surfaces of two exact views are at most, by the median, footprints.
const EXACT_FOOTPRINTS: f64 = 0.3;

impl Problem {
    /// Whether depth shows that a program rendered it.
    pub(super) fn is_rendered(&self) -> bool {
        let views = self.views.par_iter().zip(&self.samples);
        if self.pairs.is_empty() || !views.clone().all(|(view, samples)| has_exact_depth(view, samples.len()))
        {
            return false;
        }
        let mut apart: Vec<f64> = self.pair_medians().into_iter().map(|[distance, _]| distance).collect();
        apart.sort_by(f64::total_cmp);
        let agreeing = (apart.len() as f64 * AGREEING_PAIRS) as usize;
        apart[agreeing] < EXACT_FOOTPRINTS
    }

    /// Whether most depth is that of a sensor: rougher than rounding makes it, or full of holes.
    pub(super) fn is_of_sensor(&self) -> bool {
        let views = self.views.par_iter().zip(&self.samples);
        2 * views.filter(|(view, samples)| !has_exact_depth(view, samples.len())).count() > self.views.len()
    }
}

/// The words for what is measured of what a program rendered, and left as it is.
pub(super) fn left(what: &str, setting: &str) -> String {
    format!("{what}; left as it is, as a program rendered it: align.{setting} = on corrects it all the same")
}

/// Takes back the poses of what a program rendered that are not wrong beyond doubt, and gives the numbers of their cameras.
pub(super) fn doubtful_poses(poses: &mut [PoseCorrection]) -> Vec<usize> {
    let mut doubtful = Vec::new();
    let is_doubtful = |pose: &PoseCorrection| {
        let falls = pose.distances.pays() && pose.distances.after < FAR_OFF_FALL * pose.distances.before;
        let is_far_off = pose.footprints > FAR_OFF_FOOTPRINTS && falls;
        pose.kept && !is_far_off && !pose.distances.is_beyond_doubt()
    };
    for (camera, pose) in poses.iter_mut().enumerate().filter(|(_, pose)| is_doubtful(pose)) {
        pose.kept = false;
        doubtful.push(camera);
    }
    doubtful
}
