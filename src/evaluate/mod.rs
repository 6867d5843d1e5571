//! Evaluation: how close to the truth the pictures are, and what they cost.
//!
//! ```text
//! metrics ─▶ scoring ─▶ trial: one setting, preprocessed, stored, painted and scored ─┬─▶ sweep: many settings
//!            truth ───────▲                                                           ├─▶ stress: a disturbed capture
//!                                                                                     └─▶ tune: the simplest that is good enough
//! ```
//!
//! `chart` draws sweeps and stress tests, `report` puts them on one page. `bench` measures the speed of each stage, beside the machine's own limits.

pub(crate) mod bench;
pub(crate) mod chart;
pub mod metrics;
pub(crate) mod report;
mod sample_filter;
mod scoring;
pub mod stress;
pub mod sweep;
pub mod trial;
pub mod truth;
pub mod tune;

pub use scoring::{AlignedScore, Evaluation, MeanScore, ViewScore, evaluate, vantage_order};
pub use scoring::{PictureScore, PictureScores};
pub(crate) use scoring::{Scoreboard, add_aligned, frame_of, picture_of_frame, render_view, score_pictures};
pub(crate) use trial::compare_each;
pub use trial::{MethodComparison, MethodScore, compare};
