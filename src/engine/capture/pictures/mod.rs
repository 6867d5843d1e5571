//! Pictures of color, depth, confidence and masks in other files than `OpenEXR`, and what lenses do to them.
//!
//! ```text
//! bytes ─ raster, tiff_samples ──────┐
//!       ─ pgm, pfm, npy, colmap_map ┼─ depth_map ─ confidence ─ registration (into the color camera's pixels)
//!                                   └─ color, mask ─ resample (lens distortion undone)
//! ```

mod colmap_map;
mod color_tags;
mod depth_map;
mod distortion;
mod format;
mod mask;
mod npy;
mod pfm;
mod pgm;
mod raster;
mod registration;
mod resample;
mod surface_mesh;
mod tiff_samples;
mod turned;

pub(crate) use colmap_map::read as read_colmap_map;
pub use colmap_map::{ColmapMap, parse as parse_colmap_map};
pub use depth_map::depth_size;
pub(crate) use depth_map::{DepthMap, drop_unsure};
pub(crate) use distortion::Distortion;
pub(crate) use format::{PICTURE_EXTENSIONS, PictureFormat, format_of};
pub(crate) use mask::mask;
pub use npy::{NpyArray, parse as parse_npy};
pub use pfm::parse as parse_pfm;
pub use pgm::parse as parse_pgm;
pub(crate) use raster::{ColorReading, check, color, gray, has_alpha, is_open, size, size_of_rows};
pub(crate) use registration::{DepthGrid, RayCache, register};
pub(crate) use resample::{Sources, sources};
pub(crate) use turned::PictureRows;
