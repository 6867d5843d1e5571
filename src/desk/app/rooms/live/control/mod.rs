//! How commands change the view, and how its pictures are taken in.

mod kept_views;
pub(crate) mod pictures;
pub(crate) mod view;
