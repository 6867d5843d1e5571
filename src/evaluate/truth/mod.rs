//! What pictures are compared with.

mod folds;
mod hold_out;
mod subset;

pub use folds::{Fold, Recorded, Truth, TruthEdit};
pub(crate) use hold_out::split;
pub(crate) use subset::{DERIVED_CACHE_BYTES, choose, frames, only, parts_of, truth_at};
