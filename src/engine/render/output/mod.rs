//! What is read from a finished picture.

mod exr;
mod pick;
mod png;

pub use exr::write_exr;
pub use pick::{PickedSample, pick};
pub use png::write_png;
