//! Pictures of color, depth, confidence and masks in other files than `OpenEXR`, and what lenses do to them.
//!
//! ```text
//! bytes ─ raster (PNG, JPEG, TIFF) ─┐
//!       ─ pgm, npy, colmap_map ─────┼─ depth_map ─ confidence ─ registration (into the color camera's pixels)
//!                                   └─ color, mask ─ resample (lens distortion undone)
//! ```

mod colmap_map;
mod confidence;
mod depth_map;
mod distortion;
mod format;
mod npy;
mod pgm;
mod raster;
mod registration;
mod resample;
mod surface_mesh;

pub(crate) use colmap_map::read as read_colmap_map;
pub use colmap_map::{ColmapMap, parse as parse_colmap_map};
pub(crate) use confidence::drop_unsure;
pub(crate) use depth_map::DepthMap;
pub use depth_map::depth_size;
pub(crate) use distortion::Distortion;
pub(crate) use format::{PICTURE_EXTENSIONS, PictureFormat, format_of};
pub use npy::{NpyArray, parse as parse_npy};
pub use pgm::parse as parse_pgm;
pub(crate) use raster::{check, color, gray, has_alpha, size};
pub(crate) use registration::{DepthGrid, RayCache, register};
pub(crate) use resample::{Sources, sources};
