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
pub use pictures::picture_of_frame;
pub use pictures::score_pictures;
pub use pictures::{PictureScore, PictureScores};
pub use scoreboard::Scoreboard;
pub(crate) use scoreboard::{OnPicture, evaluate_each, nothing_to_compare, with_truth};
pub use scoreboard::{evaluate, vantage_order};
pub use view::frame_of;
pub use view::render_view;
pub use view::{AlignedScore, Evaluation, MeanScore, ViewScore};
pub(crate) use view::{ViewCost, scored, unknown_truth_warning};
