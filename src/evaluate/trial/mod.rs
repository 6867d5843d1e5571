//! One setting, tried: preprocessed, stored, painted, scored.

mod baselines;
mod eta;
mod standard_error;
mod trial;

pub(crate) use eta::Pace;
pub use standard_error::Estimate;
pub use trial::{Measured, Thinning, Trial, Workbench, kernel_cost};
pub(crate) use trial::{Model, stored};
