//! Captures on disk for tests: EXR pictures of any channels, written by the `exr` crate, and manifests beside them.

#![expect(clippy::unwrap_used, reason = "a fixture that cannot be made fails the test")]

pub(crate) use crate::folder::Folder;

use std::io::Cursor;

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, ImageAttributes, IntegerBounds, Layer,
    LayerAttributes, Layers, WritableImage,
};
use overlook_engine::capture::{Capture, transforms};
use overlook_engine::error::Result;
use overlook_engine::settings::CaptureSettings;
use serde_json::{Value, json};

/// Columns and rows of the pictures.
pub(crate) const SIZE: (usize, usize) = (6, 4);
/// Their pixels.
pub(crate) const PIXELS: usize = SIZE.0 * SIZE.1;

/// A channel that has the same `f32` value everywhere.
pub(crate) fn flat(value: f32) -> FlatSamples {
    FlatSamples::F32(vec![value; PIXELS])
}

/// A plain picture: `R G B` of one gray and the given depth.
pub(crate) fn plain(depth: FlatSamples) -> Vec<u8> {
    picture(&[("", vec![("R", flat(0.5)), ("G", flat(0.5)), ("B", flat(0.5)), ("Z", depth)])])
}

/// The bytes of an EXR file with these parts, each a name and its channels.
pub(crate) fn picture(parts: &[(&str, Vec<(&str, FlatSamples)>)]) -> Vec<u8> {
    let layers: Layers<AnyChannels<FlatSamples>> = parts
        .iter()
        .map(|(name, channels)| {
            let list = channels.iter().map(|(name, samples)| AnyChannel::new(*name, samples.clone()));
            let attributes =
                if name.is_empty() { LayerAttributes::default() } else { LayerAttributes::named(*name) };
            Layer::new(SIZE, attributes, Encoding::SMALL_LOSSLESS, AnyChannels::sort(list.collect()))
        })
        .collect();
    let window = ImageAttributes::new(IntegerBounds::from_dimensions(SIZE));
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layers(window, layers).write().non_parallel().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

/// A manifest's entry: a camera at the origin that looks along +y with z up, 90° wide.
pub(crate) fn entry(file_path: &str, camera: &str, time: i64) -> Value {
    json!({
        "file_path": file_path, "camera": camera, "time": time,
        "w": SIZE.0, "h": SIZE.1, "fl_x": 3.0,
        "transform_matrix": [[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]],
    })
}

impl Folder {
    /// Writes the manifest, `keys` being those of the file, and opens the capture.
    pub(crate) fn open(&self, mut keys: Value, entries: &[Value]) -> Result<Capture> {
        keys["frames"] = entries.into();
        self.put("transforms.json", keys.to_string().as_bytes());
        transforms::open(&self.path(""), &CaptureSettings::default())
    }
}
