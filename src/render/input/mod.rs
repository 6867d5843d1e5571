//! The samples of one frame, as renderers read them.

mod dense_tile;
mod frame_tiles;
mod tile_cache;
mod tile_grid;

pub(crate) use dense_tile::{DenseTile, beside_edges, slopes};
pub(crate) use frame_tiles::{ColorPlace, FrameImages, FrameSamples, FrameTile, Numbers};
pub(crate) use tile_cache::{LANES, LaneValues, Quads, Windows};
pub(crate) use tile_grid::{CellTable, Lookup};
