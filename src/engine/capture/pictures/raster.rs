//! Pictures of color in PNG, JPEG and TIFF.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use image::metadata::Orientation;
use image::{ColorType, DynamicImage, ImageBuffer, ImageDecoder, ImageFormat, ImageReader, Rgba};

use super::color_tags::ColorTag;
use super::format::{PictureFormat, format_of};
use super::tiff_samples::{self, TiffSamples};
use super::turned::{self, PictureRows, rows_by_size, shown_size, turn, turned};
use crate::capture::camera::{MAX_PIXELS, MAX_SIDE};
use crate::color::linear_from_srgb;
use crate::error::{Error, Result, one_line};
use crate::whole_file;

/// Bytes of a pixel of four channels of 16 bits.
const PIXEL_BYTES: u64 = 8;

fn reader(path: &Path, place: &str) -> Result<(ImageReader<BufReader<File>>, &'static str)> {
    let (format, name) = match format_of(path, place)? {
        PictureFormat::Jpeg => (ImageFormat::Jpeg, "JPEG"),
        PictureFormat::Png => (ImageFormat::Png, "PNG"),
        _ => {
            let what =
                "colors and masks are read from EXR, PNG, JPEG and TIFF; save the picture as one of these";
            return Err(Error::unsupported(place, what));
        }
    };
    let mut reader = ImageReader::with_format(BufReader::new(whole_file::open(path)?), format);
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

/// Columns and rows as they are stored, from the header.
pub(crate) fn size(path: &Path, place: &str) -> Result<(usize, usize)> {
    Ok(stored_size(path, place)?.0)
}

/// Checks the header of a picture of color.
pub(crate) fn check(
    path: &Path,
    place: &str,
    expected: (usize, usize),
    rows: Option<PictureRows>,
) -> Result<()> {
    let (stored, tag) = stored_size(path, place)?;
    turn(stored, tag, expected, rows, place).map(drop)
}

/// Checks that a picture has 16 bits, of gray or of channels that may all be gray: `Err(None)` where it has not.
pub(super) fn check_gray16(path: &Path, place: &str) -> Result<(), Option<Error>> {
    let (reader, format) = reader(path, place).map_err(Some)?;
    let decoder = reader.into_decoder().map_err(|error| Some(damaged(place, format, &error)))?;
    let has_sixteen = [ColorType::L16, ColorType::La16, ColorType::Rgb16, ColorType::Rgba16];
    if has_sixteen.contains(&decoder.color_type()) { Ok(()) } else { Err(None) }
}

/// Whether a picture has an alpha channel.
pub(crate) fn has_alpha(path: &Path, place: &str) -> Result<bool> {
    if format_of(path, place)? == PictureFormat::Tiff {
        return Ok(TiffSamples::read(path, place)?.has_alpha());
    }
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

/// How a manifest wants the numbers and the rows of a picture read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct ColorReading {
    /// Whether values are left as they are or are sRGB, whatever the picture says of itself. Where it says nothing either, floats are
    /// linear and whole numbers are sRGB.
    pub(crate) is_linear: Option<bool>,
    /// Which rows of a picture with an orientation tag are meant.
    pub(crate) rows: Option<PictureRows>,
}

/// Linear red, green and blue, and alpha where the file has it.
pub(crate) fn color(
    path: &Path,
    place: &str,
    expected: (usize, usize),
    reading: ColorReading,
) -> Result<ColorAndAlpha> {
    let (stored, tag) = stored_size(path, place)?;
    let turn = turn(stored, tag, expected, reading.rows, place)?;
    let ((color, alpha), tag) = if format_of(path, place)? == PictureFormat::Tiff {
        let picture = TiffSamples::read(path, place)?;
        let tag = match &picture.profile {
            Some(profile) if reading.is_linear.is_none() && picture.whole_up_to.is_some() => {
                ColorTag::of_profile(profile, place)?
            }
            _ => None,
        };
        let is_linear = if tag.is_some() { Some(true) } else { reading.is_linear };
        (tiff_color(picture, is_linear), tag)
    } else {
        let tag = if reading.is_linear.is_some() { None } else { color_tag(path, place)? };
        let is_linear = tag.is_some() || reading.is_linear == Some(true);
        (raster_color(path, place, is_linear)?, tag)
    };
    let color = match tag {
        Some(tag) => tag.linear(color, place)?,
        None => color,
    };
    Ok((color.map(|plane| turned(plane, stored, turn)), alpha.map(|plane| turned(plane, stored, turn))))
}

/// What a PNG or JPEG says of its colors; `None` where they are sRGB.
fn color_tag(path: &Path, place: &str) -> Result<Option<ColorTag>> {
    if format_of(path, place)? == PictureFormat::Png {
        return ColorTag::of_png(path, place);
    }
    let (reader, format) = reader(path, place)?;
    let mut decoder = reader.into_decoder().map_err(|error| damaged(place, format, &error))?;
    let profile = decoder.icc_profile().map_err(|error| damaged(place, format, &error))?;
    profile.map_or(Ok(None), |profile| ColorTag::of_profile(&profile, place))
}

/// Columns and rows of a picture as it is stored, and how it is to be turned to be shown.
fn stored_size(path: &Path, place: &str) -> Result<((usize, usize), Orientation)> {
    if format_of(path, place)? == PictureFormat::Tiff {
        return tiff_samples::size(path, place);
    }
    let (reader, format) = reader(path, place)?;
    let mut decoder = reader.into_decoder().map_err(|error| damaged(place, format, &error))?;
    let (width, height) = decoder.dimensions();
    // A tag that cannot be read turns nothing.
    let tag = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    Ok(((width as usize, height as usize), tag))
}

/// Columns and rows of a picture whose camera is not known, once it is upright: files beside it may tell which way that is.
///
/// # Errors
/// `Io`, and `Invalid` for a damaged header, and where a tag turns the picture and nothing tells which rows are meant.
pub(crate) fn size_of_rows(
    path: &Path,
    rows: Option<PictureRows>,
    beside: Option<(usize, usize)>,
    place: &str,
) -> Result<(usize, usize)> {
    let (stored, tag) = stored_size(path, place)?;
    let shown = shown_size(stored, tag);
    if shown == stored {
        return Ok(stored);
    }
    match rows.or_else(|| rows_by_size(stored, tag, beside?)) {
        Some(PictureRows::AsStored) => Ok(stored),
        Some(PictureRows::AsShown) => Ok(shown),
        None => Err(turned::open(tag, place)),
    }
}

/// Whether a tag turns a picture so that its size alone does not tell which rows a camera of the `expected` size means.
pub(crate) fn is_open(path: &Path, expected: (usize, usize), place: &str) -> bool {
    stored_size(path, place).is_ok_and(|(stored, tag)| {
        tag != Orientation::NoTransforms && stored == expected && shown_size(stored, tag) == expected
    })
}

/// Colors and alpha of a PNG or JPEG, decoded from sRGB unless they are linear, or are not yet to be.
fn raster_color(path: &Path, place: &str, is_linear: bool) -> Result<ColorAndAlpha> {
    let picture = decode_any(path, place)?;
    let has_alpha = picture.color().has_alpha();
    let mut rgba = picture.into_rgba16();
    if has_alpha && is_multiplied(&rgba) {
        for Rgba([r, g, b, alpha]) in rgba.pixels_mut().filter(|pixel| pixel.0[3] > 0) {
            for value in [r, g, b] {
                *value = (u32::from(*value) * u32::from(u16::MAX) / u32::from(*alpha)).min(65535) as u16;
            }
        }
    }
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

/// Whether colors are multiplied with alpha, though PNG keeps them apart: no color is brighter than its alpha, and those of half
/// transparent pixels are as bright as opaque ones beside them once they are divided.
fn is_multiplied(picture: &ImageBuffer<Rgba<u16>, Vec<u16>>) -> bool {
    /// Fewer half transparent pixels tell nothing.
    const LEAST: u32 = 16;
    let (width, height) = picture.dimensions();
    let brightest = |pixel: &Rgba<u16>| pixel.0[..3].iter().copied().max().unwrap_or(0);
    // A rounding of 8 bits is allowed.
    if picture.pixels().any(|pixel| u32::from(brightest(pixel)) > u32::from(pixel.0[3]) + 257) {
        return false;
    }
    let (mut count, mut as_kept, mut as_multiplied) = (0, 0.0, 0.0);
    for (x, y, pixel) in picture.enumerate_pixels() {
        let alpha = f64::from(pixel.0[3]) / 65535.0;
        if !(0.1..0.9).contains(&alpha) {
            continue;
        }
        let beside = [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)];
        let is_inside = |(x, y): &(u32, u32)| *x < width && *y < height;
        let beside = beside.into_iter().filter(is_inside).map(|(x, y)| picture.get_pixel(x, y));
        for opaque in beside.filter(|pixel| pixel.0[3] == u16::MAX) {
            let [own, other] = [pixel, opaque].map(|pixel| f64::from(brightest(pixel)));
            count += 1;
            as_kept += (own - other).abs();
            as_multiplied += (own / alpha - other).abs();
        }
    }
    count >= LEAST && as_multiplied < 0.5 * as_kept
}

/// Color and alpha of a TIFF picture; gray becomes all three colors.
fn tiff_color(picture: TiffSamples, is_linear: Option<bool>) -> ColorAndAlpha {
    let has_alpha = picture.has_alpha();
    let TiffSamples { channels, values, whole_up_to, .. } = picture;
    let is_linear = is_linear.unwrap_or(whole_up_to.is_none());
    let scale = whole_up_to.map_or(1.0, f32::recip);
    let plane = |channel: usize| values.iter().skip(channel).step_by(channels).map(|value| value * scale);
    let colors = if channels < 3 { [0; 3] } else { [0, 1, 2] };
    let color = colors.map(|channel| {
        let plane = plane(channel);
        if is_linear { plane.collect() } else { plane.map(linear_from_srgb).collect() }
    });
    let alpha = has_alpha.then(|| plane(channels - 1).collect());
    (color, alpha)
}

/// A gray picture of 8 bits, as confidence is: columns, rows and values row by row.
pub(crate) fn gray(path: &Path, place: &str) -> Result<((usize, usize), Vec<u8>)> {
    if format_of(path, place)? == PictureFormat::Tiff {
        let TiffSamples { size, channels, values, .. } = TiffSamples::read(path, place)?;
        // Confidence is a number, not a share of the largest.
        let gray = values.into_iter().step_by(channels).map(|value| value.ceil().clamp(0.0, 255.0) as u8);
        return Ok((size, gray.collect()));
    }
    let picture = decode_any(path, place)?;
    let gray = match picture {
        // The low byte of 16 bits counts: confidence is 0, 1 or 2.
        DynamicImage::ImageLuma16(gray) if gray.pixels().all(|pixel| pixel.0[0] < 256) => {
            let size = (gray.width() as usize, gray.height() as usize);
            return Ok((size, gray.pixels().map(|pixel| pixel.0[0] as u8).collect()));
        }
        picture => picture.into_luma8(),
    };
    Ok(((gray.width() as usize, gray.height() as usize), gray.into_raw()))
}
