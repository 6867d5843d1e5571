//! Whether poses and depth are read as they are meant.
//!
//! Purpose: files say little about the direction and axes of their poses, about what their depth measures, and in which unit. Read
//! otherwise than meant, the views of a capture do not agree. This finds the reading under which they do.
//!
//! Source: the outlier test of MPEG's TMIV (see `agreement`); consistency checks of multi-view stereo. What differs: the test is made
//! under every reading (48 signed orders of axes, both directions, the common units and measures), and one is believed only
//! where it fits twice as well as the claimed one. Nothing is ever changed by itself: a finding names the key to write.
//!
//! What it cannot see: half a pixel of the principal point, a few percent of the focal length, weak distortion; units, where cameras
//! only turn; anything with one camera, or with cameras that see nothing in common; what is wrong alike in all of the world.

mod agreement;
mod reading;
mod search;
mod verdict;
mod views;

pub use super::depth_claim::{DepthClaim, DepthMeasure};
pub(crate) use super::pose_convention::MIRROR;
pub use super::pose_convention::{AxisDirection, CameraAxes, PoseConvention, PoseDirection, upright};
pub use reading::Reading;
pub use verdict::{Alternative, Finding, Part, Undecided, Verdict};

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::camera::Camera;
use super::parts::Capture;
use crate::error::Result;
use agreement::Comparison;
use views::View;

/// Pixels that are read at most, of a few views at least.
const MAX_PIXELS: usize = 12 << 20;
const FEW_VIEWS: usize = 4;
const MANY_VIEWS: usize = 24;

/// Checks how a capture's poses and depth are read, by the agreement between its views at one instant, in the middle of the recording.
///
/// # Errors
/// Those of reading the frames that are looked at.
pub fn check(capture: &Capture) -> Result<Finding> {
    let frame = capture.frame_count() / 2;
    let largest = capture.cameras.iter().map(|camera| camera.intrinsics.pixel_count()).max().unwrap_or(1);
    let budget = (MAX_PIXELS / largest.max(1)).clamp(FEW_VIEWS, MANY_VIEWS);
    let pairs = within(&views::pairs(capture.cameras.len()), budget);
    let indices: BTreeSet<usize> = pairs.iter().flat_map(|&(from, to)| [from, to]).collect();
    let indices: Vec<usize> = indices.into_iter().collect();
    let claim = capture.source.depth_claim();
    let views = indices.par_iter().map(|&camera| {
        let picture = capture.frame(camera, frame)?;
        let inverse = picture.inverse_depth.as_slice();
        Ok(View::new(&capture.cameras[camera], |index| inverse[index], &claim))
    });
    let views = views.collect::<Result<Vec<View>>>()?;
    let place = |camera: usize| indices.binary_search(&camera).unwrap_or(0);
    let pairs = pairs.iter().map(|&(from, to)| (place(from), place(to))).collect();
    Ok(check_views(views, pairs, &claim, capture.source.pose_convention()))
}

/// The same of pictures of depth at hand: `inverse_depth` gives 1/z of a camera's pixel, by their indices, 0 or less for none.
pub(crate) fn check_pictures(
    cameras: &[Camera],
    (claim, pose): (DepthClaim, PoseConvention),
    inverse_depth: impl Fn(usize, usize) -> f32 + Sync,
) -> Finding {
    let views = cameras
        .par_iter()
        .enumerate()
        .map(|(index, camera)| View::new(camera, |pixel| inverse_depth(index, pixel), &claim));
    check_views(views.collect(), views::pairs(cameras.len()), &claim, pose)
}

fn check_views(
    views: Vec<View>,
    pairs: Vec<(usize, usize)>,
    claim: &DepthClaim,
    pose: PoseConvention,
) -> Finding {
    /// With fewer points a score is chance.
    const MIN_POINTS: usize = 64;
    let claimed = Reading { pose, measure: claim.measure, unit: claim.unit };
    let points: usize = pairs.iter().map(|&(from, _)| views[from].points.len()).sum();
    let unknown = |why: &str| Finding {
        verdict: Verdict::Unknown { why: why.to_owned() },
        claimed,
        claimed_score: 0.0,
    };
    if pairs.is_empty() {
        return unknown("there is one view only, which agrees with itself however it is read");
    }
    if points < MIN_POINTS {
        return unknown("hardly any pixel has depth");
    }
    let comparison = Comparison { views, pairs, near_clip: claim.near_clip, claimed };
    verdict::decide(&comparison, &search::search(&comparison))
}

/// Pairs of no more than so many views, in their order.
fn within(pairs: &[(usize, usize)], most_views: usize) -> Vec<(usize, usize)> {
    let mut views = BTreeSet::new();
    let fits = |&(from, to): &(usize, usize)| {
        let more = [from, to].iter().filter(|view| !views.contains(*view)).count();
        if views.len() + more > most_views {
            return None;
        }
        views.extend([from, to]);
        Some((from, to))
    };
    pairs.iter().filter_map(fits).collect()
}
