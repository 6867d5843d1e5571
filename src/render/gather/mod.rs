//! The gather stage: surface first, color second.

mod block;
mod interpolate;
mod reproject;
mod silhouette;
mod surface_points;
mod view_weights;
mod visibility_votes;

pub(crate) use block::{GatherScratch, ScratchPool};
pub(crate) use silhouette::{Patch, RING, SIDE};
pub(crate) use view_weights::{BLOCK, SourceViews};
