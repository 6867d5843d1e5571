//! The points that each view shows, one bit each: a thousand views take at most a hundred megabytes.

use glam::DAffine3;
use rayon::prelude::*;

use super::surface_points::{SeenPoints, SurfacePoint};
use crate::truth::is_surface_at;
use overlook_engine::capture::{Camera, Capture, Frame, PixelSide};
use overlook_engine::error::Result;
use overlook_engine::job::Job;

/// A view shows a point only if its pixels there are at most this many times as wide as those of the view that saw the point. So a view
/// from afar does not replace a view from nearby.
const WIDER: f64 = 2.0;

const BITS: usize = u64::BITS as usize;

/// The points of one [`SeenPoints`] that a view shows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct ShownOf {
    /// Index of the [`SeenPoints`].
    pub(super) seen: usize,
    /// One bit for each point, set if the view shows it.
    pub(super) bits: Vec<u64>,
}

/// The points that one view shows; a [`SeenPoints`] without any of them has no entry.
pub(super) type ShownPoints = Vec<ShownOf>;

/// Indices of the bits that are set in both.
pub(super) fn common_bits(a: &[u64], b: &[u64]) -> impl Iterator<Item = usize> {
    a.iter().zip(b).enumerate().flat_map(|(word, (a, b))| {
        let mut left = a & b;
        std::iter::from_fn(move || {
            let bit = (left != 0).then(|| left.trailing_zeros() as usize)?;
            left &= left - 1;
            Some(word * BITS + bit)
        })
    })
}

/// `count` bits, all set.
pub(super) fn all_bits(count: usize) -> Vec<u64> {
    let mut bits = vec![u64::MAX; count.div_ceil(BITS)];
    if let Some(last) = bits.last_mut().filter(|_| !count.is_multiple_of(BITS)) {
        *last = (1 << (count % BITS)) - 1;
    }
    bits
}

/// The points that each view shows. Each thread holds one picture in memory at a time.
///
/// # Errors
/// Those of loading frames, and `Cancelled`.
pub(super) fn shown_by_each(capture: &Capture, seen: &[SeenPoints], job: &Job) -> Result<Vec<ShownPoints>> {
    let of_view = |view: usize| {
        job.check()?;
        let mut shown = ShownPoints::new();
        let looker = Looker::new(&capture.cameras, view);
        let mut frames: Vec<usize> = seen.iter().map(|seen| seen.frame).collect();
        frames.sort_unstable();
        frames.dedup();
        for frame in frames {
            let picture = capture.frame(view, frame)?;
            let of_frame = seen.iter().enumerate().filter(|(_, seen)| seen.frame == frame);
            shown.extend(of_frame.filter_map(|(at, seen)| looker.shown(&picture, at, seen)));
        }
        job.advance(1);
        Ok(shown)
    };
    (0..capture.cameras.len()).into_par_iter().map(of_view).collect()
}

/// A view that points are projected into.
struct Looker<'a> {
    cameras: &'a [Camera],
    view: usize,
    camera_from_world: DAffine3,
}

impl<'a> Looker<'a> {
    fn new(cameras: &'a [Camera], view: usize) -> Self {
        Self { cameras, view, camera_from_world: cameras[view].camera_from_world() }
    }

    /// The points of `seen`, whose index is `at`, that the view shows; `None` if it shows none.
    fn shown(&self, picture: &Frame, at: usize, seen: &SeenPoints) -> Option<ShownOf> {
        if seen.points.is_empty() {
            return None;
        }
        if seen.view == self.view {
            return Some(ShownOf { seen: at, bits: all_bits(seen.points.len()) });
        }
        if !seen.bounds.may_be_seen(&self.cameras[seen.view], &self.cameras[self.view]) {
            return None;
        }
        let mut bits = vec![0; seen.points.len().div_ceil(BITS)];
        for (nth, point) in seen.points.iter().enumerate() {
            if self.shows(picture, point) {
                bits[nth / BITS] |= 1 << (nth % BITS);
            }
        }
        bits.iter().any(|word| *word != 0).then_some(ShownOf { seen: at, bits })
    }

    /// Whether the picture shows the point: finely enough, and as the nearest surface. Depth is compared as for the classes of error
    /// ([`is_surface_at`]): one of nine pixels must be within 1.5 %, so that noise needs no wider tolerance.
    fn shows(&self, picture: &Frame, point: &SurfacePoint) -> bool {
        let in_camera = self.camera_from_world.transform_point3(point.in_world);
        let lens = &self.cameras[self.view].intrinsics;
        let Some(position) = lens.project(in_camera) else { return false };
        let pixel_width = lens.pixel_width(in_camera.z, PixelSide::Mean);
        pixel_width <= WIDER * point.pixel_width && is_surface_at(lens, picture, position, in_camera.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_come_back_in_their_order_and_none_beyond_the_last() {
        for count in [1, 63, 64, 65, 130] {
            let all = all_bits(count);
            assert_eq!(common_bits(&all, &all).collect::<Vec<_>>(), (0..count).collect::<Vec<_>>());
        }
        assert_eq!(common_bits(&[0b1011, 1], &[0b1110, 1]).collect::<Vec<_>>(), [1, 3, 64]);
    }
}
