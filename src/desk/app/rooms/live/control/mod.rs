//! How commands change the view, and how its pictures are taken in.

pub(crate) mod pictures;
pub(crate) mod view;
