//! The data model: samples of all cameras over spans of frames, in tiles, as preprocessing makes them, stores keep them and renderers paint them.

mod coarser;
mod depth_plane;
mod image_buffer;
mod image_parts;
mod oct_normal;
mod placed;
mod sample_set;
mod spill_file;
mod tile;
mod verdicts;
mod votes;

pub(crate) use coarser::halved_camera;
pub use depth_plane::{DepthPlane, DepthTile, TILE_SAMPLES, TileDepths};
pub use image_buffer::{ImageBuffer, ImageFacts};
pub use oct_normal::OctNormal;
pub use placed::{PlacedSample, are_far_from_origin};
pub use sample_set::{SampleImage, SampleSet, Span};
pub use spill_file::{ReadSeek, RecordReader, RecordWriter};
pub(crate) use spill_file::{Record, RecordPlace, SpillFile, samples_in_memory};
pub use tile::{Sample, SampleTile, TILE, TileMask};
pub use verdicts::{PixelVerdict, SpanVerdicts, VerdictBuffer};
pub use votes::{SampleVotes, Vote, VoteCounts};
