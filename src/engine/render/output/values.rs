//! The scalar values that a picture shows: in each pixel those of the sample that is nearest there. Nothing is blended, neither between
//! samples nor across outlines.

use std::path::Path;

use image::{ImageFormat, Rgba, RgbaImage};
use rayon::prelude::*;

use super::exr::write_with;
use super::pick::pick;
use crate::capture::{MISSING_VALUE, ValueChannel, Values};
use crate::error::{Error, Result};
use crate::render::value_colors::ValueColors;
use crate::render::vantage::{NO_IMAGE, Picture, Vantage};
use crate::samples::SampleSet;
use crate::whole_file;

/// The values of a picture's pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureValues {
    /// What they mean, channel by channel; none where the samples have no values.
    pub channels: Vec<ValueChannel>,
    /// Row-major; missing in holes, filled or not, and where the nearest sample has no value.
    pub values: Values,
}

impl PictureValues {
    /// The values of `picture`, which `samples` gave at `vantage`.
    #[must_use]
    pub fn of(samples: &SampleSet, vantage: &Vantage, picture: &Picture) -> Self {
        let channels = samples.values.len();
        let (width, height) = picture.image.size();
        if channels == 0 {
            return Self { channels: Vec::new(), values: Values::default() };
        }
        let none = [MISSING_VALUE; crate::capture::MAX_VALUE_CHANNELS];
        let of_row = |y: usize| -> Vec<f32> {
            (0..width)
                .flat_map(|x| {
                    let picked = pick(samples, vantage, picture, x, y);
                    let values = picked.map(|picked| samples.images[picked.image].values.of(picked.index));
                    values.filter(|values| values.len() == channels).unwrap_or(&none[..channels]).to_vec()
                })
                .collect()
        };
        let values: Vec<f32> = (0..height).into_par_iter().flat_map_iter(of_row).collect();
        let plane = |channel: usize| values.iter().skip(channel).step_by(channels).copied().collect();
        let planes: Vec<Vec<f32>> = (0..channels).map(plane).collect();
        Self { channels: samples.values.clone(), values: Values::from_planes(&planes) }
    }

    /// The number of the channel of a name.
    ///
    /// # Errors
    /// `Invalid` with the names there are.
    pub fn channel(channels: &[ValueChannel], name: &str, place: &str) -> Result<usize> {
        let found = channels.iter().position(|channel| channel.name == name);
        found.ok_or_else(|| {
            let names: Vec<&str> = channels.iter().map(|channel| channel.name.as_str()).collect();
            let what = if names.is_empty() {
                format!("there is no value '{name}': the capture gave none; list them as \"values\" in its manifest")
            } else {
                format!("there is no value '{name}'; there are {}", names.join(", "))
            };
            Error::invalid(place, what)
        })
    }
}

/// Writes a picture as [`write_exr`](super::write_exr()) does, with a channel `value.NAME` for each channel of values; NaN where one is
/// missing.
///
/// # Errors
/// As [`write_exr`](super::write_exr()).
pub fn write_exr_with_values(path: &Path, picture: &Picture, values: &PictureValues) -> Result<()> {
    write_with(path, picture, &values.channels, &values.values)
}

/// Writes one channel of values as an 8-bit sRGB PNG in `colors`. Holes that were not filled are transparent. The file takes its name
/// when it is complete.
///
/// # Errors
/// `Io` where the file cannot be written, `Invalid` where a PNG cannot hold the picture.
pub fn write_value_png(
    path: &Path,
    picture: &Picture,
    values: &PictureValues,
    channel: usize,
    colors: &ValueColors,
) -> Result<()> {
    let (width, height) = picture.image.size();
    let of_pixel: Vec<f32> = values.values.channel(channel).collect();
    let png = RgbaImage::from_fn(width as u32, height as u32, |x, y| {
        let pixel = (x as usize, y as usize);
        let [r, g, b] = colors.color(of_pixel[pixel.1 * width + pixel.0]);
        Rgba([r, g, b, (255.0 * picture.alpha(pixel) + 0.5) as u8])
    });
    whole_file::write(path, |writer| {
        png.write_to(writer, ImageFormat::Png).map_err(|error| match error {
            image::ImageError::IoError(error) => Error::io(path, error),
            error => Error::invalid(path.display(), error.to_string()),
        })
    })
}

/// Writes one channel of values of a picture as an array of `NumPy`: float32, rows and columns, NaN where a value is missing.
///
/// # Errors
/// `Io` where the file cannot be written.
pub fn write_npy(path: &Path, picture: &Picture, values: &PictureValues, channel: usize) -> Result<()> {
    /// Headers end at a multiple of this, line feed included.
    const ALIGNED: usize = 64;
    const BEFORE_HEADER: usize = 10;
    let (width, height) = picture.image.size();
    let mut header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({height}, {width}), }}");
    let length = (BEFORE_HEADER + header.len() + 1).next_multiple_of(ALIGNED) - BEFORE_HEADER;
    header.extend(std::iter::repeat_n(' ', length - 1 - header.len()));
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((length as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(values.values.channel(channel).flat_map(f32::to_le_bytes));
    whole_file::write(path, |writer| {
        std::io::Write::write_all(writer, &bytes).map_err(|error| Error::io(path, error))
    })
}

/// The values of one channel that a picture shows, ascending, without missing and infinite ones.
#[must_use]
pub fn shown_values(picture: &Picture, values: &PictureValues, channel: usize) -> Vec<f32> {
    let images = picture.image.as_slice();
    let shown = values.values.channel(channel).zip(images).filter(|(_, image)| **image != NO_IMAGE);
    let mut shown: Vec<f32> = shown.map(|(value, _)| value).filter(|value| value.is_finite()).collect();
    shown.sort_unstable_by(f32::total_cmp);
    shown
}
