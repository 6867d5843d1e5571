//! What is computed, on threads of its own.

pub(crate) mod files;
pub(crate) mod opening;
pub(crate) mod other_pictures;

pub(crate) use files::with_ending;
