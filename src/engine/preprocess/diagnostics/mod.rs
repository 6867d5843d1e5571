//! What preprocessing reports beside the samples: counts, residuals between cameras, warnings.

mod calibration_warnings;
mod depth_reading;
mod pair_residuals;
mod pair_table;
mod report;
mod tally;

pub use calibration_warnings::{CalibrationWarning, Suspect, calibration_warnings};
pub use depth_reading::DepthReading;
pub(crate) use depth_reading::Misfits;
pub(crate) use pair_residuals::{LatticeRuns, Residuals};
pub use pair_residuals::{PairResiduals, Residual};
pub use pair_table::PairTable;
pub use report::{CameraReport, DepthNoise, PixelAccount, Report, STATIC_RULE, SpanReport};
pub(crate) use tally::{RunCounts, Tally};
