//! How close a picture is to the truth.
//!
//! One metric a file, each with its source: PSNR, SSIM, MS-SSIM, FLIP, silhouette (error near steps in depth), flicker
//! (error that changes over time) and classes of error (unseen, edge, inner). All are of what a display shows: sRGB, clipped to 0 to 1.
//!
//! A pixel whose truth has no depth (not recorded, or masked because no camera saw it) is left out of everything: the picture is
//! set to the truth there first.

mod error_class;
mod flicker;
mod flip;
mod pair;
mod psnr;
mod ssim;

pub(crate) use error_class::ClassErrors;
pub use error_class::{ClassMap, ClassScore, ErrorByClass, ErrorClass};
pub(crate) use flicker::FlickerMeter;
pub use flip::{DEFAULT_PIXELS_PER_DEGREE, flip};
pub(crate) use pair::Pair;
pub use pair::{Scores, luma, score};
pub use psnr::{MAX_PSNR_DB, psnr_db};
pub use ssim::{ms_ssim, ssim};
