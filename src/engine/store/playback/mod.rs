//! A store played from disk.

mod player;
mod verify;

pub use player::{DEFAULT_CACHE_BYTES, Playback};
pub use verify::{Verification, verify};
