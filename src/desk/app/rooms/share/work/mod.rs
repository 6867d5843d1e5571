//! What is computed, on threads of its own.

pub(crate) mod compared_film;
pub(crate) mod facts;
pub(crate) mod figures;
pub(crate) mod looked_film;
pub(crate) mod preview;
pub(crate) mod sharing;

pub(crate) use figures::{FIGURE_ENDINGS, of_camera, of_rendered, write};
