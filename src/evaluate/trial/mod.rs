//! One setting: preprocessed, stored, rendered, scored.

mod baselines;
mod compare;
mod eta;
mod standard_error;
mod trial;

pub use compare::{MethodComparison, MethodScore, compare};
pub(crate) use eta::TimeLeft;
pub use standard_error::MeanEstimate;
pub(crate) use trial::kernel_cost;
pub use trial::{Thinning, Trial, TrialResult, Workbench};
