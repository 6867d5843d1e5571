//! Where a store comes from: `PROV`, as JSON.

use serde::{Deserialize, Serialize};

/// Where a store comes from. What is not known is left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Provenance {
    /// Program and version that wrote the store.
    pub program: String,
    /// The files that were read.
    pub inputs: Option<InputFiles>,
    /// Whether frames are numbered by the order of times that are fractions, so that a view's time of 1 may mean another frame.
    pub frames_are_ranked: bool,
    /// What each plane of the samples takes in the store, bytes; filled in by the writer, except where samples are coded plainly.
    pub planes: Option<PlaneBytes>,
}

/// Bytes of the store, by what they hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PlaneBytes {
    /// Which pixels hold a sample.
    pub mask: u64,
    /// Inverse depth.
    pub depth: u64,
    /// Green, coded before red and blue.
    pub green: u64,
    /// Red.
    pub red: u64,
    /// Blue.
    pub blue: u64,
    /// Normals.
    pub normals: u64,
}

impl PlaneBytes {
    /// From the bits of the seven planes in their order.
    pub(crate) fn of_bits(bits: [f64; 7]) -> Self {
        let [mask, depth, green, red, blue, normal_x, normal_y] = bits;
        let bytes = |bits: f64| (bits / 8.0).round() as u64;
        Self {
            mask: bytes(mask),
            depth: bytes(depth),
            green: bytes(green),
            red: bytes(red),
            blue: bytes(blue),
            normals: bytes(normal_x + normal_y),
        }
    }
}

impl Default for Provenance {
    fn default() -> Self {
        Self {
            program: concat!("overlook ", env!("CARGO_PKG_VERSION")).to_owned(),
            inputs: None,
            frames_are_ranked: false,
            planes: None,
        }
    }
}

/// The files of a capture, as far as it takes to see whether they changed.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct InputFiles {
    /// How many.
    pub files: u64,
    /// Bytes of all of them.
    pub bytes: u64,
    /// CRC-32 of the list of every file's name, size and CRC-32, one a line, as `{crc:08x} {bytes} {name}`, sorted by name.
    pub crc32: u32,
}
