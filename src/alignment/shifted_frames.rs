//! A capture whose cameras' frames are moved in time by whole frames.
//!
//! A camera that is moved lacks frames at one end. What does not move there is taken from the nearest frame it has, and what does has
//! no sample: it is not known where it was.

use super::derived_frames::derived_over_time;
use super::reference_view::ReferenceView;
use crate::capture::{Camera, Capture, Frame, INVALID_INVERSE_DEPTH};
use crate::error::Result;

/// Shifted frames that are kept, bytes: few, since most of them are as they were recorded.
const CACHE_BYTES: usize = 64 << 20;

/// The capture with every camera's frames taken `late` frames later than they say, per camera.
pub(crate) fn shifted(capture: &Capture, late: Vec<i64>) -> Capture {
    if late.iter().all(|late| *late == 0) {
        return capture.clone();
    }
    let cameras = capture.cameras.clone();
    let frames = capture.frame_count() as i64;
    derived_over_time(capture, cameras, CACHE_BYTES, move |original, camera, frame| {
        let wanted = frame as i64 - late[camera];
        let nearest = wanted.clamp(0, frames - 1);
        let found = original.frame(camera, nearest as usize)?;
        if nearest == wanted {
            return Ok((*found).clone());
        }
        let inner = (2 * nearest - wanted).clamp(0, frames - 1);
        still_part(original, &original.cameras[camera], (camera, nearest as usize), inner as usize)
    })
}

/// A frame without what is elsewhere in another one.
fn still_part(
    capture: &Capture,
    camera: &Camera,
    (index, frame): (usize, usize),
    other: usize,
) -> Result<Frame> {
    let (frame, other) = (capture.frame(index, frame)?, capture.frame(index, other)?);
    let view = ReferenceView::new(camera.clone(), frame.clone(), Some(&other));
    let mut still = (*frame).clone();
    if let Some(is_still) = &view.is_still {
        for (depth, is_still) in still.inverse_depth.as_mut_slice().iter_mut().zip(is_still.as_slice()) {
            if !is_still {
                *depth = INVALID_INVERSE_DEPTH;
            }
        }
    }
    Ok(still)
}
