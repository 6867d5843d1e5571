//! Pictures in a raw video file.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use super::color::ColorMatrix;
use super::format::PixelFormat;
use crate::capture::depth_claim::DepthPlanes;
use crate::color::{linear_from_srgb, srgb_from_linear};
use crate::error::{Error, Result};

/// A file of raw video. One picture at a time is read.
pub(crate) struct YuvFile<'a> {
    path: &'a Path,
    place: &'a str,
    format: PixelFormat,
    size: (usize, usize),
}

/// What is at the ends of a range of levels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum LevelOrder {
    /// Levels as MPEG immersive video has them: surfaces lie from the far plane, level 0, to the near one.
    #[default]
    FromFar,
    /// A depth buffer: level 0 is the near plane. Nothing was drawn where the far plane is.
    ZBuffer,
    /// A reversed depth buffer: level 0 is the far plane, where nothing was drawn.
    ReversedZBuffer,
}

/// What the levels of a picture of depth mean: 1/z runs evenly from the far to the near plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LevelRange {
    /// The nearest depth.
    pub near: f64,
    /// The farthest depth; may be infinite.
    pub far: f64,
    /// Which end is which.
    pub order: LevelOrder,
    /// Whether level 0 means that there is no depth.
    pub zero_is_unknown: bool,
}

impl LevelRange {
    /// The depth of a level of at most `largest`, in world units: infinite at infinity, NaN where it is not known.
    pub(crate) fn depth(&self, level: f32, largest: f32) -> f32 {
        if level == 0.0 && self.zero_is_unknown {
            return f32::NAN;
        }
        let share = f64::from(level) / f64::from(largest);
        let nearness = if self.order == LevelOrder::ZBuffer { 1.0 - share } else { share };
        if self.order != LevelOrder::FromFar && nearness == 0.0 {
            return f32::INFINITY;
        }
        // A buffer holds no surface before its near plane, nor right on it.
        if self.order != LevelOrder::FromFar && !(0.0..1.0).contains(&nearness) {
            return f32::NAN;
        }
        self.planes().inverse_depth(nearness).recip() as f32
    }

    /// The planes.
    pub(crate) fn planes(&self) -> DepthPlanes {
        DepthPlanes { near: self.near, far: self.far.is_finite().then_some(self.far) }
    }

    /// Half a level of at most `largest`, as inverse depth.
    pub(crate) fn half_step(&self, largest: f32) -> f32 {
        self.half_step_of(largest.recip())
    }

    /// Half a step, a share of the range, as inverse depth.
    pub(crate) fn half_step_of(&self, step: f32) -> f32 {
        (0.5 * (self.near.recip() - self.far.recip()) * f64::from(step)) as f32
    }

    /// The level of an inverse depth of 0 or more; `None` where it is negative: that is no depth.
    pub(crate) fn level(&self, inverse_depth: f32, largest: u16) -> u16 {
        if inverse_depth < 0.0 {
            return 0;
        }
        let (near, far) = (self.near.recip(), self.far.recip());
        let share = (f64::from(inverse_depth) - far) / (near - far);
        let lowest = u16::from(self.zero_is_unknown);
        ((share * f64::from(largest)).round().clamp(0.0, f64::from(largest)) as u16).max(lowest)
    }
}

/// Whole pictures in a file.
///
/// # Errors
/// `Io` where it is not there.
pub(crate) fn pictures_in(path: &Path, format: PixelFormat, size: (usize, usize)) -> Result<u64> {
    let length = std::fs::metadata(path).map_err(|error| Error::io(path, error))?.len();
    Ok(length / format.picture_bytes(size).max(1))
}

impl<'a> YuvFile<'a> {
    /// A file of pictures of one format and size; `place` is named in errors.
    pub(crate) fn new(path: &'a Path, place: &'a str, format: PixelFormat, size: (usize, usize)) -> Self {
        Self { path, place, format, size }
    }

