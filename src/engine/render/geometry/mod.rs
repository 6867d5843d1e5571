//! Where samples are in the picture, and how large they are there.

mod cull;
mod footprint;
mod project;

pub(crate) use super::relative_width::{RelativeWidth, focal};
pub(crate) use cull::{FootprintReach, RowBand, TileBounds, bands, bounds};
pub(crate) use footprint::{CORE_REACH, FRINGE, Footprints, MAGNIFIED, MAX_STRETCH, PlaneAt, footprints};
pub(crate) use project::{ProjectedRow, Projector, growth_along, rays_in_world};
