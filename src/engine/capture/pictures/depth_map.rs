//! Depth in files that hold one value a pixel.
//!
//! How sure a depth sensor is of each pixel.
//!
//! Source: Apple's `ARConfidenceLevel`, which is low, medium or high, as Stray Scanner and 3D Scanner App (0, 1, 2) and Polycam
//! (0, 127, 255) write it. Pixels below high are dropped where three tenths of the picture stay then, else those below medium: a
//! picture of far or dark things has few high ones, and would be empty.

use std::path::Path;

use image::DynamicImage;

use super::format::{PictureFormat, format_of};
use super::raster::{decode_any, size};
use super::tiff_samples::TiffSamples;
use super::{colmap_map, npy, pfm, pgm};
use crate::capture::frame::INVALID_INVERSE_DEPTH;
use crate::error::{Error, Result};
use crate::whole_file;

/// Relative rounding of half floats.
const HALF_STEP: f32 = 1.0 / 2048.0;

/// Raw values of depth.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct DepthMap {
    /// Columns and rows.
    pub size: (usize, usize),
    /// Row by row, in the file's unit.
    pub values: Vec<f32>,
    /// The largest value of whole numbers, or `None` for floats.
    pub whole_up_to: Option<f32>,
    /// Relative rounding of the values: 2⁻¹¹ for half floats.
    pub step_relative: f32,
}

impl DepthMap {
    /// Reads depth from any format but `OpenEXR`. A PNG of 8 bits of gray (or of three equal channels) is enough where values are `levels`
    /// between two planes.
    ///
    /// # Errors
    /// `Io`, `Invalid`, `Unsupported`: a file that is missing, damaged, or holds something else.
    pub(crate) fn read(path: &Path, levels: bool, place: &str) -> Result<Self> {
        let bytes = || whole_file::read_all(path);
        let whole =
            |size, values| Self { size, values, whole_up_to: Some(f32::from(u16::MAX)), step_relative: 0.0 };
        match format_of(path, place)? {
            PictureFormat::Pgm => {
                let (size, values) = pgm::parse(&bytes()?, place)?;
                Ok(whole(size, values))
            }
            PictureFormat::Pfm => {
                let (size, values) = pfm::parse(&bytes()?, place)?;
                Ok(Self { size, values, whole_up_to: None, step_relative: 0.0 })
            }
            PictureFormat::Npy => {
                let npy::NpyArray { size, values, is_whole, is_half, .. } = npy::parse(&bytes()?, place)?;
                let step_relative = if is_half { HALF_STEP } else { 0.0 };
                Ok(Self { size, values, whole_up_to: is_whole.then_some(f32::from(u16::MAX)), step_relative })
            }
            PictureFormat::ColmapMap => {
                let (size, mut planes) = colmap_map::read(path, 1, place)?;
                Ok(Self { size, values: planes.remove(0), whole_up_to: None, step_relative: 0.0 })
            }
            PictureFormat::Tiff => tiff(path, place),
            PictureFormat::Jpeg => Err(jpeg(place)),
            _ => match decode_any(path, place)? {
                DynamicImage::ImageLuma16(gray) => {
                    let size = (gray.width() as usize, gray.height() as usize);
                    Ok(whole(size, gray.pixels().map(|pixel| f32::from(pixel.0[0])).collect()))
                }
                picture if has_sixteen_equal_bits(&picture) => {
                    let gray = picture.into_rgb16();
                    let size = (gray.width() as usize, gray.height() as usize);
                    Ok(whole(size, gray.pixels().map(|pixel| f32::from(pixel.0[0])).collect()))
                }
                picture if levels && has_eight_bits(&picture) => {
                    let gray = picture.into_luma8();
                    let size = (gray.width() as usize, gray.height() as usize);
                    let values = gray.pixels().map(|pixel| f32::from(pixel.0[0])).collect();
                    Ok(Self { size, values, whole_up_to: Some(f32::from(u8::MAX)), step_relative: 0.0 })
                }
                _ => Err(not_depth(place)),
            },
        }
    }
}

