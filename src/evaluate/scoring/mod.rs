//! Views painted, compared with their truth, and averaged.
//!
//! ```text
//! TruthView ─ render_view ─▶ PaintedView ─ Scoreboard ─▶ Evaluation (a ViewScore each, and their mean)
//! ```

mod evaluation;
mod painted_view;
mod scoreboard;

pub use evaluation::{Evaluation, MeanScore, ViewScore};
pub(crate) use painted_view::no_known_pixel;
pub use painted_view::{PaintedView, frame_of, render_view};
pub use scoreboard::{Scoreboard, evaluate, vantage_order};
pub(crate) use scoreboard::{evaluate_with, with_truth};
