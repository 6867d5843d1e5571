//! Readers: what a folder or file is, and the manifest that it amounts to.
//!
//! ```text
//! path ─ SourceFolder (names) ─ the first reader that recognizes it ─ ReadSource: Manifest, ManifestOrigin, Description
//! ```
//!
//! A reader is a [`Reader`] in a file or folder here, and is listed in [`READERS`]. It knows one source's layout, axes, units and quirks.
//! It knows nothing of pictures' bytes: the manifest's keys describe them.

mod cinema;
mod colmap;
mod convertible;
mod easymocap;
mod exr_header;
mod isaac;
mod kubric;
mod livescan3d;
mod miv;
mod msr;
mod nerfstudio;
mod place;
mod polycam;
mod posed_folder;
mod poses_by_name;
mod poses_by_order;
mod poses_by_time;
mod reader;
mod record3d;
mod scanner_app;
mod text;
mod views;

pub(crate) use place::SourceFolder;
pub use reader::Description;
pub(crate) use reader::{ReadSource, Reader, SaidBy};

use std::path::Path;

use crate::capture::transforms::other_file;
use crate::error::{Error, Result};

/// All readers, in the order in which they are tried. A manifest comes first: it is what users correct by hand.
const READERS: &[Reader] = &[
    nerfstudio::NERFSTUDIO,
    colmap::COLMAP,
    record3d::RECORD3D,
    polycam::POLYCAM,
    scanner_app::SCANNER_APP,
    miv::MIV,
    poses_by_time::TUM,
    livescan3d::LIVESCAN3D,
    poses_by_order::REDWOOD,
    poses_by_name::SEVEN_SCENES,
    poses_by_name::SCANNET,
    poses_by_name::REPLICA,
    poses_by_order::POSE_LIST,
    poses_by_name::BOP,
    isaac::ISAAC,
    kubric::KUBRIC,
    msr::MSR,
    easymocap::EASYMOCAP,
    cinema::CINEMA,
    exr_header::EXR_HEADER,
];

/// How the error of a folder that holds no capture begins.
pub const NO_CAPTURE: &str = "there is no capture that is known";

/// What a folder or file of each source is known by, in the order in which it is looked for.
pub fn known_sources() -> impl Iterator<Item = &'static str> {
    READERS.iter().map(|reader| reader.marks)
}

/// Finds out what `path` is, and reads it.
///
/// # Errors
/// `Io` where it is not there, `Unsupported` where another program has to convert it first, `Invalid` where nothing is
/// recognized, and whatever its reader gives.
pub(crate) fn read(path: &Path) -> Result<ReadSource> {
    let place = SourceFolder::look(path)?;
    if let Some(reader) = READERS.iter().find(|reader| reader.recognizes(&place)) {
        return reader.read(&place);
    }
    if let Some(refused) = convertible::advice(&place) {
        return Err(refused);
    }
    Err(unknown(&place))
}

/// The error of a place that no reader recognizes.
fn unknown(place: &SourceFolder) -> Error {
    if place.file.is_some()
        && let Ok(Some(what)) = other_file(&place.path)
    {
        return Error::invalid(place.path.display(), what);
    }
    let what = format!(
        "{NO_CAPTURE}; a capture is a folder that holds a transforms.json, or one of another source (looked for: {})",
        known_sources().collect::<Vec<_>>().join("; ")
    );
    if place.file.is_some() {
        let what =
            "is no store (.ovl) and no file of a capture; open one of those, or the folder of a capture";
        return Error::invalid(place.path.display(), what);
    }
    Error::invalid(place.path.display(), what)
}
