//! Which views see the same.
//!
//! ```text
//! cameras + what each saw, as bounds of depth, block by block ─▶ graph of those that may see the same ─▶ groups of neighbors
//! points of each view ─ looked for in the others ─▶ pairs by the share that is seen
//! ```
//!
//! Purpose: the one place that says which views are compared with which. Frusta reject exactly, and cheaply; where pictures are at hand,
//! shared points tell how much is seen. Two callers know neither: whoever doubts how poses are read pairs views by their numbers
//! (`pairs_by_number`), and lines of sight of a new view ask the cameras nearest to it (`nearest_first`).

mod graph;
mod groups;
mod registration;
mod shared;

pub use graph::{DepthBounds, OverlapGraph};
pub(crate) use groups::{Neighbors, nearest_first};
pub(crate) use registration::{Registration, TargetLens, relative_side};
pub(crate) use shared::{pairs_by_number, pairs_by_share, share_seen};