    /// Looks whether the file holds a picture, without reading it.
    ///
    /// # Errors
    /// `Io`, and `Invalid` where the file ends before the picture does.
    pub(crate) fn check(&self, index: u64) -> Result<()> {
        let length = std::fs::metadata(self.path).map_err(|error| Error::io(self.path, error))?.len();
        let each = self.format.picture_bytes(self.size);
        let needed = each.checked_mul(index.saturating_add(1));
        if needed.is_some_and(|needed| needed <= length) {
            return Ok(());
        }
        let (width, height) = self.size;
        let what = format!(
            "the file ends at byte {length}, before picture {index} of {width}×{height} {} ({each} bytes each) does; is it whole, and are size and format right?",
            self.format.name()
        );
        Err(Error::invalid(self.place, what))
    }

    /// Half a level, as inverse depth.
    pub(crate) fn half_step(&self, range: &LevelRange) -> f32 {
        range.half_step(f32::from(self.format.largest()))
    }

    /// The samples of picture `index`: luma, U, V.
    fn read(&self, index: u64) -> Result<Vec<u16>> {
        self.check(index)?;
        let each = self.format.picture_bytes(self.size);
        let mut bytes = vec![0; each as usize];
        let read = || -> std::io::Result<Vec<u8>> {
            let mut file = File::open(self.path)?;
            file.seek(SeekFrom::Start(index * each))?;
            file.read_exact(&mut bytes)?;
            Ok(bytes)
        };
        let bytes = read().map_err(|error| Error::io(self.path, error))?;
        Ok(if self.format.sample_bytes() == 1 {
            bytes.iter().map(|byte| u16::from(*byte)).collect()
        } else {
            bytes.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect()
        })
    }

    /// Linear red, green and blue of a picture, row-major. Color is interpolated between the middles of its blocks of 2×2 pixels.
    ///
    /// # Errors
    /// `Io`, and `Invalid` where the file ends too early.
    pub(crate) fn color(&self, index: u64, matrix: ColorMatrix) -> Result<[Vec<f32>; 3]> {
        let samples = self.read(index)?;
        let (width, height) = self.size;
        let (columns, rows) = PixelFormat::chroma_size(self.size);
        let full = f32::from(self.format.largest());
        let (luma, chroma) = samples.split_at(width * height);
        let plane = |index: usize| &chroma[index * columns * rows..][..columns * rows];
        let mut color = [(); 3].map(|()| Vec::with_capacity(width * height));
        for y in 0..height {
            for x in 0..width {
                let level = f32::from(luma[y * width + x]) / full;
                let [u, v] = if self.format.has_chroma {
                    [0, 1].map(|index| interpolated(plane(index), (columns, rows), x, y) / full)
                } else {
                    [0.5; 2]
                };
                let rgb = matrix.rgb([level, u, v]);
                color.iter_mut().zip(rgb).for_each(|(plane, value)| plane.push(linear_from_srgb(value)));
            }
        }
        Ok(color)
    }

    /// Depth of a picture in world units, row-major: infinite at infinity, NaN where it is not known. Planes of color are passed
    /// over.
    ///
    /// # Errors
    /// `Io`, and `Invalid` where the file ends too early.
    pub(crate) fn depth(&self, index: u64, range: &LevelRange) -> Result<Vec<f32>> {
        let largest = f32::from(self.format.largest());
        let mut samples = self.read(index)?;
        samples.truncate(self.size.0 * self.size.1);
        Ok(samples.into_iter().map(|level| range.depth(f32::from(level), largest)).collect())
    }
}

