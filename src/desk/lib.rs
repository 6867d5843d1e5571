//! The desk: the window ([`app`]) and the command line ([`cli`]) over the engine, which has the method, and the lab, which measures it.
#![warn(clippy::unwrap_used, clippy::expect_used)]

mod address;
pub mod app;
pub mod cli;
mod pruned_store;
mod text;
mod ways_out;
