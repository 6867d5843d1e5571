//! One setting: preprocessed, stored, rendered, scored.

mod baselines;
mod budget;
mod compare;
mod paired;
mod rival_trial;
mod shown_view;
mod standard_error;
mod trial_result;
mod trial_setting;
mod workbench;

pub use budget::{Fineness, Measured, levels};
pub(crate) use budget::{TimeLeft, coarse_to_fine};
pub use compare::{MethodComparison, MethodScore, compare, compare_each};
pub use paired::{PairedDifference, ViewAccuracy};
pub use shown_view::ShownView;
pub use standard_error::MeanEstimate;
pub use trial_result::TrialResult;
pub(crate) use trial_result::kernel_cost;
pub use trial_setting::{Thinning, Trial};
pub use workbench::Workbench;
