//! Pruning one frame again and again while a threshold is turned.

mod build_lists;
mod candidate;
mod candidate_lists;
mod prepared_frame;
mod replay;

pub(crate) use prepared_frame::{CameraPlanes, FrameLayers, FrameVerdicts};
