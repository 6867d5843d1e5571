//! Views painted, compared with their truth, and averaged.
//!
//! ```text
//! TruthView ─ render_view ─▶ PaintedView ─ Scoreboard ─▶ Evaluation (a ViewScore each, and their mean)
//! ```

mod aligned_view;
mod pictures;
mod scoreboard;
mod view;

pub(crate) use aligned_view::add_aligned;
pub use pictures::{PictureScore, PictureScores};
pub(crate) use pictures::{picture_of_frame, score_pictures};
pub(crate) use scoreboard::{OnPicture, Scoreboard, evaluate_each, nothing_to_compare, with_truth};
pub use scoreboard::{evaluate, vantage_order};
pub use view::{AlignedScore, Evaluation, MeanScore, ViewScore};
pub(crate) use view::{ViewCost, frame_of, render_view, scored, unknown_truth_warning};
