//! Sweeps, stress tests and tuning on captures small enough to be measured in a test.

mod results;
mod scenes;
mod stress;
mod sweep;
mod truth;
mod tune;
