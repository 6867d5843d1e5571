//! What is computed, on threads of its own.

pub(crate) mod compare;
pub(crate) mod difference;
pub(crate) mod figure;
pub(crate) mod place;
