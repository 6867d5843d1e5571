//! Temporal redundancy (the paper, §3.2): the longest spans of frames over which each pixel stays the same.

mod batch_split;
mod pixel_stats;
mod prefilter;
mod range_histogram;
mod scan;
mod span_store;
mod span_tree;
mod staticness;
mod tree_split;
mod two_level;
mod value_ranges;

pub use batch_split::BATCH;
pub(crate) use pixel_stats::SpanSums;
pub use range_histogram::{RangeFacts, RangeHistogram};
pub(crate) use scan::{CameraPreview, SIDE_BY_SIDE, ScannedRun, preview, scan_run};
pub use scan::{CameraScan, TemporalScan, scan};
pub use span_store::{SpanSamples, SpanStore};
pub use span_tree::{NO_SAMPLE, PixelClass, ROOT, SpanLevel, SpanTree, all_frames};
pub use staticness::StaticTest;
pub(crate) use tree_split::OpenSums;
pub use tree_split::{FinishedSpans, Split};
pub use two_level::SequenceRanges;
