//! What is asked of the camera path, and what is made of it.

use glam::DVec3;

use super::key::{KeyNeighbor, Turntable};
use overlook_engine::capture::transforms::Easing;

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
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PathCommand {
    /// Adds the view as a key behind the selected one.
    AddKey,
    RemoveKey(usize),
    /// Set a key of the camera path to the current view.
    ReplaceKey(usize),
    GoToKey(usize),
    /// Exchanges the view of a key with that of its neighbor.
    ExchangeKey(usize, KeyNeighbor),
    /// Moves a key of the path to another frame, no farther than its neighbors.
    MoveKey {
        index: usize,
        frame: usize,
    },
    /// Pictures from one key of the camera path to the next.
    PicturesPerLeg(usize),
    /// Seconds of the whole path.
    Seconds(f64),
    /// Seconds from a key to the next; `None` for as many pictures as on the others.
    LegSeconds(usize, Option<f64>),
    /// Go back to the first key at the end, or do not.
    Close(bool),
    Ease(Easing),
    /// Look at a point in world space all the way, or where keys look.
    LookAt(Option<DVec3>),
    TurntableOptions(Turntable),
    /// Turn once around the pivot of the view, in place of the keys that are there.
    TurnAround,
    PictureSize([u32; 2]),
    /// Play the camera path from its beginning, or stop.
    Play(bool),
    /// Take every key out of the camera path.
    Clear,
}
