//! What is computed, on threads of its own.

pub(crate) mod accuracy;
pub(crate) mod study;
