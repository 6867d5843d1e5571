//! One setting, tried: preprocessed, stored, painted, scored.

mod baselines;
mod eta;
mod standard_error;
mod trial;

pub(crate) use eta::Pace;
pub use standard_error::MeanEstimate;
pub(crate) use trial::{FoldSamples, stored};
pub use trial::{Thinning, Trial, TrialResult, Workbench, kernel_cost};
