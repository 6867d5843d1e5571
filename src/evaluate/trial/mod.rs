//! One setting: preprocessed, stored, rendered, scored.

mod baselines;
mod compare;
mod eta;
mod paired;
mod standard_error;
mod workbench;

pub use compare::{MethodComparison, MethodScore, compare};
pub(crate) use eta::TimeLeft;
pub use paired::{PairedDifference, ViewAccuracy};
pub use standard_error::MeanEstimate;
pub(crate) use workbench::kernel_cost;
pub use workbench::{Thinning, Trial, TrialResult, Workbench};
