//! Pictures in PNG, JPEG and TIFF.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use image::{ColorType, DynamicImage, ImageDecoder, ImageFormat, ImageReader};
use tiff::decoder::Decoder as TiffDecoder;

use super::format::{PictureFormat, format_of};
use crate::capture::camera::{MAX_PIXELS, MAX_SIDE, wrong_size};
use crate::color::linear_from_srgb;
use crate::error::{Error, Result, one_line};

/// Bytes of a pixel of four channels of 16 bits.
const PIXEL_BYTES: u64 = 8;

fn reader(path: &Path, place: &str) -> Result<(ImageReader<BufReader<File>>, &'static str)> {
    let (format, name) = match format_of(path, place)? {
        PictureFormat::Jpeg => (ImageFormat::Jpeg, "JPEG"),
        PictureFormat::Tiff => (ImageFormat::Tiff, "TIFF"),
        PictureFormat::Png => (ImageFormat::Png, "PNG"),
        _ => {
            let what =
                "colors and masks are read from EXR, PNG, JPEG and TIFF; save the picture as one of these";
            return Err(Error::unsupported(place, what));
        }
    };
    let mut reader = ImageReader::open(path).map_err(|error| Error::io(path, error))?;
    reader.set_format(format);
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(MAX_SIDE as u32);
    limits.max_image_height = Some(MAX_SIDE as u32);
    // Whole pictures and rows beside them: what a believable picture takes is no bomb.
    limits.max_alloc = Some(2 * PIXEL_BYTES * MAX_PIXELS as u64);
    reader.limits(limits);
    Ok((reader, name))
}

fn damaged(place: &str, format: &str, error: &image::ImageError) -> Error {
    let what = one_line(&error.to_string());
    if matches!(error, image::ImageError::Limits(_)) {
        let what = format!("the picture is too large ({what}); at most {MAX_SIDE} pixels a side are read");
        return Error::unsupported(place, what);
    }
    Error::invalid(place, format!("damaged, or not a {format} picture ({what}); save it again"))
}

/// Columns and rows, from the header.
pub(crate) fn size(path: &Path, place: &str) -> Result<(usize, usize)> {
    let (reader, format) = reader(path, place)?;
    let (width, height) = reader.into_dimensions().map_err(|error| damaged(place, format, &error))?;
    Ok((width as usize, height as usize))
}

/// Checks the header of a picture of color.
pub(crate) fn check(path: &Path, place: &str, expected: (usize, usize)) -> Result<()> {
    let found = size(path, place)?;
    if found == expected { Ok(()) } else { Err(wrong_size(place, found, expected)) }
}

/// Checks that a picture has 16 bits of gray: `Err(None)` where it has not.
pub(super) fn check_gray16(path: &Path, place: &str) -> Result<(), Option<Error>> {
    let (reader, format) = reader(path, place).map_err(Some)?;
    let decoder = reader.into_decoder().map_err(|error| Some(damaged(place, format, &error)))?;
    if decoder.color_type() == ColorType::L16 { Ok(()) } else { Err(None) }
}

/// Whether a picture has an alpha channel, by its header.
pub(crate) fn has_alpha(path: &Path, place: &str) -> Result<bool> {
    let (reader, format) = reader(path, place)?;
    let decoder = reader.into_decoder().map_err(|error| damaged(place, format, &error))?;
    Ok(decoder.color_type().has_alpha())
}

/// Decodes a picture of any size.
pub(super) fn decode_any(path: &Path, place: &str) -> Result<DynamicImage> {
    let (reader, format) = reader(path, place)?;
    reader.decode().map_err(|error| damaged(place, format, &error))
}

/// Red, green, blue, and alpha if the picture has it, row-major.
pub(crate) type ColorAndAlpha = ([Vec<f32>; 3], Option<Vec<f32>>);

/// Linear red, green and blue, and alpha where the file has it. `is_linear` leaves values as they are; otherwise they
/// are sRGB.
pub(crate) fn color(
    path: &Path,
    place: &str,
    expected: (usize, usize),
    is_linear: bool,
) -> Result<ColorAndAlpha> {
    check(path, place, expected)?;
    let picture = decode_any(path, place)?;
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

/// A gray picture of 8 bits, as masks and confidence are: columns, rows and values row by row.
pub(crate) fn gray(path: &Path, place: &str) -> Result<((usize, usize), Vec<u8>)> {
    let picture = decode_any(path, place)?;
    let gray = match picture {
        // Of whole numbers in 16 bits the low byte counts: confidence is 0, 1 or 2.
        DynamicImage::ImageLuma16(gray) if gray.pixels().all(|pixel| pixel.0[0] < 256) => {
            let size = (gray.width() as usize, gray.height() as usize);
            return Ok((size, gray.pixels().map(|pixel| pixel.0[0] as u8).collect()));
        }
        picture => picture.into_luma8(),
    };
    Ok(((gray.width() as usize, gray.height() as usize), gray.into_raw()))
}

pub(super) fn open_tiff(path: &Path, place: &str) -> Result<TiffDecoder<BufReader<File>>> {
    let file = File::open(path).map_err(|error| Error::io(path, error))?;
    let decoder = TiffDecoder::new(BufReader::new(file)).map_err(|error| damaged_tiff(place, &error))?;
    let mut limits = tiff::decoder::Limits::default();
    limits.decoding_buffer_size = 8 * MAX_PIXELS;
    Ok(decoder.with_limits(limits))
}

pub(super) fn damaged_tiff(place: &str, error: &tiff::TiffError) -> Error {
    let what = one_line(&error.to_string());
    Error::invalid(place, format!("damaged, or not a TIFF picture that can be read ({what}); save it again"))
}
