//! Sweeps, stress tests and tuning on captures small enough to be measured in a test.

mod results;
mod scenes;
#[path = "../common/small_capture.rs"]
mod small_capture;
mod stress;
mod sweep;
mod truth;
mod tune;
