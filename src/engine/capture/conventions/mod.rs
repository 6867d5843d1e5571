//! Whether poses and depth are read as they are meant.
//!
//! Purpose: files seldom state the direction and axes of their poses, or the measure and unit of their depth. The views of a capture
//! do not agree if it is read otherwise than meant. This finds the reading under which they agree.
//!
//! Source: the outlier test of MPEG's TMIV (see `agreement`); consistency checks of multi-view stereo. What differs: the test is made
//! under every reading (48 signed orders of axes, both directions, the common units and measures), and another one is believed only
//! if it fits twice as well as the claimed one. Where depth cannot tell the unit, and for lenses, pictures are compared (see
//! `picture_agreement`). Nothing is ever changed by itself: a finding names the key to write.
//!
//! What it cannot see: a few percent of the principal point and the focal length, weak distortion; units, where cameras only turn;
//! anything with one camera, or with cameras that see nothing in common; an error that all of the world shares.

mod agreement;
mod buffer_planes;
mod chosen_views;
mod picture_search;
mod pictures;
mod reading;
mod search;
mod verdict;
mod views;

pub use super::depth_claim::{DepthClaim, DepthMeasure, DepthPlanes};
pub use super::pose_convention::{AxisDirection, CameraAxes, MIRROR, PoseConvention, PoseDirection, upright};
pub use pictures::{ReadingPictures, RegisteredViews, pictures};
pub use reading::{LensReading, Reading};
pub use verdict::{Alternative, ConventionVerdict, Evidence, Finding, ReadingPart, Undecided};

use super::camera::any_orthographic;
use super::parts::Capture;
use crate::error::Result;
use agreement::Comparison;
use chosen_views::ComparedViews;

/// Checks how a capture's poses and depth are read, by the agreement between its views at one instant, in the middle of the recording.
///
/// # Errors
/// Those of reading the frames that are looked at.
pub fn check(capture: &Capture) -> Result<Finding> {
    let chosen = ComparedViews::of(capture);
    let frames = chosen.frames(capture)?;
    let comparison = chosen.comparison(capture, &frames);
    if any_orthographic(&capture.cameras) {
        let why = "a camera is orthographic, and readings are compared between cameras in perspective alone";
        let verdict = ConventionVerdict::Unknown { why: why.to_owned() };
        return Ok(Finding { verdict, claimed: comparison.claimed, claimed_score: 0.0 });
    }
    let finding = by_depth(&comparison);
    Ok(picture_search::refined(finding, &comparison, &frames))
}

/// What depth alone says.
fn by_depth(comparison: &Comparison) -> Finding {
    /// With fewer points a score is chance.
    const MIN_POINTS: usize = 64;
    let Comparison { views, pairs, claimed, .. } = comparison;
    let points: usize = pairs.iter().map(|&(from, _)| views[from].points.len()).sum();
    let unknown = |why: &str| Finding {
        verdict: ConventionVerdict::Unknown { why: why.to_owned() },
        claimed: *claimed,
        claimed_score: 0.0,
    };
    if pairs.is_empty() {
        return unknown("there is one view only, which agrees with itself however it is read");
    }
    if points < MIN_POINTS {
        return unknown("hardly any pixel has depth");
    }
    let is_open = buffer_planes::may_be_buffer(comparison) && !search::agrees_as_read(comparison);
    if let Some(found) = is_open.then(|| buffer_planes::between_planes(comparison)).flatten() {
        return verdict::of_planes(comparison, &found);
    }
    verdict::decide(comparison, &search::search(comparison))
}
