//! Views painted, compared with their truth, and averaged.
//!
//! ```text
//! TruthView ─ render_view ─▶ PaintedView ─ Scoreboard ─▶ Evaluation (a ViewScore each, and their mean)
//! ```

mod aligned_view;
mod pictures;
mod scoreboard;
mod view;

pub use aligned_view::add_aligned;
pub use pictures::{PictureScore, PictureScores, picture_of_frame, score_pictures};
pub(crate) use scoreboard::{OnPicture, evaluate_each, nothing_to_compare, with_truth};
pub use scoreboard::{Scoreboard, evaluate, vantage_order};
pub use view::{AlignedScore, Evaluation, MeanScore, ViewScore, frame_of, render_view};
pub(crate) use view::{ViewCost, scored, unknown_truth_warning};
