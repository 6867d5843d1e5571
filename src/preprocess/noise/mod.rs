//! How noisy a capture is over time.

mod block_motion;
mod estimate;
mod frame_pairs;
mod range_distribution;

pub(crate) use estimate::brightness_bin;
pub use estimate::{BRIGHTNESS_BINS, CameraNoise, measure_pairs};
pub(crate) use frame_pairs::NoiseFrames;
pub use range_distribution::granted_range_sigmas;
