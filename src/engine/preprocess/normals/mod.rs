//! Surface normals (the paper, §3.2): given, or estimated from depth.
//!
//! Purpose: the sampling rate needs the angle at which a camera sees a surface. Estimates never reach across a
//! silhouette, and each carries a confidence; a sample whose normal is not trusted counts as seen at grazing incidence and
//! loses to every one whose normal is known. Neighbors of shorter spans are decided later and take no part, so that beside
//! what moves there may be too few to trust.
//!
//! Source: the paper leaves the estimator open. *Cross* is the usual cross product of neighboring differences, one-sided
//! toward the flatter neighbor. *Plane* uses that a plane `n·X = d` seen by a pinhole camera is linear in the image in
//! **inverse** depth, `1/z = (nx u + ny v + nz) / d` with `u, v` on the normalized image plane, so that a linear
//! least-squares fit over a window is exact on planes at any slant. What differs: the window is cut at depth steps.

mod depth_view;
mod estimate;
mod plane_fit;
mod validation;

pub use depth_view::DepthView;
pub use estimate::estimate_all;
pub(crate) use estimate::{MIN_CONFIDENCE, estimate_at};
pub use validation::NormalErrors;
pub(crate) use validation::{compare_with_given, contradiction, normal_space_warning};