/// A plane of color at pixel `x`, `y`; `size` is the plane's columns and rows.
fn interpolated(plane: &[u16], size: (usize, usize), x: usize, y: usize) -> f32 {
    let (columns, rows) = size;
    // The pixel's own block counts three quarters, the one on its side a quarter, both ways.
    let beside = |at: usize, size: usize| {
        let own = at / 2;
        let other = if at.is_multiple_of(2) { own.saturating_sub(1) } else { (own + 1).min(size - 1) };
        (own, other)
    };
    let ((x, beside_x), (y, beside_y)) = (beside(x, columns), beside(y, rows));
    let at = |x: usize, y: usize| f32::from(plane[y * columns + x]);
    let along = |y: usize| 0.75 * at(x, y) + 0.25 * at(beside_x, y);
    0.75 * along(y) + 0.25 * along(beside_y)
}

/// The bytes of a picture of linear color, row-major; columns and rows are even.
pub(crate) fn encode_color(
    color: &[[half::f16; 3]],
    size: (usize, usize),
    format: PixelFormat,
    matrix: ColorMatrix,
) -> Vec<u8> {
    let (width, height) = size;
    let encoded = |pixel: &[half::f16; 3]| {
        matrix.yuv(pixel.map(|value| srgb_from_linear(value.to_f32().clamp(0.0, 1.0))))
    };
    let yuv: Vec<[f32; 3]> = color.iter().map(encoded).collect();
    let full = f32::from(format.largest());
    let level = |value: f32| (value * full).round().clamp(0.0, full) as u16;
    let mut samples: Vec<u16> = yuv.iter().map(|yuv| level(yuv[0])).collect();
    for channel in [1, 2] {
        for y in (0..height).step_by(2) {
            for x in (0..width).step_by(2) {
                let block = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)];
                let sum: f32 = block.iter().map(|(x, y)| yuv[y * width + x][channel]).sum();
                samples.push(level(sum / 4.0));
            }
        }
    }
    bytes(&samples, format)
}

/// The bytes of a picture of levels without color.
pub(crate) fn encode_levels(mut levels: Vec<u16>, size: (usize, usize), format: PixelFormat) -> Vec<u8> {
    if format.has_chroma {
        let (columns, rows) = PixelFormat::chroma_size(size);
        let middle = 1_u32 << (format.bits - 1);
        levels.resize(levels.len() + 2 * columns * rows, middle as u16);
    }
    bytes(&levels, format)
}

