//! Noise: how much the same surface differs from frame to frame, measured on a few pairs of frames.

mod between_cameras;
mod block_motion;
mod estimate;
mod frame_pairs;
mod range_distribution;
mod rank;

pub(crate) use between_cameras::{DEPTH_CLASSES, NoiseBetween, depth_class, depth_of_class};
pub(crate) use estimate::brightness_bin;
pub use estimate::{BRIGHTNESS_BINS, CameraNoise, measure_pairs};
pub(crate) use frame_pairs::NoiseFrames;
pub use range_distribution::granted_range_sigmas;
pub(crate) use rank::{bin_of_rank, rank_of_share};
