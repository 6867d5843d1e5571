//! The samples of one frame, as renderers read them.

mod background_key;
mod dense_tile;
mod frame_tile;
mod frame_tiles;
mod relative_width;
mod tile_cache;
mod tile_grid;

pub(crate) use background_key::BackgroundKey;
pub(crate) use dense_tile::{DenseTile, beside_edges, slopes};
pub(crate) use frame_tile::{FrameTile, linear, samples_above};
pub(crate) use frame_tiles::{ColorIndex, FrameImages, FrameSamples, TileIndex};
pub(crate) use relative_width::{RelativeWidth, focal};
pub(crate) use tile_cache::{LaneValues, Quads, TexelColor, TileCaches};
pub(crate) use tile_grid::{CellTable, Lookup};
