//! Whether poses and depth are read as they are meant.
//!
//! Purpose: files seldom state the direction and axes of their poses, or the measure and unit of their depth. The views of a capture
//! do not agree if it is read otherwise than meant. This finds the reading under which they agree.
//!
//! Source: the outlier test of MPEG's TMIV (see `agreement`); consistency checks of multi-view stereo. What differs: the test is made
//! under every reading (48 signed orders of axes, both directions, the common units and measures), and another one is believed only
//! if it fits twice as well as the claimed one. Nothing is ever changed by itself: a finding names the key to write.
//!
//! What it cannot see: half a pixel of the principal point, a few percent of the focal length, weak distortion; units, where cameras
//! only turn; anything with one camera, or with cameras that see nothing in common; an error that all of the world shares.

mod agreement;
mod buffer_planes;
mod chosen_views;
mod pictures;
mod reading;
mod search;
mod verdict;
mod views;

pub use super::depth_claim::{DepthClaim, DepthMeasure, DepthPlanes};
pub use super::pose_convention::{AxisDirection, CameraAxes, MIRROR, PoseConvention, PoseDirection, upright};
pub use pictures::{ReadingPictures, RegisteredViews, pictures};
pub use reading::Reading;
pub use verdict::{Alternative, ConventionVerdict, Finding, ReadingPart, Undecided};

use super::parts::Capture;
use crate::error::Result;
use agreement::Comparison;
use chosen_views::ComparedViews;
use views::ComparedView;

/// Checks how a capture's poses and depth are read, by the agreement between its views at one instant, in the middle of the recording.
///
/// # Errors
/// Those of reading the frames that are looked at.
pub fn check(capture: &Capture) -> Result<Finding> {
    let (claim, pose) = (capture.source.depth_claim(), capture.source.pose_convention());
    let chosen = ComparedViews::of(capture);
    let views = chosen.frames(capture)?;
    let views = views.iter().zip(&chosen.cameras).map(|(picture, &camera)| {
        let inverse = picture.inverse_depth.as_slice();
        ComparedView::new(&capture.cameras[camera], |index| inverse[index], &claim)
    });
    Ok(check_views(views.collect(), chosen.pairs, &claim, pose))
}

fn check_views(
    views: Vec<ComparedView>,
    pairs: Vec<(usize, usize)>,
    claim: &DepthClaim,
    pose: PoseConvention,
) -> Finding {
    /// With fewer points a score is chance.
    const MIN_POINTS: usize = 64;
    let claimed = Reading { pose, measure: claim.measure, unit: claim.unit, planes: claim.planes };
    let points: usize = pairs.iter().map(|&(from, _)| views[from].points.len()).sum();
    let unknown = |why: &str| Finding {
        verdict: ConventionVerdict::Unknown { why: why.to_owned() },
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
