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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::exr::ExrFile;

    #[test]
    fn a_filled_pixel_is_as_opaque_as_in_a_png_and_is_told_from_a_sampled_one() {
        let picture = Picture {
            color: Grid::filled(3, 1, [1.0, 0.0, 0.25]),
            inverse_depth: Grid::from_vec(3, 1, vec![1.0, -1.0, 0.0]),
            image: Grid::from_vec(3, 1, vec![0, NO_IMAGE, NO_IMAGE]),
            fronts: Vec::new(),
            coverage: Vec::new(),
        };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.exr");
        write_exr(&path, &picture).unwrap();
        let file = ExrFile::open(&path, "picture").unwrap();
        let of = |name: &str| {
            let channel = file.channels().iter().position(|channel| channel.name == name).unwrap();
            let mut planes = file.decode(&[channel], file.window(None).unwrap()).unwrap();
            planes.remove(0).into_single()
        };
        assert_eq!((of("A"), of("sampled.V")), (vec![1.0, 0.0, 1.0], vec![1.0, 0.0, 0.0]));
    }
}