/// Whether all colors of a picture of 16 bits are gray.
fn has_sixteen_equal_bits(picture: &DynamicImage) -> bool {
    match picture {
        DynamicImage::ImageLumaA16(_) => true,
        DynamicImage::ImageRgb16(rgb) => rgb.pixels().all(|pixel| pixel.0 == [pixel.0[0]; 3]),
        DynamicImage::ImageRgba16(rgba) => rgba.pixels().all(|pixel| pixel.0[..3] == [pixel.0[0]; 3]),
        _ => false,
    }
}

/// Whether a picture is gray of 8 bits, also where three channels hold the same.
fn has_eight_bits(picture: &DynamicImage) -> bool {
    match picture {
        DynamicImage::ImageLuma8(_) => true,
        DynamicImage::ImageRgb8(rgb) => rgb.pixels().all(|pixel| pixel.0 == [pixel.0[0]; 3]),
        _ => false,
    }
}

fn jpeg(place: &str) -> Error {
    let what =
        "JPEG holds no depth: it has 8 bits, and changes them; save depth as 16-bit PNG, TIFF, .npy or EXR";
    Error::unsupported(place, what)
}

fn not_depth(place: &str) -> Error {
    Error::unsupported(place, "depth in PNG must be 16-bit gray; save it so, or as EXR")
}

/// Columns and rows of depth in any format but `OpenEXR`, from the header where it is apart; `levels` as in
/// `DepthMap::read`.
///
/// # Errors
///
/// `Io` or `Unsupported`, with `place`, where the file cannot be read as depth.
pub fn depth_size(path: &Path, levels: bool, place: &str) -> Result<(usize, usize)> {
    match format_of(path, place)? {
        PictureFormat::Png if levels => size(path, place),
        PictureFormat::Png => {
            super::raster::check_gray16(path, place)
                .map_err(|error| error.unwrap_or_else(|| not_depth(place)))?;
            size(path, place)
        }
        _ => Ok(DepthMap::read(path, levels, place)?.size),
    }
}

fn tiff(path: &Path, place: &str) -> Result<DepthMap> {
    let TiffSamples { size, channels, values, whole_up_to, is_half, .. } = TiffSamples::read(path, place)?;
    if channels != 1 {
        let (width, height) = size;
        let what = format!(
            "the number of values for {width}×{height} pixels is {}; depth has one channel",
            values.len()
        );
        return Err(Error::unsupported(place, what));
    }
    if whole_up_to.is_some_and(|most| most <= f32::from(u8::MAX)) {
        let what = "depth in TIFF must have 16 or 32 bits, or floats; save it so, or as EXR";
        return Err(Error::unsupported(place, what));
    }
    Ok(DepthMap { size, values, whole_up_to, step_relative: if is_half { HALF_STEP } else { 0.0 } })
}

/// "High" is required if at least this share of pixels stays.
const SHARE_OF_HIGH: f64 = 0.3;

/// Takes the inverse depth of pixels that the sensor is unsure of; `confidence` is of the same size.
pub(crate) fn drop_unsure(inverse_depth: &mut [f32], confidence: &[u8]) {
    let is_in_steps = confidence.iter().all(|level| *level <= 2);
    let (high, medium) = if is_in_steps { (2, 1) } else { (255, 127) };
    let sure = confidence.iter().filter(|level| **level >= high).count();
    let is_enough = sure as f64 >= SHARE_OF_HIGH * confidence.len() as f64;
    let least = if is_enough { high } else { medium };
    for (value, level) in inverse_depth.iter_mut().zip(confidence) {
        if *level < least {
            *value = INVALID_INVERSE_DEPTH;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kept(confidence: &[u8]) -> Vec<bool> {
        let mut values = vec![1.0; confidence.len()];
        drop_unsure(&mut values, confidence);
        values.iter().map(|value| *value >= 0.0).collect()
    }

    #[test]
    fn pixels_below_high_go_while_enough_stay() {
        assert_eq!(kept(&[2, 2, 1, 0]), [true, true, false, false]);
        assert_eq!(kept(&[255, 255, 127, 0]), [true, true, false, false]);
        assert_eq!(kept(&[1, 1, 1, 0, 2]), [true, true, true, false, true], "few are high");
    }
}
