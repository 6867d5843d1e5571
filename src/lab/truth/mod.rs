//! What pictures are compared with.

mod error_classes;
mod folds;
mod hold_out;
mod picture_numbers;
mod subset;
mod view_corrections;

pub(crate) use error_classes::is_surface_at;
pub use error_classes::{class_map, class_maps, seen_at};
pub(crate) use folds::masked_one_by_one;
pub use folds::{Fold, Recorded, Truth, TruthEdit};
pub(crate) use hold_out::evenly_spaced;
pub use hold_out::split;
pub use subset::frames;
pub(crate) use subset::{DERIVED_CACHE_BYTES, choose, only, truth_at};
pub use view_corrections::{CorrectedViews, ViewCorrections, views_as_taken};
