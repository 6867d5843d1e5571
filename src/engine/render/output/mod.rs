//! What is read from a finished picture.

mod exr;
mod pick;
mod png;
mod values;

pub use exr::write_exr;
pub use pick::{PickedSample, pick};
pub use png::write_png;
pub use values::{PictureValues, shown_values, write_exr_with_values, write_npy, write_value_png};
