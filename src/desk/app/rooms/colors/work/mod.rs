//! What is computed, on threads of its own.

pub(crate) mod develop;
pub(crate) mod values;

pub(crate) use develop::{background_at, developed, displayed, histogram_of};
