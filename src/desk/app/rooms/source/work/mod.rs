//! What is computed, on threads of its own.

pub(crate) mod figure_meaning;
pub(crate) mod image;
pub(crate) mod source_comparisons;