fn bytes(samples: &[u16], format: PixelFormat) -> Vec<u8> {
    if format.sample_bytes() == 1 {
        samples.iter().map(|sample| *sample as u8).collect()
    } else {
        samples.iter().flat_map(|sample| sample.to_le_bytes()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use half::f16;

    const FORMAT: PixelFormat = PixelFormat { bits: 10, has_chroma: true };

    #[test]
    fn a_smooth_picture_comes_back() {
        let (width, height) = (8, 6);
        let pixel = |index: usize| {
            let (x, y) = ((index % width) as f32, (index / width) as f32);
            // Color is halved in both directions: it must change little from pixel to pixel.
            [0.1 + 0.01 * x, 0.4 + 0.01 * y, 0.3].map(f16::from_f32)
        };
        let color: Vec<[f16; 3]> = (0..width * height).map(pixel).collect();
        let file = tempfile::NamedTempFile::new().unwrap();
        let one = encode_color(&color, (width, height), FORMAT, ColorMatrix::default());
        std::fs::write(file.path(), [one.clone(), one].concat()).unwrap();
        let yuv = YuvFile::new(file.path(), "test", FORMAT, (width, height));
        let read = yuv.color(1, ColorMatrix::default()).unwrap();
        for (index, pixel) in color.iter().enumerate() {
            for channel in 0..3 {
                let off = srgb_from_linear(read[channel][index]) - srgb_from_linear(pixel[channel].to_f32());
                assert!(off.abs() < 0.02, "{index} {channel}: {off}");
            }
        }
        let error = yuv.color(2, ColorMatrix::default()).unwrap_err().to_string();
        assert!(error.starts_with("test: the file ends at byte 288, before picture 2 of 8×6"), "{error}");
        assert!(yuv.check(u64::MAX).is_err());
    }

    #[test]
    fn the_worked_example_of_16_bits_is_met() {
        let range = LevelRange { near: 0.3, far: 1.62, order: LevelOrder::FromFar, zero_is_unknown: false };
        for (level, depth) in [(32_768.0, 0.506_245), (65_535.0, 0.3), (0.0, 1.62)] {
            assert!((range.depth(level, 65_535.0) - depth).abs() < 1e-6, "{level}");
        }
        for level in [0, 1, 777, 65_535] {
            let inverse = range.depth(f32::from(level), 65_535.0).recip();
            assert_eq!(range.level(inverse, 65_535), level);
        }
    }

    #[test]
    fn what_has_no_depth_and_what_is_at_infinity_stay_apart() {
        let range =
            LevelRange { near: 0.5, far: f64::INFINITY, order: LevelOrder::FromFar, zero_is_unknown: true };
        assert_eq!(range.level(-1.0, 65_535), 0);
        assert_eq!(range.level(0.0, 65_535), 1);
        assert!(range.depth(0.0, 65_535.0).is_nan());
        let open = LevelRange { zero_is_unknown: false, ..range };
        assert_eq!(open.level(0.0, 65_535), 0);
        assert_eq!(open.depth(0.0, 65_535.0), f32::INFINITY);
    }

    #[test]
    fn a_depth_buffer_is_sky_at_its_far_plane_and_holds_nothing_at_its_near_one() {
        let normal = LevelRange { near: 0.5, far: 8.0, order: LevelOrder::ZBuffer, zero_is_unknown: false };
        let reversed = LevelRange { order: LevelOrder::ReversedZBuffer, ..normal };
        for z in [0.6_f64, 1.0, 4.0, 7.5] {
            let value = (8.0 / (8.0 - 0.5) * (1.0 - 0.5 / z)) as f32;
            assert!((f64::from(normal.depth(value, 1.0)) - z).abs() < 1e-5 * z, "{z}");
            assert!((f64::from(reversed.depth(1.0 - value, 1.0)) - z).abs() < 1e-5 * z, "{z}");
        }
        assert_eq!((normal.depth(1.0, 1.0), reversed.depth(0.0, 1.0)), (f32::INFINITY, f32::INFINITY));
        for range in [normal, reversed] {
            for outside in [-0.1, 1.1, f32::NAN] {
                assert!(range.depth(outside, 1.0).is_nan(), "{outside}");
            }
        }
        assert!(normal.depth(0.0, 1.0).is_nan() && reversed.depth(1.0, 1.0).is_nan());
    }

    /// Bytes of any kind give a picture or an error, and no depth that is below the near plane.
    #[test]
    fn arbitrary_bytes_give_pictures_or_errors() {
        let mut state = 1_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize
        };
        let file = tempfile::NamedTempFile::new().unwrap();
        for _ in 0..300 {
            let format = PixelFormat { bits: 8 + (next() % 9) as u32, has_chroma: next().is_multiple_of(2) };
            let size = (1 + next() % 9, 1 + next() % 9);
            let bytes: Vec<u8> = (0..next() % 400).map(|_| next() as u8).collect();
            std::fs::write(file.path(), &bytes).unwrap();
            let index = (next() % 3) as u64;
            let yuv = YuvFile::new(file.path(), "test", format, size);
            let fits = bytes.len() as u64 >= (index + 1) * format.picture_bytes(size);
            let zero_is_unknown = next().is_multiple_of(2);
            let range =
                LevelRange { near: 0.5, far: f64::INFINITY, order: LevelOrder::FromFar, zero_is_unknown };
            let (color, depth) = (yuv.color(index, ColorMatrix::default()), yuv.depth(index, &range));
            assert_eq!((color.is_ok(), depth.is_ok()), (fits, fits));
            if let (Ok(color), Ok(depth)) = (color, depth) {
                assert!(color.iter().flatten().all(|value| (0.0..=1.0).contains(value)));
                assert_eq!((color[0].len(), depth.len()), (size.0 * size.1, size.0 * size.1));
            }
        }
    }
}
