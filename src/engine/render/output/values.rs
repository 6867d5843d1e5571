//! The scalar values that a picture shows: in each pixel those of the sample that is nearest there. Nothing is blended, neither between
//! samples nor across outlines.

use std::path::Path;

use image::RgbaImage;
use rayon::prelude::*;

use super::exr::write_with;
use super::pick::pick;
use crate::capture::{MISSING_VALUE, ValueChannel, Values};
use crate::color::linear_from_srgb;
use crate::error::{Error, Result};
use crate::grid::Grid;
use crate::render::free_space::HOLE;
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

    /// The picture in the colors of one channel; black in holes that were not filled, and holes where nothing has a value if the colors
    /// leave that out.
    #[must_use]
    pub fn colored(&self, picture: &Picture, channel: usize, colors: &ValueColors) -> Picture {
        let (width, height) = picture.color.size();
        let values: Vec<f32> = self.values.channel(channel).collect();
        let value_at = |x: usize, y: usize| values.get(y * width + x).copied().unwrap_or(MISSING_VALUE);
        let color = Grid::from_fn(width, height, |x, y| {
            let inverse_depth = picture.inverse_depth[(x, y)];
            if picture.alpha((x, y)) > 0.0 {
                colors.linear_color_at(value_at(x, y), inverse_depth)
            } else {
                [0.0; 3]
            }
        });
        let mut colored = Picture { color, ..picture.clone() };
        if colors.leaves_out_missing() {
            for pixel in
                (0..width * height).filter(|pixel| colors.is_missing(value_at(pixel % width, pixel / width)))
            {
                colored.color.as_mut_slice()[pixel] = [0.0; 3];
                colored.image.as_mut_slice()[pixel] = NO_IMAGE;
                colored.inverse_depth.as_mut_slice()[pixel] = HOLE;
                if let Some(coverage) = colored.coverage.get_mut(pixel) {
                    *coverage = 0.0;
                }
            }
        }
        colored
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

/// A picture with opaque pixels of 8-bit sRGB below it, which are as wide as it is.
///
/// # Panics
/// Where they are not as wide.
#[must_use]
pub fn with_below(picture: &Picture, below: &RgbaImage) -> Picture {
    let (width, height) = picture.color.size();
    assert_eq!(below.width() as usize, width, "what lies below a picture is as wide as it");
    let rows = height + below.height() as usize;
    let linear = |channel: u8| linear_from_srgb(f32::from(channel) / 255.0);
    let color = Grid::from_fn(width, rows, |x, y| match y.checked_sub(height) {
        None => picture.color[(x, y)],
        Some(y) => {
            let [red, green, blue, _] = below.get_pixel(x as u32, y as u32).0;
            [red, green, blue].map(linear)
        }
    });
    let mut coverage = picture.coverage.clone();
    if !coverage.is_empty() {
        coverage.resize(width * rows, 1.0);
    }
    let extended = |plane: &[f32]| [plane, &vec![0.0; width * (rows - height)]].concat();
    Picture {
        color,
        inverse_depth: Grid::from_vec(width, rows, extended(picture.inverse_depth.as_slice())),
        image: Grid::from_fn(width, rows, |x, y| picture.image.get(x, y).copied().unwrap_or(NO_IMAGE)),
        fronts: Vec::new(),
        coverage,
    }
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

/// The value below which a share (0 to 1) of some lies, which ascend: one of them. `None` without any.
#[must_use]
pub fn ranked_value(ascending: &[f32], share: f32) -> Option<f32> {
    let last = ascending.len().checked_sub(1)?;
    ascending.get((share * last as f32).round() as usize).copied()
}

/// The values of one channel of the samples that hold, without missing and infinite ones.
#[must_use]
pub fn kept_values(samples: &SampleSet, frame: usize, channel: usize) -> Vec<f32> {
    let of_images = samples.images_at(frame).flat_map(|image| image.values.channel(channel));
    let mut values: Vec<f32> = of_images.filter(|value| value.is_finite()).collect();
    values.par_sort_unstable_by(f32::total_cmp);
    values
}
