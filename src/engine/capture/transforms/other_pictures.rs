//! Pictures that another program made of views, and how each is read.

use std::path::PathBuf;
use std::sync::Arc;

use super::files::PictureFiles;
use super::header_probe::picture_size;
use super::load::{self, NeededPlanes};
use crate::capture::camera::Camera;
use crate::capture::parts::{TruthLoader, TruthView};
use crate::error::{Error, Result};

/// How pictures were matched with views.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum MatchedBy {
    /// They have the views' own names.
    FileName,
    /// They were taken from there, by the `transforms.json` of their folder.
    Pose,
}

impl std::fmt::Display for MatchedBy {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::FileName => "file name",
            Self::Pose => "pose, by their transforms.json",
        })
    }
}

/// Pictures of another program, by the views that they show.
#[derive(Clone)]
pub struct OtherPictures {
    /// Their folder.
    pub folder: PathBuf,
    /// How they were found.
    pub matched_by: MatchedBy,
    /// In the order of the views; or why a view has none, in words that follow the folder's name.
    pub pictures: Vec<std::result::Result<TruthLoader, String>>,
    /// Pictures in the folder that show none of the views.
    pub left_over: Vec<String>,
}

impl OtherPictures {
    /// Number of views that have a picture.
    #[must_use]
    pub fn count(&self) -> usize {
        self.pictures.iter().flatten().count()
    }

    /// The last part of the folder's name.
    #[must_use]
    pub fn name(&self) -> String {
        self.folder.file_name().unwrap_or(self.folder.as_os_str()).to_string_lossy().into_owned()
    }

    /// The pictures of all views.
    ///
    /// # Errors
    /// `Invalid` naming the first view that has none, and why.
    pub fn all(&self) -> Result<Vec<TruthLoader>> {
        self.pictures
            .iter()
            .map(|picture| picture.clone().map_err(|reason| Error::invalid(self.folder.display(), reason)))
            .collect()
    }

    /// A warning where the folder holds pictures that show none of the views.
    #[must_use]
    pub fn warning(&self) -> Option<String> {
        let first = self.left_over.first()?;
        let folder = self.folder.display();
        Some(match self.left_over.len() {
            1 => format!("{folder}: the picture '{first}' shows none of the views"),
            count => format!("{folder}: {count} pictures show none of the views, '{first}' first"),
        })
    }
}

/// Reads a view's picture, once its size is known to be that of the view.
pub(super) fn loader(
    files: PictureFiles,
    camera: &Camera,
    place: String,
    view: &TruthView,
) -> std::result::Result<TruthLoader, String> {
    let found = picture_size(&files.color, files.rows, None, &place).map_err(|error| error.to_string())?;
    let wanted = view.camera.intrinsics.size();
    if found != wanted {
        let ((width, height), (columns, rows)) = (found, wanted);
        return Err(format!(
            "has a picture of view '{}' of {width}×{height} pixels ({place}), but the view has {columns}×{rows}; render it at the view's size",
            view.file_path
        ));
    }
    let camera = camera.clone();
    Ok(Arc::new(move || load::frame(&files, &camera, &place, NeededPlanes::ColorOnly)))
}
