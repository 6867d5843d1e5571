//! Pictures in raw video, as the manifest's keys describe it.

use std::path::Path;

use super::files::PictureFiles;
use super::manifest::Keys;
use crate::capture::exr::{DepthKind, DepthRules};
use crate::capture::yuv::{ColorMatrix, DepthRange, PixelFormat, YuvFile};
use crate::error::{Error, Result};

/// What the manifest says of raw video.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct RawVideo {
    index: u64,
    color: Option<PixelFormat>,
    depth: Option<PixelFormat>,
    matrix: ColorMatrix,
    range: Option<DepthRange>,
}

impl RawVideo {
    /// Takes what the manifest's keys say; `place` is the entry.
    ///
    /// # Errors
    /// `Invalid` and `Unsupported` for values that mean nothing.
    pub(super) fn new(keys: &Keys, place: &str) -> Result<Self> {
        let format = |key: &str, name: &Option<String>| {
            name.as_ref().map(|name| PixelFormat::of_key(key, name, place)).transpose()
        };
        let matrix = keys.yuv_color.as_deref().map(|name| {
            ColorMatrix::from_name(name).ok_or_else(|| {
                let what = format!("yuv_color '{name}' is unknown; there are {}", ColorMatrix::NAMES);
                Error::invalid(place, what)
            })
        });
        let range = keys.depth_range.map(|(near, far)| {
            let far = far.unwrap_or(f64::INFINITY);
            if near > 0.0 && near < far {
                let zero_is_unknown = keys.depth_zero_is_unknown.unwrap_or(false);
                return Ok(DepthRange { near, far, zero_is_unknown });
            }
            let what = format!("depth_range is [{near}, {far}]; it is [near, far], with 0 < near < far");
            Err(Error::invalid(place, what))
        });
        Ok(Self {
            index: keys.picture_in_file.unwrap_or(0),
            color: format("pixel_format", &keys.pixel_format)?,
            depth: format("depth_pixel_format", &keys.depth_pixel_format)?,
            matrix: matrix.transpose()?.unwrap_or_default(),
            range: range.transpose()?,
        })
    }
}

/// Linear red, green and blue.
pub(super) fn color(files: &PictureFiles, place: &str, size: (usize, usize)) -> Result<[Vec<f32>; 3]> {
    color_file(files, place, size)?.color(files.raw_video.index, files.raw_video.matrix)
}

/// Checks that a picture of color is there.
pub(super) fn check_color(files: &PictureFiles, place: &str, size: (usize, usize)) -> Result<()> {
    color_file(files, place, size)?.check(files.raw_video.index)
}

fn color_file<'a>(files: &'a PictureFiles, place: &'a str, size: (usize, usize)) -> Result<YuvFile<'a>> {
    let format = files.raw_video.color.ok_or_else(|| missing(place, "pixel_format"))?;
    Ok(YuvFile::new(&files.color, place, format, size))
}

/// Depth in world units, and half a level of it as a share of a depth of 1.
pub(super) fn depth(
    path: &Path,
    files: &PictureFiles,
    place: &str,
    size: (usize, usize),
) -> Result<(Vec<f32>, f32)> {
    let (file, range) = depth_file(path, files, place, size)?;
    Ok((file.depth(files.raw_video.index, &range)?, file.half_step(&range)))
}

/// Checks that a picture of depth is there.
pub(super) fn check_depth(
    path: &Path,
    files: &PictureFiles,
    place: &str,
    size: (usize, usize),
) -> Result<()> {
    depth_file(path, files, place, size)?.0.check(files.raw_video.index)
}

fn depth_file<'a>(
    path: &'a Path,
    files: &PictureFiles,
    place: &'a str,
    size: (usize, usize),
) -> Result<(YuvFile<'a>, DepthRange)> {
    let format = files.raw_video.depth.ok_or_else(|| missing(place, "depth_pixel_format"))?;
    let range = files.raw_video.range.ok_or_else(|| missing(place, "depth_range"))?;
    Ok((YuvFile::new(path, place, format, size), range))
}

fn missing(place: &str, key: &str) -> Error {
    Error::invalid(place, format!("raw video says nothing of itself; give {key} in the manifest"))
}

impl PictureFiles {
    /// The rules for depth of raw video, which is in world units already.
    ///
    /// # Errors
    /// `Invalid` for positions, which take three channels.
    pub(super) fn raw_video_rules(&self, place: &str) -> Result<DepthRules> {
        let rules = self.png_depth_rules(place)?;
        let kind = self.depth_kind.unwrap_or(DepthKind::PlanarZ);
        Ok(DepthRules { kind, unit_scale: 1.0, zero_is_unknown: true, misses_from: f32::MAX, ..rules })
    }
}
