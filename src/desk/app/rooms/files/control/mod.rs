//! How commands change the state, and how answers are taken in.

pub(crate) mod address;
pub(crate) mod opened;
pub(crate) mod opening;
pub(crate) mod path_names;
pub(crate) mod paths;
pub(crate) mod remembered;
pub(crate) mod session;

pub(crate) use paths::{no_figure, no_scene, what_is_missing};
