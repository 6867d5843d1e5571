//! Which views of a capture readings are tried on, and at which frame.

use std::collections::BTreeSet;
use std::sync::Arc;

use rayon::prelude::*;

use super::agreement::Comparison;
use super::reading::{LensReading, Reading};
use super::views::ComparedView;
use crate::capture::frame::Frame;
use crate::capture::overlap::pairs_by_number;
use crate::capture::parts::Capture;
use crate::error::Result;

/// Pixels that are read at most, of a few views at least.
const MAX_PIXELS: usize = 12 << 20;
const FEW_VIEWS: usize = 4;
const MANY_VIEWS: usize = 24;

/// The views of a capture that are compared.
pub(super) struct ComparedViews {
    /// The frame, in the middle of the recording.
    pub frame: usize,
    /// Their cameras' indices, ascending.
    pub cameras: Vec<usize>,
    /// Source and target, by their place in `cameras`.
    pub pairs: Vec<(usize, usize)>,
}

impl ComparedViews {
    /// No more of them than can be read in a moment.
    pub(super) fn of(capture: &Capture) -> Self {
        let largest = capture.cameras.iter().map(|camera| camera.intrinsics.pixel_count()).max();
        let budget = (MAX_PIXELS / largest.unwrap_or(1).max(1)).clamp(FEW_VIEWS, MANY_VIEWS);
        let pairs = within(&pairs_by_number(capture.cameras.len()), budget);
        let cameras: BTreeSet<usize> = pairs.iter().flat_map(|&(from, to)| [from, to]).collect();
        let cameras: Vec<usize> = cameras.into_iter().collect();
        let place = |camera: usize| cameras.binary_search(&camera).unwrap_or(0);
        let pairs = pairs.iter().map(|&(from, to)| (place(from), place(to))).collect();
        Self { frame: capture.frame_count() / 2, cameras, pairs }
    }

    /// Their pictures.
    ///
    /// # Errors
    /// Those of reading them.
    pub(super) fn frames(&self, capture: &Capture) -> Result<Vec<Arc<Frame>>> {
        self.cameras.par_iter().map(|&camera| capture.frame(camera, self.frame)).collect()
    }

    /// What readings of them are tried on. `frames` are their pictures.
    pub(super) fn comparison(&self, capture: &Capture, frames: &[Arc<Frame>]) -> Comparison {
        let (claim, pose) = (capture.source.depth_claim(), capture.source.pose_convention());
        let view = |(picture, &camera): (&Arc<Frame>, &usize)| {
            let inverse = picture.inverse_depth.as_slice();
            ComparedView::new(&capture.cameras[camera], |index| inverse[index], &claim)
        };
        let lens = LensReading::default();
        let claimed = Reading { pose, measure: claim.measure, unit: claim.unit, planes: claim.planes, lens };
        let views = frames.iter().zip(&self.cameras).map(view).collect();
        Comparison { views, pairs: self.pairs.clone(), near_clip: claim.near_clip, claimed }
    }
}

/// The first pairs, in their order, that have no more than `most_views` views together.
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
