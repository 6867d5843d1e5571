//! Formats of raw video, by the names that ffmpeg gives them.

use crate::error::{Error, Result};

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

#[cfg(test)]
mod tests {
    use super::*;

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
}
