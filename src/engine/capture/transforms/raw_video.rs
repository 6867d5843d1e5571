//! Pictures in raw video, as the manifest's keys describe it.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::capture::depth_claim::{DepthMeasure, DepthPlanes};
use crate::capture::exr::DepthKind;
use crate::capture::pictures::DepthMap;
use crate::capture::yuv::{ColorMatrix, LevelOrder, LevelRange, PixelFormat, YuvFile};
use crate::error::{Error, Result};

/// The manifest's keys of raw video.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct RawVideoKeys {
    /// Which picture of its files, from 0, where they hold several.
    pub picture_in_file: Option<u64>,
    /// Format of raw video of color, by ffmpeg's name.
    pub pixel_format: Option<String>,
    /// Format of raw video of depth.
    pub depth_pixel_format: Option<String>,
    /// Weights and range of raw video of color.
    pub yuv_color: Option<String>,
    /// Near and far plane of depth in raw video, in whole numbers or in a depth buffer, which is even in 1/z; far is null where it is
    /// infinite.
    pub depth_range: Option<(f64, Option<f64>)>,
    /// Whether level 0 of such depth means no depth.
    pub depth_zero_is_unknown: Option<bool>,
}

impl RawVideoKeys {
    /// These keys, and where one is missing that of `file`.
    pub(super) fn or(self, file: Self) -> Self {
        Self {
            picture_in_file: self.picture_in_file.or(file.picture_in_file),
            pixel_format: self.pixel_format.or(file.pixel_format),
            depth_pixel_format: self.depth_pixel_format.or(file.depth_pixel_format),
            yuv_color: self.yuv_color.or(file.yuv_color),
            depth_range: self.depth_range.or(file.depth_range),
            depth_zero_is_unknown: self.depth_zero_is_unknown.or(file.depth_zero_is_unknown),
        }
    }
}

/// The manifest's keys for raw video.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct RawVideo {
    index: u64,
    color: Option<PixelFormat>,
    depth: Option<PixelFormat>,
    matrix: ColorMatrix,
    range: Option<LevelRange>,
}

impl RawVideo {
    /// Takes the values of the manifest's keys, for depth of this kind; `place` is the entry.
    ///
    /// # Errors
    /// `Invalid` and `Unsupported` for values that mean nothing, and for a depth buffer without its planes.
    pub(super) fn new(keys: &RawVideoKeys, kind: Option<DepthKind>, place: &str) -> Result<Self> {
        let format = |key: &str, name: &Option<String>| {
            name.as_ref().map(|name| PixelFormat::of_key(key, name, place)).transpose()
        };
        let matrix = keys.yuv_color.as_deref().map(|name| {
            ColorMatrix::from_name(name).ok_or_else(|| {
                let what = format!("yuv_color '{name}' is unknown; there are {}", ColorMatrix::NAMES);
                Error::invalid(place, what)
            })
        });
        let order = match kind {
            Some(DepthKind::ZBuffer) => LevelOrder::ZBuffer,
            Some(DepthKind::ReversedZBuffer) => LevelOrder::ReversedZBuffer,
            _ => LevelOrder::FromFar,
        };
        if order != LevelOrder::FromFar && keys.depth_range.is_none() {
            let what = "a depth buffer is between two planes; give them as \"depth_range\": [near, far], in world units, far as null where it is infinite";
            return Err(Error::invalid(place, what));
        }
        let range = keys.depth_range.map(|(near, far)| {
            let far = far.unwrap_or(f64::INFINITY);
            if near > 0.0 && near < far {
                let zero_is_unknown = keys.depth_zero_is_unknown.unwrap_or(false);
                return Ok(LevelRange { near, far, order, zero_is_unknown });
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

    /// The file of color at `path`.
    ///
    /// # Errors
    /// `Invalid` if the manifest does not give its format.
    fn color_file<'a>(&self, path: &'a Path, place: &'a str, size: (usize, usize)) -> Result<YuvFile<'a>> {
        let format = self.color.ok_or_else(|| missing(place, "pixel_format"))?;
        Ok(YuvFile::new(path, place, format, size))
    }

    /// Linear red, green and blue.
    pub(super) fn color(&self, path: &Path, place: &str, size: (usize, usize)) -> Result<[Vec<f32>; 3]> {
        self.color_file(path, place, size)?.color(self.index, self.matrix)
    }

    /// Checks that a picture of color is there.
    pub(super) fn check_color(&self, path: &Path, place: &str, size: (usize, usize)) -> Result<()> {
        self.color_file(path, place, size)?.check(self.index)
    }

    /// Depth in world units, and half a level of it as inverse depth.
    pub(super) fn depth(&self, path: &Path, place: &str, size: (usize, usize)) -> Result<(Vec<f32>, f32)> {
        let (file, range) = self.depth_file(path, place, size)?;
        Ok((file.depth(self.index, &range)?, file.half_step(&range)))
    }

    /// Checks that a picture of depth is there.
    pub(super) fn check_depth(&self, path: &Path, place: &str, size: (usize, usize)) -> Result<()> {
        self.depth_file(path, place, size)?.0.check(self.index)
    }

    /// Whether depth is given in levels between a near and a far plane.
    pub(super) fn has_range(&self) -> bool {
        self.range.is_some()
    }

    /// The range between whose planes floats are too: that of a depth buffer.
    pub(super) fn buffer(&self) -> Option<LevelRange> {
        self.range.filter(|range| range.order != LevelOrder::FromFar)
    }

    /// What numbers between near and far plane measure, and the planes; `None` where depth is not given so.
    pub(super) fn claim(&self) -> Option<(DepthMeasure, DepthPlanes)> {
        let range = self.range?;
        let is_normal = range.order == LevelOrder::ZBuffer;
        let measure = if is_normal { DepthMeasure::ZBuffer } else { DepthMeasure::ReversedZBuffer };
        Some((measure, range.planes()))
    }

    /// The values of a map as depth in world units, and half a step of it as inverse depth; `None` where they are not given in levels,
    /// nor in floats of a depth buffer.
    pub(super) fn depth_of_map(&self, map: &DepthMap) -> Option<(Vec<f32>, f32)> {
        let (range, largest, step) = match map.whole_up_to {
            Some(largest) => (self.range?, largest, largest.recip()),
            None => (self.buffer()?, 1.0, map.step_relative),
        };
        let depth = map.values.iter().map(|value| range.depth(*value, largest)).collect();
        Some((depth, range.half_step_of(step)))
    }

    fn depth_file<'a>(
        &self,
        path: &'a Path,
        place: &'a str,
        size: (usize, usize),
    ) -> Result<(YuvFile<'a>, LevelRange)> {
        let format = self.depth.ok_or_else(|| missing(place, "depth_pixel_format"))?;
        let range = self.range.ok_or_else(|| missing(place, "depth_range"))?;
        Ok((YuvFile::new(path, place, format, size), range))
    }
}

fn missing(place: &str, key: &str) -> Error {
    Error::invalid(place, format!("raw video has no header; give {key} in the manifest"))
}
