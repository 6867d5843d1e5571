//! What is known: plain data.

pub(crate) mod command;
pub(crate) mod edits;
pub(crate) mod region;
pub(crate) mod samples;

pub(crate) use command::{Combine, DrawnDepth, EditCommand, EditTime, EditTool, EditTools};
pub(crate) use edits::{BRUSH_RADII, EditKey, EditedScene, SceneEdits, SelectionPlace};
pub(crate) use region::{last_shape, words};
