//! What pictures are held against.

mod hold_out;
mod subset;
mod truth;

pub use hold_out::split;
pub(crate) use subset::{DERIVED_CACHE_BYTES, parts_of};
pub use subset::{choose, frames, only, truth_at};
pub(crate) use truth::nothing_to_compare;
pub use truth::{Fold, Recorded, Truth, TruthEdit};
