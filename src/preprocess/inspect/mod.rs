//! Why each pixel was kept or dropped.

mod frame;
mod pixel;
mod pixel_report;

pub use frame::{CameraInspection, FrameInspection, PixelClass};
pub use pixel::{pair_quantities, pixel_argument, spans_of_pixel};
pub use pixel_report::{CameraEvidence, ChainLink, PairQuantities, PixelExplanation};
