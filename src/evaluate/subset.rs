//! Part of a capture, where the whole would take too long: fewer frames.

use std::sync::Arc;

use super::truth::Truth;
use crate::capture::{Capture, CaptureParts, Frame, FrameSource};
use crate::error::{Error, Result};

/// A capture's frames, changed or chosen; decoded ones stay in the capture's own cache.
struct Chosen {
    capture: Capture,
    /// Index of each frame in the capture.
    frames: Vec<usize>,
}

impl FrameSource for Chosen {
    fn load(&self, camera: usize, frame: usize) -> Result<Frame> {
        Ok((*self.capture.frame(camera, self.frames[frame])?).clone())
    }

    fn place(&self, camera: usize, frame: usize) -> String {
        self.capture.place(camera, self.frames[frame])
    }
}

/// Bytes of frames kept in a derived capture: little, the original keeps its own.
pub(super) const DERIVED_CACHE_BYTES: usize = 256 << 20;

/// The parts of a capture derived from another, to be changed before use.
pub(super) fn parts_of(capture: &Capture, source: Arc<dyn FrameSource>) -> CaptureParts {
    CaptureParts {
        name: capture.name.clone(),
        cameras: capture.cameras.clone(),
        frame_numbers: capture.frame_numbers.clone(),
        up_in_world: capture.up_in_world,
        has_normals: capture.has_normals,
        antialiased_color: capture.antialiased_color,
        warnings: capture.warnings.clone(),
        source,
    }
}

/// The capture with `count` of its frames alone, spread evenly, and the truth at those: frames with truth come first, and
/// where there are more of them than `count`, they are thinned as well. All frames where there are no more.
///
/// # Errors
/// `Invalid` for a count of 0.
pub fn frames(capture: &Capture, truth: Truth, count: usize) -> Result<(Capture, Truth)> {
    if count == 0 {
        return Err(Error::invalid("frames", "there must be at least one"));
    }
    let total = capture.frame_count();
    if count >= total {
        return Ok((capture.clone(), truth));
    }
    let mut with_truth: Vec<usize> = match &truth {
        Truth::Views(views) => {
            views.iter().filter_map(|view| capture.frame_index(view.frame_number)).collect()
        }
        Truth::HoldOut => Vec::new(),
    };
    with_truth.sort_unstable();
    with_truth.dedup();
    let mut frames: Vec<usize> = spread(with_truth.len(), count).map(|index| with_truth[index]).collect();
    // What is left of the count goes where the widest gaps are.
    while frames.len() < count {
        let farthest = |frame: &usize| {
            frames.iter().map(|chosen| chosen.abs_diff(*frame)).min().unwrap_or(total - frame)
        };
        let Some(next) = (0..total)
            .filter(|frame| !frames.contains(frame))
            .max_by_key(|frame| (farthest(frame), total - frame))
        else {
            break;
        };
        frames.push(next);
    }
    frames.sort_unstable();
    let frame_numbers: Vec<i64> = frames.iter().map(|&frame| capture.frame_numbers[frame]).collect();
    let truth = match truth {
        Truth::Views(views) => Truth::Views(
            views
                .into_iter()
                .filter(|view| frame_numbers.binary_search(&view.frame_number).is_ok())
                .collect(),
        ),
        Truth::HoldOut => Truth::HoldOut,
    };
    let source = Arc::new(Chosen { capture: capture.clone(), frames });
    let parts = CaptureParts { frame_numbers, ..parts_of(capture, source) };
    Ok((Capture::new(parts, DERIVED_CACHE_BYTES), truth))
}

/// At most `count` of `total` indices, evenly spread, the first among them.
fn spread(total: usize, count: usize) -> impl Iterator<Item = usize> {
    let count = count.min(total);
    (0..count).map(move |step| step * total / count.max(1))
}
