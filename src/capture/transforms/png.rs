//! Color and depth in PNG files, as nerfstudio's data sets have them.

use std::path::Path;

use image::{ColorType, DynamicImage, ImageDecoder, ImageFormat, ImageReader};

use crate::capture::camera::{MAX_PIXELS, MAX_SIDE, wrong_size};
use crate::color::linear_from_srgb;
use crate::error::{Error, Result, one_line};

/// Bytes of a pixel of four channels of 16 bits.
const PIXEL_BYTES: u64 = 8;

fn reader(path: &Path) -> Result<ImageReader<std::io::BufReader<std::fs::File>>> {
    let mut reader = ImageReader::open(path).map_err(|error| Error::io(path, error))?;
    reader.set_format(ImageFormat::Png);
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(MAX_SIDE as u32);
    limits.max_image_height = Some(MAX_SIDE as u32);
    // Whole pictures and rows beside them: what a believable picture takes is no bomb.
    limits.max_alloc = Some(2 * PIXEL_BYTES * MAX_PIXELS as u64);
    reader.limits(limits);
    Ok(reader)
}

fn damaged(place: &str, error: &image::ImageError) -> Error {
    let what = one_line(&error.to_string());
    if matches!(error, image::ImageError::Limits(_)) {
        let what = format!("the picture is too large ({what}); at most {MAX_SIDE} pixels a side are read");
        return Error::unsupported(place, what);
    }
    Error::invalid(place, format!("damaged, or not a PNG picture ({what}); save it again"))
}

/// Columns and rows, from the header.
pub(super) fn size(path: &Path, place: &str) -> Result<(usize, usize)> {
    let (width, height) = reader(path)?.into_dimensions().map_err(|error| damaged(place, &error))?;
    Ok((width as usize, height as usize))
}

/// Checks the header of a picture of color.
pub(super) fn check(path: &Path, place: &str, expected: (usize, usize)) -> Result<()> {
    let found = size(path, place)?;
    if found == expected { Ok(()) } else { Err(wrong_size(place, found, expected)) }
}

/// Checks the header of a picture of depth.
pub(super) fn check_depth(path: &Path, place: &str, expected: (usize, usize)) -> Result<()> {
    check(path, place, expected)?;
    let decoder = reader(path)?.into_decoder().map_err(|error| damaged(place, &error))?;
    if decoder.color_type() == ColorType::L16 { Ok(()) } else { Err(not_depth(place)) }
}

fn not_depth(place: &str) -> Error {
    Error::unsupported(place, "depth in PNG must be 16-bit gray; save it so, or as EXR")
}

fn decode(path: &Path, place: &str, expected: (usize, usize)) -> Result<DynamicImage> {
    check(path, place, expected)?;
    reader(path)?.decode().map_err(|error| damaged(place, &error))
}

/// Red, green and blue, and alpha where there is one, row-major.
type ColorAndAlpha = ([Vec<f32>; 3], Option<Vec<f32>>);

/// Linear red, green and blue, and alpha where the file has it. `is_linear` leaves values as they are; otherwise they
/// are sRGB.
pub(super) fn color(
    path: &Path,
    place: &str,
    expected: (usize, usize),
    is_linear: bool,
) -> Result<ColorAndAlpha> {
    let picture = decode(path, place, expected)?;
    let has_alpha = picture.color().has_alpha();
    let rgba = picture.into_rgba16();
    let full = f32::from(u16::MAX);
    let table: Vec<f32> = (0..=u16::MAX)
        .map(|value| {
            let encoded = f32::from(value) / full;
            if is_linear { encoded } else { linear_from_srgb(encoded) }
        })
        .collect();
    let plane = |channel: usize| rgba.pixels().map(|pixel| table[usize::from(pixel.0[channel])]).collect();
    let color = [plane(0), plane(1), plane(2)];
    let alpha = has_alpha.then(|| rgba.pixels().map(|pixel| f32::from(pixel.0[3]) / full).collect());
    Ok((color, alpha))
}

/// Raw depth values, 0 to 65535.
///
/// # Errors
/// As [`decode`], and `Unsupported` for anything but 16-bit gray: 8 bits are a picture of depth, not depth.
pub(super) fn depth(path: &Path, place: &str, expected: (usize, usize)) -> Result<Vec<f32>> {
    match decode(path, place, expected)? {
        DynamicImage::ImageLuma16(gray) => Ok(gray.pixels().map(|pixel| f32::from(pixel.0[0])).collect()),
        _ => Err(not_depth(place)),
    }
}
