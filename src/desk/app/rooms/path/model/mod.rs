//! What is known: plain data.

pub(crate) mod camera_path;
pub(crate) mod command;

pub(crate) use camera_path::{CameraPath, MOST_ON_A_LEG, NO_KEYS, PathShape, SavedPathKey, Turntable};
pub(crate) use command::{ExportTarget, Exported, KeyNeighbor, PathCommand};
