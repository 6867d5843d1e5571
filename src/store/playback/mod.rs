//! A store played from disk.

mod playback;
mod verify;

pub use playback::{DEFAULT_CACHE_BYTES, Playback};
pub use verify::{Verification, verify};
