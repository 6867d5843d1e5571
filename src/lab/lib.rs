//! The lab: how close to the truth the pictures are, and what they cost.
//!
//! # The measurements
//!
//! One measurement a module; each imports only from those before it:
//!
//! | question | module | what it does |
//! |---|---|---|
//! | How far off is a picture? | [`metrics`] | compares a picture with the true one: PSNR, SSIM, FLIP, flicker, errors by class |
//! | What do other methods show? | [`rivals`] | renders recorded views by the methods of others, each as its source describes it |
//! | How good are many views? | `scoring` | renders every view, scores each and averages |
//! | What is true? | [`truth`] | takes the given views, or holds out each recorded camera in turn |
//! | What does one setting give? | [`trial`] | preprocesses, stores, renders and scores a capture with one setting |
//! | What do many settings give? | [`sweep`] | runs a trial for each setting and marks the Pareto front |
//! | What breaks it? | [`stress`] | runs trials on a capture under a growing disturbance |
//! | What is enough? | [`tune`] | finds the simplest setting, and the fewest views, that are good enough |
//! | What does it look like? | [`chart`], [`report`] | draws sweeps and stress tests, and puts them on one page |
//!
//! [`evaluate()`] scores one set of samples; [`compare()`] scores several ways to prune at the same views.

#![warn(clippy::unwrap_used, clippy::expect_used)]

pub mod chart;
pub mod metrics;
pub mod report;
pub mod rivals;
mod scoring;
pub mod stress;
pub mod sweep;
pub mod trial;
pub mod truth;
pub mod tune;

pub use scoring::{
    AlignedScore, Evaluation, MeanScore, PictureScore, PictureScores, Scoreboard, ViewScore, add_aligned,
    evaluate, frame_of, picture_of_frame, render_view, score_pictures, vantage_order,
};
pub use trial::{MethodComparison, MethodScore, compare, compare_each};
