//! What a camera path is made of: keys, in an order, and what is chosen for a turn.

use crate::app::rooms::live::model::orbit_camera::OrbitCamera;

/// A place on the path.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SavedPathKey {
    pub orbit: OrbitCamera,
    pub frame: usize,
    /// Pictures from here to the next key; `None` for those of the path.
    pub pictures: Option<usize>,
}

/// What of a path can be taken back.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct PathShape {
    pub keys: Vec<SavedPathKey>,
    pub is_closed: bool,
}

/// A turn around the pivot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Turntable {
    pub keys: usize,
    pub seconds: f64,
    /// Whether the played frames pass meanwhile, or the one that is shown stays.
    pub passes_time: bool,
}

impl Default for Turntable {
    fn default() -> Self {
        Self { keys: 12, seconds: 8.0, passes_time: false }
    }
}

/// A neighbor of a key in the list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum KeyNeighbor {
    Before,
    Behind,
}
