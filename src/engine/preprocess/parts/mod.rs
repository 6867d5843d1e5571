//! Preprocessing cut by runs of frames, for several machines; what is joined is bit for bit what one piece gives.
//!
//! ```text
//! capture ─ Measured (once: what the rig got wrong, noise) ─▶ scan_part (of each run of frames) ─▶ join_spans (spans longer than a run)
//!                                                                     └───────┬────────────────────────┘
//!                                                         prune_part (of each run) ─▶ join_pruned ─▶ samples and report
//! ```
//!
//! Only the tree of spans is cut: a run is made of whole spans of the tree, so that what is known of it at its end (range and sum of
//! every pixel over each of them) is all that longer spans need. Sums are exact and counts are whole numbers, so that nothing depends
//! on where runs begin. A span that reaches over several runs is decided in each of them, and counted in the one that it begins in.

mod join_pruned;
mod join_spans;
mod measured;
mod prune_part;
mod runs;
mod scan_part;

pub use join_pruned::join_pruned;
pub use join_spans::join_spans;
pub use measured::{Measured, MeasuredCapture};
pub use prune_part::{prune_part, scan_parts_read_by};
pub use runs::run_of_part;
pub use scan_part::scan_part;
