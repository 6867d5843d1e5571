//! Robustness: disturbances of growing size, applied to any capture, and what they cost our settings and the paper's.
//!
//! ```text
//! capture ─ Disturbance::apply(dial) ─▶ Recorded ─ Workbench ─▶ StressPoint …─ failures ─▶ the dial at which 1 dB is lost
//! ```
//!
//! Frames are disturbed as they are loaded. Loss is relative to the same method at the first value of the dial, which disturbs
//! nothing, over the views scored at both. There are no points for a value at which no camera sees any true pixel, or for a
//! disturbance that cannot change the capture.

mod breaking;
mod depth_sensor;
mod disturbance;
mod measure;
mod plan;
mod recording_edits;
mod shapes;

pub use breaking::{BreakingPoint, LOST_DB, breaking_views, distinct, failures};
pub use disturbance::Disturbance;
pub use measure::run;
pub use plan::{Method, StressPlan, StressPoint};
