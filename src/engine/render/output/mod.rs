//! What is read from a finished picture.

mod pick;
mod png;

pub use pick::{PickedSample, pick};
pub use png::write_png;
