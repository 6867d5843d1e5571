//! The samples of a TIFF picture, of whatever type, as floats.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use image::metadata::Orientation;
use tiff::ColorType;
use tiff::decoder::{Decoder, DecodingResult};
use tiff::tags::Tag;

use crate::capture::camera::{MAX_PIXELS, is_believable_size};
use crate::error::{Error, Result, one_line};
use crate::whole_file;

/// The first picture of a file.
pub(super) struct TiffSamples {
    /// Columns and rows.
    pub(super) size: (usize, usize),
    /// Samples of each pixel: gray or red, green and blue, then alpha where there is one.
    pub(super) channels: usize,
    /// Pixel by pixel, as the file has them.
    pub(super) values: Vec<f32>,
    /// The largest value of whole numbers, or `None` for floats.
    pub(super) whole_up_to: Option<f32>,
    /// Whether they were half floats.
    pub(super) is_half: bool,
    /// The ICC profile of the colors.
    pub(super) profile: Option<Vec<u8>>,
}

impl TiffSamples {
    /// Whether the last sample of each pixel is alpha.
    pub(super) fn has_alpha(&self) -> bool {
        matches!(self.channels, 2 | 4)
    }
}

fn open(path: &Path, place: &str) -> Result<Decoder<BufReader<File>>> {
    let decoder =
        Decoder::new(BufReader::new(whole_file::open(path)?)).map_err(|error| damaged(place, &error))?;
    let mut limits = tiff::decoder::Limits::default();
    limits.decoding_buffer_size = 16 * MAX_PIXELS;
    Ok(decoder.with_limits(limits))
}

fn damaged(place: &str, error: &tiff::TiffError) -> Error {
    let what = one_line(&error.to_string());
    Error::invalid(place, format!("damaged, or not a TIFF picture that can be read ({what}); save it again"))
}

/// Columns and rows, and how the picture is to be turned to be shown, from the header.
pub(super) fn size(path: &Path, place: &str) -> Result<((usize, usize), Orientation)> {
    let mut decoder = open(path, place)?;
    let size = believable_size(&mut decoder, place)?;
    let tag = decoder.find_tag_unsigned::<u8>(Tag::Orientation).ok().flatten();
    Ok((size, tag.and_then(Orientation::from_exif).unwrap_or(Orientation::NoTransforms)))
}

fn believable_size(decoder: &mut Decoder<BufReader<File>>, place: &str) -> Result<(usize, usize)> {
    let (width, height) = decoder.dimensions().map_err(|error| damaged(place, &error))?;
    if is_believable_size(width as usize, height as usize) {
        return Ok((width as usize, height as usize));
    }
    Err(Error::unsupported(place, format!("{width}×{height} pixels are too many")))
}

/// Samples a pixel of a kind of picture.
fn channels(color: ColorType, place: &str) -> Result<usize> {
    let kind = match color {
        ColorType::Gray(_) => return Ok(1),
        ColorType::GrayA(_) => return Ok(2),
        ColorType::RGB(_) => return Ok(3),
        ColorType::RGBA(_) => return Ok(4),
        ColorType::Multiband { num_samples, .. } if num_samples <= 4 => return Ok(usize::from(num_samples)),
        ColorType::Palette(_) => "a palette",
        ColorType::CMYK(_) | ColorType::CMYKA(_) => "CMYK",
        ColorType::YCbCr(_) => "YCbCr",
        ColorType::Lab(_) => "L*a*b*",
        _ => "other channels than color and alpha",
    };
    Err(Error::unsupported(place, format!("TIFF with {kind} is not read; save it as RGB or gray")))
}

impl TiffSamples {
    /// Decodes the first picture.
    ///
    /// # Errors
    /// `Io`, `Invalid`, `Unsupported`: a file that is missing, damaged, or holds neither gray nor RGB.
    pub(super) fn read(path: &Path, place: &str) -> Result<Self> {
        let mut decoder = open(path, place)?;
        let size = believable_size(&mut decoder, place)?;
        let fault = |error| damaged(place, &error);
        let channels = channels(decoder.colortype().map_err(fault)?, place)?;
        let mut samples = DecodingResult::U8(Vec::new());
        let layout = decoder.read_image_to_buffer(&mut samples).map_err(fault)?;
        let is_half = matches!(samples, DecodingResult::F16(_));
        let (values, whole_up_to) = floats(samples);
        if values.len() != size.0 * size.1 * channels {
            let what = "it holds more or fewer samples than its pixels have; save it again";
            return Err(Error::invalid(place, what));
        }
        let values = if layout.planes > 1 { interleaved(&values, channels) } else { values };
        let profile = decoder.get_tag_u8_vec(Tag::IccProfile).ok();
        Ok(Self { size, channels, values, whole_up_to, is_half, profile })
    }
}

/// Samples plane after plane, pixel by pixel.
fn interleaved(planes: &[f32], channels: usize) -> Vec<f32> {
    let pixels = planes.len() / channels;
    (0..pixels).flat_map(|pixel| (0..channels).map(move |channel| planes[channel * pixels + pixel])).collect()
}

/// The samples as floats, and the largest value of their type if that holds whole numbers.
fn floats(samples: DecodingResult) -> (Vec<f32>, Option<f32>) {
    fn of<T: Copy>(values: Vec<T>, float: impl Fn(T) -> f32) -> Vec<f32> {
        values.into_iter().map(float).collect()
    }
    match samples {
        DecodingResult::F16(values) => (of(values, half::f16::to_f32), None),
        DecodingResult::F32(values) => (values, None),
        DecodingResult::F64(values) => (of(values, |value| value as f32), None),
        DecodingResult::U8(values) => (of(values, f32::from), Some(f32::from(u8::MAX))),
        DecodingResult::U16(values) => (of(values, f32::from), Some(f32::from(u16::MAX))),
        DecodingResult::U32(values) => (of(values, |value| value as f32), Some(u32::MAX as f32)),
        DecodingResult::U64(values) => (of(values, |value| value as f32), Some(u64::MAX as f32)),
        DecodingResult::I8(values) => (of(values, f32::from), Some(f32::from(i8::MAX))),
        DecodingResult::I16(values) => (of(values, f32::from), Some(f32::from(i16::MAX))),
        DecodingResult::I32(values) => (of(values, |value| value as f32), Some(i32::MAX as f32)),
        DecodingResult::I64(values) => (of(values, |value| value as f32), Some(i64::MAX as f32)),
    }
}
