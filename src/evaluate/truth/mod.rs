//! What pictures are compared with.

mod error_classes;
mod folds;
mod hold_out;
mod subset;

pub(crate) use error_classes::{class_map, class_maps, is_surface_at, seen_at};
pub(crate) use folds::masked_one_by_one;
pub use folds::{Fold, Recorded, Truth, TruthEdit};
pub(crate) use hold_out::{evenly_spaced, split};
pub(crate) use subset::{DERIVED_CACHE_BYTES, choose, frames, only, truth_at};
