//! Writes a picture as an OpenEXR file.

use std::path::Path;

use crate::capture::exr::write_picture;
use crate::capture::{ValueChannel, Values};
use crate::error::Result;
use crate::grid::Grid;
use crate::render::vantage::{NO_IMAGE, Picture};

/// Writes a picture as linear `R G B A Z`. As in a PNG, `A` is 0 only in holes that were not filled; `sampled.V` is 0 in all holes. The
/// file takes its name when it is complete.
///
/// # Errors
/// `Io` where the file cannot be written, `Invalid` for a picture without pixels.
pub fn write_exr(path: &Path, picture: &Picture) -> Result<()> {
    write_with(path, picture, &[], &Values::default())
}

/// The same with scalar values of its pixels.
pub(super) fn write_with(
    path: &Path,
    picture: &Picture,
    channels: &[ValueChannel],
    values: &Values,
) -> Result<()> {
    let share = |is_there: bool| f32::from(u8::from(is_there));
    let (width, height) = picture.color.size();
    let shown = Grid::from_fn(width, height, |x, y| picture.alpha((x, y)));
    let sampled = picture.image.map(|image| share(*image != NO_IMAGE));
    write_picture(path, &picture.color, [&shown, &sampled], &picture.inverse_depth, (channels, values))
}
