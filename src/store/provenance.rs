//! Where a store comes from, and what it is measured against: `PROV`, as JSON.

use serde::{Deserialize, Serialize};

/// Where a store comes from. What is not known is left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Provenance {
    /// Program and version that wrote the store.
    pub program: String,
    /// The files that were read.
    pub inputs: Option<InputFiles>,
    /// What the same pictures take in other forms.
    pub rivals: Option<Rivals>,
}

impl Default for Provenance {
    fn default() -> Self {
        Self {
            program: concat!("overlook ", env!("CARGO_PKG_VERSION")).to_owned(),
            inputs: None,
            rivals: None,
        }
    }
}

/// The files of a capture, as far as it takes to tell whether they are still the same.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct InputFiles {
    /// How many.
    pub files: u64,
    /// Bytes of all of them.
    pub bytes: u64,
    /// CRC-32 of the list of every file's name, size and CRC-32, one a line, as `{crc:08x} {bytes} {name}`, sorted by name.
    pub crc32: u32,
}

/// Bytes that the input pictures take in other lossless forms, all cameras and frames together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Rivals {
    /// EXR with half-float color and 32-bit depth, ZIP.
    pub zip_exr: u64,
    /// Color in 8-bit sRGB as lossless H.264 (x264, RGB), where there was an ffmpeg.
    pub video_color: Option<u64>,
    /// Inverse depth in 16 bits as FFV1, where there was an ffmpeg.
    pub video_depth: Option<u64>,
}
