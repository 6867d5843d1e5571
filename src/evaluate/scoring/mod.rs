//! Views painted, compared with their truth, and averaged.
//!
//! ```text
//! TruthView ─ render_view ─▶ PaintedView ─ Scoreboard ─▶ Evaluation (a ViewScore each, and their mean)
//! ```

mod evaluation;
mod painted_view;
mod scoreboard;

pub use evaluation::{Evaluation, MeanScore, ViewScore};
pub(crate) use painted_view::{frame_of, no_known_pixel, render_view};
pub(crate) use scoreboard::{Scoreboard, evaluate_with, nothing_to_compare, with_truth};
pub use scoreboard::{evaluate, vantage_order};
