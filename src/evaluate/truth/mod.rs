//! What pictures are compared with.

mod hold_out;
mod subset;
mod truth;

pub(crate) use hold_out::split;
pub(crate) use subset::{DERIVED_CACHE_BYTES, choose, frames, only, parts_of, truth_at};
pub use truth::{Fold, Recorded, Truth, TruthEdit};
