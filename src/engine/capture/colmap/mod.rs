//! COLMAP's reconstructions: cameras and images, as text or binary.
//!
//! Source: COLMAP's documentation (`doc/format.rst`) and `sensor/models.h`. An image's pose is world to camera; x right, y down,
//! z forward; quaternions have w first; pixel centers lie at +0.5. Numbers of binary files have their least significant byte first.
//! Points, rigs and frames are not read: images name everything that is needed.

mod binary;
mod lens_model;
mod model;
mod text;

pub use binary::{cameras_of_bytes, images_of_bytes};
pub use lens_model::LensModel;
pub use model::{ColmapCamera, ColmapImage};
pub use text::{cameras_of_text, images_of_text};
