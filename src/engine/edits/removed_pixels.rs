//! Edits before pruning: cameras that take no part, and pixels that count as pixels without depth.

use std::ops::Range;

use rayon::prelude::*;

use super::list::{Action, Edit, EditList, edit_place};
use super::region_test::{RegionContext, RegionTest};
use super::seen::{PixelRays, Seen};
use crate::capture::{Camera, Capture, Frame, INVALID_INVERSE_DEPTH, with_changed_frames};
use crate::error::{Error, Result};
use crate::job::Job;

/// The capture without the cameras that a list leaves out of all frames.
///
/// # Errors
/// As [`EditList::check`].
pub fn with_cameras_left(capture: &Capture, edits: &EditList) -> Result<Capture> {
    edits.check(&capture.cameras, &[], capture.value_channels(), "edits")?;
    let left_out = edits.cameras_left_out();
    Ok(if left_out.is_empty() {
        capture.clone()
    } else {
        capture.with_cameras(|_, camera| !left_out.contains(camera.name.as_str()))
    })
}

/// An edit made ready for one camera.
struct PixelEdit {
    action: Action,
    frames: Option<[i64; 2]>,
    test: RegionTest,
}

impl PixelEdit {
    fn new(edit: &Edit, context: RegionContext<'_>) -> Self {
        Self { action: edit.action, frames: edit.frames, test: RegionTest::new(&edit.region, context) }
    }

    fn acts_at(&self, frame_number: i64) -> bool {
        self.frames.is_none_or(|[first, last]| (first..=last).contains(&frame_number))
    }
}

/// The edits before pruning, made ready for all cameras of a capture.
struct PixelEdits {
    cameras: Vec<(PixelRays, Vec<PixelEdit>)>,
    frame_numbers: Vec<i64>,
}

impl PixelEdits {
    fn new(capture: &Capture, edits: &EditList) -> Self {
        let of_camera = |camera: &Camera| {
            let context = RegionContext { camera, channels: capture.value_channels(), marked: &[] };
            let edits = edits.before_pruning().map(|edit| PixelEdit::new(edit, context));
            (PixelRays::of(camera), edits.collect())
        };
        Self {
            cameras: capture.cameras.iter().map(of_camera).collect(),
            frame_numbers: capture.frame_numbers.clone(),
        }
    }

    /// Calls `removed` with the index of every pixel with depth that is removed.
    fn for_each_removed(&self, camera: usize, frame: usize, of: &Frame, mut removed: impl FnMut(usize)) {
        let (rays, edits) = &self.cameras[camera];
        let number = self.frame_numbers[frame];
        let acting: Vec<&PixelEdit> = edits.iter().filter(|edit| edit.acts_at(number)).collect();
        if acting.is_empty() {
            return;
        }
        let width = of.inverse_depth.width().max(1);
        for (pixel, &inverse_depth) in of.inverse_depth.as_slice().iter().enumerate() {
            if inverse_depth < 0.0 {
                continue;
            }
            let mut seen: Seen<'_> = rays.seen(pixel % width, pixel / width, inverse_depth);
            seen.color = of.color.as_slice()[pixel];
            seen.values = of.values.of(pixel);
            let mut stays = true;
            for edit in &acting {
                stays = edit.action.leaves(stays, edit.test.contains(&seen));
            }
            if !stays {
                removed(pixel);
            }
        }
    }
}

/// The capture without what a list leaves out and deletes, for what works on recorded pixels alone. `cache_bytes` of the frames are
/// kept.
///
/// # Errors
/// `Unsupported` where an edit acts on what pruning keeps; as [`EditList::check`].
pub fn edited_capture(capture: &Capture, edits: &EditList, cache_bytes: usize) -> Result<Capture> {
    if let Some((at, edit)) = edits.first_after_pruning() {
        let what = "acts on samples that pruning kept, not on recorded pixels; switch it off, or prune first and use the store";
        return Err(Error::unsupported(edit_place("edits", at, edit), what));
    }
    Ok(without_removed_pixels(&with_cameras_left(capture, edits)?, edits, cache_bytes))
}

/// The capture with pixels without depth where a list deletes before pruning. `capture` has no camera that is left out; its poses are
/// those of the regions. `cache_bytes` of the frames are kept.
#[must_use]
pub fn without_removed_pixels(capture: &Capture, edits: &EditList, cache_bytes: usize) -> Capture {
    if !edits.changes_input() {
        return capture.clone();
    }
    let edits = PixelEdits::new(capture, edits);
    with_changed_frames(capture, cache_bytes, move |camera, index, frame| {
        let mut changed = frame.clone();
        edits.for_each_removed(camera, index, frame, |pixel| {
            changed.inverse_depth.as_mut_slice()[pixel] = INVALID_INVERSE_DEPTH;
        });
        changed
    })
}

/// For each camera the number of pixels with depth that [`without_removed_pixels`] takes, over some frames, by their indices.
///
/// # Errors
/// Whatever the capture gives (naming file and frame), and `Cancelled`.
pub fn count_removed_pixels(
    capture: &Capture,
    edits: &EditList,
    frames: Range<usize>,
    job: &Job,
) -> Result<Vec<u64>> {
    if frames.is_empty() || !edits.changes_input() {
        return Ok(vec![0; capture.cameras.len()]);
    }
    let edits = PixelEdits::new(capture, edits);
    job.start("Applying edits", capture.cameras.len() * frames.len());
    let count = |index: usize| {
        job.check()?;
        let (camera, frame) = (index / frames.len(), frames.start + index % frames.len());
        let mut count = 0_u64;
        edits.for_each_removed(camera, frame, &*capture.frame(camera, frame)?, |_| count += 1);
        job.advance(1);
        Ok(count)
    };
    let counts = (0..capture.cameras.len() * frames.len()).into_par_iter().map(count);
    let removed: Vec<u64> = counts.collect::<Result<_>>()?;
    Ok(removed.chunks(frames.len()).map(|of_camera| of_camera.iter().sum()).collect())
}
