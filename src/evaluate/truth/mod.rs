//! What pictures are compared with.

mod error_classes;
mod folds;
mod hold_out;
mod subset;

pub(crate) use error_classes::{class_map, class_maps, seen_at};
pub use folds::{Fold, Recorded, Truth, TruthEdit};
pub(crate) use hold_out::split;
pub(crate) use subset::{DERIVED_CACHE_BYTES, choose, frames, only, truth_at};
