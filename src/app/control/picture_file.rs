//! The picture of the live view as a file: what is on the screen, in the one format that there is.

use std::path::{Path, PathBuf};

use egui::ColorImage;
use image::{ImageFormat, RgbImage};

use crate::error::{Error, Result};
use crate::whole_file;

const ENDING: &str = "png";

/// The path with the ending that a picture has; `None` where it has another one.
pub(crate) fn with_ending(path: PathBuf) -> Option<PathBuf> {
    match path.extension() {
        None => Some(path.with_extension(ENDING)),
        Some(ending) => ending.eq_ignore_ascii_case(ENDING).then_some(path),
    }
}

/// Writes a picture as it is shown. The file takes its name once it is whole.
///
/// # Errors
/// `Io` where the file cannot be written, `Invalid` where a PNG cannot hold the picture.
pub(crate) fn write_picture(path: &Path, picture: &ColorImage) -> Result<()> {
    let [width, height] = picture.size.map(|side| side as u32);
    let bytes = picture.pixels.iter().flat_map(|pixel| [pixel.r(), pixel.g(), pixel.b()]).collect();
    let png = RgbImage::from_raw(width, height, bytes).ok_or_else(|| {
        Error::invalid(path.display(), "the picture has no size; show it once, then try again")
    })?;
    whole_file::write(path, |writer| {
        png.write_to(writer, ImageFormat::Png).map_err(|error| match error {
            image::ImageError::IoError(error) => Error::io(path, error),
            error => Error::invalid(path.display(), error.to_string()),
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_without_an_ending_gets_one_and_other_endings_are_not_taken() {
        let ending = |path: &str| with_ending(path.into());
        assert_eq!(ending("/a/view"), Some("/a/view.png".into()));
        assert_eq!(ending("/a/view.PNG"), Some("/a/view.PNG".into()));
        assert_eq!((ending("/a/view.jpg"), ending("/a/view.2")), (None, None));
    }
}
