//! A store played from disk.

mod playback;
mod visible_blocks;

pub use playback::{DEFAULT_CACHE_BYTES, Playback};
pub(crate) use visible_blocks::VisibleBlocks;
