//! A capture whose cameras' frames are moved in time by whole frames.
//!
//! A camera that is moved lacks frames at one end. Still pixels are taken there from the nearest frame that it has; moving ones
//! get no sample, as nobody knows where they were.

use std::sync::Arc;

use super::reference_view::still_pixels;
use crate::capture::{Capture, Frame, INVALID_INVERSE_DEPTH, with_frames_made_of};

/// Shifted frames that are kept, bytes: few, since most of them are as they were recorded.
const CACHE_BYTES: usize = 64 << 20;

/// The capture with each camera's frames moved `late` frames later in time, per camera.
pub(crate) fn shifted(capture: &Capture, late: Vec<i64>) -> Capture {
    if late.iter().all(|late| *late == 0) {
        return capture.clone();
    }
    let last = capture.frame_count() as i64 - 1;
    // The wanted frame. Where the camera lacks it: the nearest one, and one as far inside, which shows what moves there.
    let read = move |camera: usize, frame: usize| {
        let wanted = frame as i64 - late[camera];
        let nearest = wanted.clamp(0, last);
        let inner = (2 * nearest - wanted).clamp(0, last);
        if nearest == wanted { vec![nearest as usize] } else { vec![nearest as usize, inner as usize] }
    };
    with_frames_made_of(capture, CACHE_BYTES, read, |_, _, read: &[Arc<Frame>]| match read {
        [nearest, inner] => still_part(nearest, inner),
        _ => Frame::clone(&read[0]),
    })
}

/// A frame without what is elsewhere in another one.
fn still_part(frame: &Frame, other: &Frame) -> Frame {
    let mut still = frame.clone();
    let is_still = still_pixels(frame, other);
    for (depth, is_still) in still.inverse_depth.as_mut_slice().iter_mut().zip(is_still.as_slice()) {
        if !is_still {
            *depth = INVALID_INVERSE_DEPTH;
        }
    }
    still
}
