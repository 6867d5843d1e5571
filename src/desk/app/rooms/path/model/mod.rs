//! What is known: plain data.

pub(crate) mod camera_path;
pub(crate) mod command;
pub(crate) mod key;
mod motion;

pub(crate) use camera_path::{CameraPath, MOST_ON_A_LEG, NO_KEYS};
pub(crate) use command::{ExportTarget, Exported, PathCommand};
pub(crate) use key::{KeyNeighbor, PathShape, SavedPathKey, Turntable};
