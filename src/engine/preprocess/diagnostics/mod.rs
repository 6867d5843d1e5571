//! What preprocessing reports beside the samples: counts, residuals between cameras, warnings.

mod calibration_warnings;
mod depth_reading;
mod log_histogram;
mod pair_residuals;
mod pair_table;
mod pixel_account;
mod report;
mod run_counts;
mod suspect;
mod tally;

pub use calibration_warnings::{CalibrationWarning, calibration_warnings};
pub use depth_reading::DepthReading;
pub(crate) use depth_reading::Misfits;
pub(crate) use pair_residuals::{LatticeRuns, Residuals};
pub use pair_residuals::{PairResiduals, Residual};
pub use pair_table::PairTable;
pub use pixel_account::PixelAccount;
pub use report::{CameraReport, DepthNoise, Report, STATIC_RULE, SpanReport};
pub(crate) use run_counts::RunCounts;
pub use suspect::Suspect;
pub(crate) use tally::Tally;
