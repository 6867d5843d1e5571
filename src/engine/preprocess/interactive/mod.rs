//! Pruning one frame again and again while a threshold changes.
//!
//! ```text
//! prepared frame (layers of all levels) ─▶ build lists: candidates of every sample ─▶ replay per setting ─▶ verdicts
//! ```

mod build_lists;
mod candidate_lists;
mod prepared_frame;
mod replay;

pub use prepared_frame::FrameLayers;
pub(crate) use prepared_frame::{CameraPlanes, FrameVerdicts};
