//! Raw planar video (`.yuv`): pictures one after the other, without a header.
//!
//! Size and format are in the file's name or in the manifest. Planes follow each other: all of luma, then, halved both ways, U and V.
//! Samples of more than 8 bits are little-endian 16-bit words, low-aligned.
//!
//! Source of colors: ITU-R BT.601 and BT.709. RVS, MPEG's reference view synthesizer, takes Y′CbCr for BT.601 over the full range of
//! numbers, as `OpenCV` does; cameras and broadcasters write BT.709 over a limited range. The manifest's `yuv_color` decides.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use super::depth_claim::DepthPlanes;
use crate::color::linear_from_srgb;
use crate::error::{Error, Result};

/// Weights and range of Y′CbCr.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ColorMatrix {
    /// Weights of red and blue in luma.
    red: f32,
    blue: f32,
    /// Whether numbers run from 16/255 to 235/255 (240/255 for color).
    is_limited: bool,
}

impl Default for ColorMatrix {
    /// That of RVS.
    fn default() -> Self {
        Self { red: 0.299, blue: 0.114, is_limited: false }
    }
}

impl ColorMatrix {
    /// Names that the manifest knows.
    pub(crate) const NAMES: &str = "bt601_full, bt601_limited, bt709_full, bt709_limited";

    /// The matrix by its name in the manifest.
    pub(crate) fn from_name(name: &str) -> Option<Self> {
        let (weights, range) = name.split_once('_')?;
        let (red, blue) = match weights {
            "bt601" => (0.299, 0.114),
            "bt709" => (0.2126, 0.0722),
            _ => return None,
        };
        let is_limited = match range {
            "full" => false,
            "limited" => true,
            _ => return None,
        };
        Some(Self { red, blue, is_limited })
    }

    /// Encoded red, green and blue of luma and color, all 0 to 1, color 0.5 for gray.
    pub(crate) fn rgb(self, [y, u, v]: [f32; 3]) -> [f32; 3] {
        let (y, u, v) = if self.is_limited {
            ((y * 255.0 - 16.0) / 219.0, (u * 255.0 - 128.0) / 224.0, (v * 255.0 - 128.0) / 224.0)
        } else {
            (y, u - 0.5, v - 0.5)
        };
        let red = y + 2.0 * (1.0 - self.red) * v;
        let blue = y + 2.0 * (1.0 - self.blue) * u;
        let green = (y - self.red * red - self.blue * blue) / (1.0 - self.red - self.blue);
        [red, green, blue].map(|value| value.clamp(0.0, 1.0))
    }
}

/// The layout of a picture's samples in a raw video file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PixelFormat {
    /// Bits of a sample: 8 to 16.
    pub bits: u32,
    /// Whether two planes of color at half the columns and rows follow luma (4:2:0); else there is luma alone.
    pub has_chroma: bool,
}

impl PixelFormat {
    /// The format by ffmpeg's name: `yuv420p`, `yuv420p10le`, `gray`, `gray16le` … and MPEG's `yuv400p16le`.
    pub(crate) fn from_name(name: &str) -> Option<Self> {
        let (rest, has_chroma) = ["yuv420p", "yuv400p", "gray"]
            .iter()
            .find_map(|start| Some((name.strip_prefix(start)?, *start == "yuv420p")))?;
        let bits = match rest {
            "" => 8,
            _ => rest.strip_suffix("le")?.parse().ok().filter(|bits| (9..=16).contains(bits))?,
        };
        Some(Self { bits, has_chroma })
    }

    /// ffmpeg's name.
    pub(crate) fn name(self) -> String {
        let start = if self.has_chroma { "yuv420p" } else { "gray" };
        if self.bits == 8 { start.to_owned() } else { format!("{start}{}le", self.bits) }
    }

    /// The largest sample.
    pub(crate) fn largest(self) -> u16 {
        ((1_u32 << self.bits) - 1) as u16
    }

    /// Bytes of a sample.
    pub(crate) fn sample_bytes(self) -> usize {
        if self.bits > 8 { 2 } else { 1 }
    }

    /// Columns and rows of a plane of color.
    pub(crate) fn chroma_size(size: (usize, usize)) -> (usize, usize) {
        (size.0.div_ceil(2), size.1.div_ceil(2))
    }

    /// Bytes of a picture.
    pub(crate) fn picture_bytes(self, size: (usize, usize)) -> u64 {
        let (columns, rows) = Self::chroma_size(size);
        let chroma = if self.has_chroma { 2 * columns * rows } else { 0 };
        (size.0 * size.1 + chroma) as u64 * self.sample_bytes() as u64
    }

