//! The gather stage: surface first, color second.
//!
//! The surface stage finds the depth of the surface in each pixel. [`block`] decides what each pixel of a block shows; at
//! steps in depth the cameras vote on it ([`silhouette`], [`visibility_votes`]), for each of four sub-pixels ([`subpixels`]).
//! [`interpolate`] then carries the surface points of some blocks back into the cameras, each into those that can tell something of it
//! ([`near_cameras`]), and interpolates its color among their samples: bilinearly over the 2×2 samples around it, as far as they are on the
//! same surface, averaged over cameras by sampling rate and viewing angle ([`view_weights`]). Each camera first corrects the depth by its
//! own samples, so that noise and small misalignments between cameras blur nothing.
//!
//! Source: backward warping with per-view weights is that of Buehler et al., *Unstructured Lumigraph Rendering*, SIGGRAPH
//! 2001, §4 (angle and resolution penalties). What differs: the proxy is the z-buffer of the samples themselves, weights are
//! computed per pixel instead of per vertex, and samples that pruning removed are left out one by one.

mod block;
mod interpolate;
mod near_cameras;
mod scratch_pool;
mod silhouette;
mod subpixels;
mod surface_points;
mod target;
mod view_weights;
mod visibility_votes;

pub(crate) use block::GatherScratch;
pub(crate) use scratch_pool::ScratchPool;
pub(crate) use silhouette::{Patch, RING, SIDE};
pub(crate) use target::{BLOCK, BlockOrigin, PictureRows, TOGETHER};
pub(crate) use view_weights::{SourceViews, full_coverage};
