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

impl PathShape {
    /// What was done to the path, in words.
    pub(crate) fn named_change_to(&self, after: &Self) -> String {
        let (before, keys) = (&self.keys, &after.keys);
        let is_other: Vec<bool> = before.iter().zip(keys).map(|(before, after)| before != after).collect();
        let first = is_other.iter().position(|is_other| *is_other);
        let number = first.unwrap_or(before.len().min(keys.len())) + 1;
        let differing = is_other.iter().filter(|is_other| **is_other).count();
        match (keys.len() as i64 - before.len() as i64, differing, self.is_closed == after.is_closed) {
            (0, 0, false) => if after.is_closed { "Close path" } else { "Open path" }.to_owned(),
            _ if keys.is_empty() => "Remove all keys".to_owned(),
            (1, _, true) => format!("Add key {number}"),
            (-1, _, true) => format!("Remove key {number}"),
            (0, 1, true) => format!("Change key {number}"),
            (0, 2, true) => format!("Exchange keys {number} and {}", number + 1),
            _ => "Other camera path".to_owned(),
        }
    }
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
