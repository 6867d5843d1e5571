//! Pictures that another program made of views.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::files::{PictureFiles, picture_path};
use super::load::{self, NeededPlanes};
use super::manifest::Keys;
use crate::capture::parts::{TruthLoader, TruthView};
use crate::error::{Error, Result};

/// Loaders of the pictures that lie in a folder under the views' own names, with the same extension or that of another format; in the
/// order of the views. PNG, JPEG and TIFF are sRGB, EXR is linear. A pixel with an alpha of 0 is a hole.
///
/// # Errors
/// `Invalid` naming the first view that has no picture there.
pub fn open_pictures(folder: &Path, views: &[TruthView]) -> Result<Vec<TruthLoader>> {
    let of_view = |view: &TruthView| {
        let place = picture_of(folder, &view.file_path).ok_or_else(|| {
            Error::invalid(
                folder.display(),
                format!(
                    "has no picture of view '{}'; write one for each view, under its own name, as PNG, JPEG, TIFF or EXR",
                    view.file_path
                ),
            )
        })?;
        let files =
            PictureFiles::new(place.clone(), None, None, &Keys::default(), &place.display().to_string())?;
        let camera = view.camera.clone();
        let load =
            move || load::frame(&files, &camera, &place.display().to_string(), NeededPlanes::ColorOnly);
        Ok(Arc::new(load) as TruthLoader)
    };
    views.iter().map(of_view).collect()
}

/// Where the picture of a view lies; `None` where there is none.
fn picture_of(folder: &Path, file_path: &str) -> Option<PathBuf> {
    let whole = picture_path(folder, file_path, &[]);
    if whole.is_file() {
        return Some(whole);
    }
    let stem = Path::new(file_path).with_extension("");
    let other = picture_path(folder, &stem.to_string_lossy(), &[]);
    other.is_file().then_some(other)
}
