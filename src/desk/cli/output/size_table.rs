//! Bytes of a store stage by stage.

use std::fmt::Write;

use serde::Serialize;

use super::text;
use overlook_engine::preprocess::diagnostics::{Report, STATIC_RULE};
use overlook_engine::store::file::{PlaneBytes, StoreInfo};

/// Bytes of a raw pixel: 8-bit color and 32-bit depth.
const RAW_PIXEL: u64 = 3 + 4;

/// Bytes after each stage.
#[derive(Debug, Serialize)]
pub(crate) struct Sizes {
    /// All input pixels, 8-bit color and 32-bit depth.
    raw: u64,
    /// Bytes without pixels that have no depth and without repetitions in time.
    after_time: u64,
    /// Bytes without redundancy between cameras as well.
    after_pruning: u64,
    /// The kept samples in memory.
    memory: u64,
    /// The images in the store.
    images: u64,
    /// The store.
    store: u64,
    /// The images in the store, by what they hold.
    planes: Option<PlaneBytes>,
    ratios: Ratios,
}

/// The store's bytes beside the input's.
#[derive(Debug, Serialize)]
struct Ratios {
    /// As a share of the raw bytes.
    raw: f64,
    /// Bytes of the store for every input pixel.
    bytes_per_pixel: f64,
}

impl Sizes {
    pub(crate) fn of(info: &StoreInfo, report: &Report) -> Self {
        let repeated = report.pruned.get(STATIC_RULE).copied().unwrap_or(0);
        let distinct = report.samples_in.saturating_sub(report.without_depth()).saturating_sub(repeated);
        let store = info.bytes;
        let share = |of: u64| store as f64 / of.max(1) as f64;
        Self {
            raw: report.bytes_raw,
            after_time: distinct * RAW_PIXEL,
            after_pruning: report.samples_kept * RAW_PIXEL,
            memory: report.bytes_memory,
            images: info.images.iter().map(|image| u64::from(image.length)).sum(),
            store,
            planes: info.provenance.planes,
            ratios: Ratios { raw: share(report.bytes_raw), bytes_per_pixel: share(report.samples_in) },
        }
    }

    pub(crate) fn text(&self) -> String {
        let mut text = String::new();
        let of_raw = |bytes| text::percent(bytes, self.raw);
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
        ] {
            if let Some(bytes) = bytes {
                let _ = writeln!(text, "  {:>12}  {:>7} of raw  {name}", text::bytes(bytes), of_raw(bytes));
            }
        }
        text
    }
}
