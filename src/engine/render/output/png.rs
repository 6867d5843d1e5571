//! Writes a picture as an 8-bit sRGB PNG file.

use std::path::Path;

use image::{ImageFormat, Rgba, RgbaImage};

use crate::color::srgb8_from_linear;
use crate::error::{Error, Result};
use crate::render::vantage::Picture;
use crate::whole_file;

/// Writes a picture as 8-bit sRGB with alpha, the share of each pixel that is no hole, or a hole that was filled. The file takes its
/// name when it is complete.
///
/// # Errors
/// `Io` where the file cannot be written, `Invalid` where a PNG cannot hold the picture.
pub fn write_png(path: &Path, picture: &Picture) -> Result<()> {
    whole_file::write(path, |writer| {
        png_of(picture).write_to(writer, ImageFormat::Png).map_err(|error| match error {
            image::ImageError::IoError(error) => Error::io(path, error),
            error => Error::invalid(path.display(), error.to_string()),
        })
    })
}

fn png_of(picture: &Picture) -> RgbaImage {
    let (width, height) = picture.color.size();
    RgbaImage::from_fn(width as u32, height as u32, |x, y| {
        let pixel = (x as usize, y as usize);
        let [r, g, b] = picture.color[pixel].map(srgb8_from_linear);
        Rgba([r, g, b, (255.0 * picture.alpha(pixel) + 0.5) as u8])
    })
}
