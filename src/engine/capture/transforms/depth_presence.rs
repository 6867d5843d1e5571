//! Whether a capture has any depth at all, and why it has none.

use rayon::prelude::*;

use super::depth_file;
use super::source::FileSource;
use crate::capture::parts::Capture;
use crate::error::{Error, Result};

/// Refuses a capture without a pixel at a distance. As a rule one picture is decoded, which stays in the cache.
///
/// # Errors
/// `Invalid` with the likeliest cause, or that of the first picture that cannot be read.
pub(super) fn refuse_without_depth(capture: &Capture, source: &FileSource) -> Result<()> {
    let frames = capture.frame_count();
    let pictures = capture.cameras.len() * frames;
    // The first frame of all cameras before the others.
    let place_of = |index: usize| (index % capture.cameras.len(), index / capture.cameras.len());
    let has_depth = |index: usize| -> Result<bool> {
        let (camera, frame) = place_of(index);
        let frame = capture.frame(camera, frame)?;
        Ok(frame.inverse_depth.as_slice().iter().any(|inverse| *inverse > 0.0))
    };
    let first = if pictures == 0 { Ok(true) } else { has_depth(0) };
    if matches!(first, Ok(true))
        || (1..pictures).into_par_iter().any(|index| matches!(has_depth(index), Ok(true)))
    {
        return Ok(());
    }
    first?;
    let entry = source.first_entry().ok_or_else(|| Error::invalid(&capture.name, "it has no picture"))?;
    let camera = &capture.cameras[0];
    let cause = depth_file::why_none(&entry.files, camera, &entry.place).unwrap_or_default();
    let what = format!("not one pixel of the capture has depth{cause}");
    Err(Error::invalid(&entry.place, what))
}
