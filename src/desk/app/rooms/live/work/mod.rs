//! What is computed, on threads of its own.

pub(crate) mod carry;
pub(crate) mod dimmed_fills;
pub(crate) mod image;
pub(crate) mod schedule;
pub(crate) mod shown_samples;
