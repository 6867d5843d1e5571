//! Evaluation: how close to the truth the pictures are, and what they cost.
//!
//! ```text
//! metrics ─▶ scoring ─▶ trial: one setting, preprocessed, stored, painted and scored ─┬─▶ sweep: many settings
//!            truth ───────▲                                                           ├─▶ stress: a disturbed capture
//!                                                                                     └─▶ tune: the simplest that is good enough
//! ```
//!
//! `chart` draws sweeps and stress tests, `report` puts them on one page. `bench` measures the speed of each stage, beside the machine's own limits.

#![warn(clippy::unwrap_used, clippy::expect_used)]

pub mod bench;
pub mod chart;
pub mod metrics;
pub mod report;
pub mod rivals;
mod sample_filter;
mod scoring;
pub mod stress;
pub mod sweep;
pub mod trial;
pub mod truth;
pub mod tune;

pub use scoring::Scoreboard;
pub use scoring::add_aligned;
pub use scoring::frame_of;
pub use scoring::picture_of_frame;
pub use scoring::render_view;
pub use scoring::score_pictures;
pub use scoring::{AlignedScore, Evaluation, MeanScore, ViewScore, evaluate, vantage_order};
pub use scoring::{PictureScore, PictureScores};
pub use trial::compare_each;
pub use trial::{MethodComparison, MethodScore, compare};
