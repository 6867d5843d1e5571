//! Measuring: metrics, truth, sweeps, stress tests, tuning, and the published figures.

#[expect(dead_code, reason = "other tests need its scene")]
#[path = "../common/command.rs"]
mod command;
#[path = "../common/small_capture.rs"]
mod small_capture;

mod accuracy;
mod metrics;
mod results;
mod scenes;
mod stress;
mod sweep;
mod truth;
mod tune;
