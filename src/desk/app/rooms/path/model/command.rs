//! What is asked of the camera path, and what is made of it.

use super::camera_path::CameraPath;

/// What a camera path is exported as.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ExportTarget {
    /// How many pictures a film shows a second; `None` for a folder.
    pub film_rate: Option<f64>,
    /// Whether a folder receives EXR of linear color and depth in place of PNG.
    pub linear: bool,
}

/// What came of an export.
pub(crate) struct Exported {
    /// What was written, in words.
    pub said: String,
    /// Why the renderer of the settings did not paint.
    pub notice: Option<String>,
    /// What could not be read of a store so far, one line each.
    pub damage: Vec<String>,
}

/// What concerns the camera path.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum PathCommand {
    /// Adds the view as a key behind the selected one.
    AddKey,
    GoToKey(usize),
    /// Takes a changed path in the place of the one that is there, perhaps with the key that is changed bit by bit.
    Change(Box<CameraPath>, Option<usize>),
    /// Turn once around the pivot of the view, in place of the keys that are there.
    TurnAround,
}

impl PathCommand {
    /// The command that takes a path as a change makes it.
    pub(crate) fn change(
        path: &CameraPath,
        key: Option<usize>,
        change: impl FnOnce(&mut CameraPath),
    ) -> Self {
        let mut path = Box::new(path.clone());
        change(&mut path);
        Self::Change(path, key)
    }
}