    /// A format that the manifest's `key` names.
    ///
    /// # Errors
    /// `Unsupported` for one that is not read.
    pub(crate) fn of_key(key: &str, name: &str, place: &str) -> Result<Self> {
        Self::from_name(name).ok_or_else(|| {
            let what = format!(
                "{key} '{name}' is not read; there are yuv420p and gray, with 9 to 16 bits as in yuv420p10le"
            );
            Error::unsupported(place, what)
        })
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_matrix_gives_white_black_and_gray_without_color() {
        for name in ColorMatrix::NAMES.split(", ") {
            let matrix = ColorMatrix::from_name(name).unwrap();
            let luma = |value: f32| if matrix.is_limited { (value * 219.0 + 16.0) / 255.0 } else { value };
            let middle = if matrix.is_limited { 128.0 / 255.0 } else { 0.5 };
            for value in [0.0, 0.4, 1.0] {
                let rgb = matrix.rgb([luma(value), middle, middle]);
                assert!(rgb.iter().all(|found| (found - value).abs() < 1e-5), "{name} {value} {rgb:?}");
            }
        }
        assert_eq!(ColorMatrix::from_name("bt601_full"), Some(ColorMatrix::default()));
        assert!(ColorMatrix::from_name("bt2020_full").is_none() && ColorMatrix::from_name("bt601").is_none());
    }

    #[test]
    fn the_weights_are_the_published_ones() {
        // BT.601: R = Y + 1.402 Cr, B = Y + 1.772 Cb, G = Y − 0.344136 Cb − 0.714136 Cr.
        let rgb = ColorMatrix::default().rgb([0.5, 0.6, 0.4]);
        for (value, expected) in rgb.iter().zip([0.5 - 0.1402, 0.5 - 0.034_413_6 + 0.071_413_6, 0.5 + 0.1772])
        {
            assert!((value - expected).abs() < 1e-5, "{rgb:?}");
        }
    }

    #[test]
    fn formats_have_the_names_of_ffmpeg_and_the_sizes_of_their_planes() {
        for (name, bits, has_chroma, bytes) in [
            ("yuv420p", 8, true, 24),
            ("yuv420p10le", 10, true, 48),
            ("yuv420p16le", 16, true, 48),
            ("gray", 8, false, 16),
            ("yuv400p16le", 16, false, 32),
        ] {
            let format = PixelFormat::from_name(name).unwrap();
            assert_eq!(format, PixelFormat { bits, has_chroma }, "{name}");
            assert_eq!(format.picture_bytes((4, 4)), bytes, "{name}");
            assert_eq!(PixelFormat::from_name(&format.name()), Some(format));
        }
        for name in ["yuv422p", "yuv420p7le", "yuv420p10be", "yuv420p17le", "nv12", ""] {
            assert_eq!(PixelFormat::from_name(name), None, "{name}");
        }
    }

    /// The samples of a picture of 8×6 pixels are written as the format says: luma, then U and V of blocks of 2×2 pixels.
    #[test]
    fn the_second_picture_of_a_file_has_its_colors() {
        let format = PixelFormat { bits: 10, has_chroma: true };
        let luma = (0..48).map(|index| 400 + 10 * (index % 8));
        let samples: Vec<u16> = luma.chain([600; 12]).chain([450; 12]).collect();
        let one: Vec<u8> = samples.iter().flat_map(|sample| sample.to_le_bytes()).collect();
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), [vec![9; one.len()], one].concat()).unwrap();
        let yuv = YuvFile::new(file.path(), "test", format, (8, 6));
        let read = yuv.color(1, ColorMatrix::default()).unwrap();
        for index in 0..48 {
            let expected =
                ColorMatrix::default().rgb([f32::from(samples[index]), 600.0, 450.0].map(|it| it / 1023.0));
            for (plane, expected) in read.iter().zip(expected) {
                assert!((plane[index] - linear_from_srgb(expected)).abs() < 1e-6, "{index}");
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
    }

    #[test]
    fn what_has_no_depth_and_what_is_at_infinity_stay_apart() {
        let range =
            LevelRange { near: 0.5, far: f64::INFINITY, order: LevelOrder::FromFar, zero_is_unknown: true };
        assert!(range.depth(0.0, 65_535.0).is_nan());
        let open = LevelRange { zero_is_unknown: false, ..range };
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
