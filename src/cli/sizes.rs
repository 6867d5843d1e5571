//! Bytes of a store stage by stage, and beside other forms of the same pictures.

use std::fmt::Write;

use serde::Serialize;

use super::output;
use crate::preprocess::report::STATIC_RULE;
use crate::store::{PlaneBytes, StoreInfo};

/// Bytes of a raw pixel: 8-bit color and 32-bit depth.
const RAW_PIXEL: u64 = 3 + 4;

/// Bytes after each stage, and of what the stages are measured against.
#[derive(Debug, Serialize)]
pub(super) struct Sizes {
    /// All input pixels, 8-bit color and 32-bit depth.
    raw: u64,
    /// The same of what is left without pixels that have no depth and without repetitions in time.
    after_time: u64,
    /// The same of what is left without redundancy between cameras.
    after_pruning: u64,
    /// The kept samples in memory.
    memory: u64,
    /// The images in the store.
    images: u64,
    /// The store.
    store: u64,
    /// ZIP EXR of the same channels, where preprocessing measured it.
    zip_exr: Option<u64>,
    /// Lossless video, color and depth, where preprocessing measured it.
    lossless_video: Option<u64>,
    /// Each frame xor the one before, by zstd, where preprocessing measured it.
    xor_zstd: Option<u64>,
    /// The images in the store, by what they hold.
    planes: Option<PlaneBytes>,
    ratios: Ratios,
}

/// The store's bytes, as a share of others.
#[derive(Debug, Serialize)]
struct Ratios {
    raw: f64,
    zip_exr: Option<f64>,
    lossless_video: Option<f64>,
    xor_zstd: Option<f64>,
    /// Bytes of the store for every input pixel.
    bytes_per_pixel: f64,
}

impl Sizes {
    pub(super) fn of(info: &StoreInfo) -> Self {
        let report = &info.report;
        let repeated = report.pruned.get(STATIC_RULE).copied().unwrap_or(0);
        let distinct = report.samples_in.saturating_sub(report.without_depth()).saturating_sub(repeated);
        let rivals = info.provenance.rivals;
        let zip_exr = rivals.map(|rivals| rivals.zip_exr);
        let lossless_video = rivals.and_then(|rivals| Some(rivals.video_color? + rivals.video_depth?));
        let xor_zstd = rivals.and_then(|rivals| rivals.xor_zstd);
        let store = info.bytes;
        let share = |of: u64| store as f64 / of.max(1) as f64;
        Self {
            raw: report.bytes_raw,
            after_time: distinct * RAW_PIXEL,
            after_pruning: report.samples_kept * RAW_PIXEL,
            memory: report.bytes_memory,
            images: info.images.iter().map(|image| u64::from(image.length)).sum(),
            store,
            zip_exr,
            lossless_video,
            xor_zstd,
            planes: info.provenance.planes,
            ratios: Ratios {
                raw: share(report.bytes_raw),
                zip_exr: zip_exr.map(share),
                lossless_video: lossless_video.map(share),
                xor_zstd: xor_zstd.map(share),
                bytes_per_pixel: share(report.samples_in),
            },
        }
    }

    pub(super) fn text(&self) -> String {
        let mut text = String::new();
        let of_raw = |bytes| output::percent(bytes, self.raw);
        for (name, bytes) in [
            ("raw", Some(self.raw)),
            ("without repetition in time", Some(self.after_time)),
            ("without redundancy between cameras", Some(self.after_pruning)),
            ("in memory", Some(self.memory)),
            ("in the store", Some(self.store)),
            ("  of that, which pixels hold a sample", self.planes.map(|planes| planes.mask)),
            ("  of that, depth", self.planes.map(|planes| planes.depth)),
            (
                "  of that, green, red and blue",
                self.planes.map(|planes| planes.green + planes.red + planes.blue),
            ),
            ("  of that, normals", self.planes.map(|planes| planes.normals).filter(|bytes| *bytes > 0)),
            ("as ZIP EXR", self.zip_exr),
            ("as lossless video", self.lossless_video),
            ("as differences of frames, by zstd", self.xor_zstd),
        ] {
            if let Some(bytes) = bytes {
                let _ = writeln!(text, "  {:>12}  {:>7} of raw  {name}", output::bytes(bytes), of_raw(bytes));
            }
        }
        text
    }
}
