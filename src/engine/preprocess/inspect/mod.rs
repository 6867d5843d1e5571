//! Why each pixel was kept or dropped: the verdicts of a frame for display, and the explanation of one pixel.

mod explained_sample;
mod frame;
mod pixel;
mod pixel_report;
mod view_dependence;

pub use frame::{CameraInspection, FrameInspection};
pub use pixel::{explain_pixel, pair_quantities, spans_of_pixel};
pub use pixel_report::{CameraEvidence, ChainLink, PairQuantities, PixelExplanation};
pub use view_dependence::VISIBLE_STEPS;
