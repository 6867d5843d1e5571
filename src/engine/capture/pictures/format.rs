//! Formats of pictures, by the endings of their names.

use std::path::Path;

use crate::error::{Error, Result};

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
