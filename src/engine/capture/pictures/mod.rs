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
mod npy;
mod pfm;
mod pgm;
mod raster;
mod registration;
mod tiff_samples;
mod turned;

use std::path::Path;

use crate::error::{Error, Result};
pub(crate) use colmap_map::read as read_colmap_map;
pub use colmap_map::{ColmapMap, parse as parse_colmap_map};
pub use depth_map::depth_size;
pub(crate) use depth_map::{DepthMap, drop_unsure};
pub(crate) use distortion::{Distortion, Sources, sources};
pub use npy::{NpyArray, parse as parse_npy};
pub use pfm::parse as parse_pfm;
pub use pgm::parse as parse_pgm;
pub(crate) use raster::{ColorReading, check, color, gray, has_alpha, is_open, size, size_of_rows};
pub(crate) use registration::{DepthGrid, RayCache, register};
pub(crate) use turned::PictureRows;

/// What pictures may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PictureFormat {
    /// `OpenEXR`.
    Exr,
    /// PNG.
    Png,
    /// JPEG: color alone.
    Jpeg,
    /// TIFF: color or depth, in floats or whole numbers.
    Tiff,
    /// PGM: depth in 16 bits.
    Pgm,
    /// Netpbm's floats: depth alone.
    Pfm,
    /// An array of `NumPy`: depth alone.
    Npy,
    /// A map of COLMAP's: depth or normals alone.
    ColmapMap,
    /// Raw video, which the manifest describes.
    Yuv,
}

/// Endings of pictures that may be left out where a manifest names them.
pub(crate) const PICTURE_EXTENSIONS: [&str; 12] =
    ["exr", "png", "jpg", "jpeg", "tif", "tiff", "EXR", "PNG", "JPG", "JPEG", "TIF", "TIFF"];

/// The format of a file, by its ending.
pub(crate) fn format_of(path: &Path, place: &str) -> Result<PictureFormat> {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    match ending.as_str() {
        "exr" => Ok(PictureFormat::Exr),
        "png" => Ok(PictureFormat::Png),
        "jpg" | "jpeg" => Ok(PictureFormat::Jpeg),
        "tif" | "tiff" => Ok(PictureFormat::Tiff),
        "pgm" => Ok(PictureFormat::Pgm),
        "pfm" => Ok(PictureFormat::Pfm),
        "npy" => Ok(PictureFormat::Npy),
        "yuv" => Ok(PictureFormat::Yuv),
        "bin" => Ok(PictureFormat::ColmapMap),
        "npz" => Err(Error::unsupported(
            place,
            "archives of NumPy (.npz) are not read; save the array by itself as .npy (numpy.save), or as EXR",
        )),
        other => Err(Error::unsupported(
            place,
            format!(
                "files of type '{other}' are not read; save color as EXR, PNG, TIFF or JPEG, and depth as EXR, 16-bit PNG, TIFF or .npy"
            ),
        )),
    }
}
