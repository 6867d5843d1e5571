//! What was recorded: static cameras and their frames of color, depth and normals.
//!
//! ```text
//! any path ─ open ─ readers ─ manifest ─┐
//! *.exr ───────────────────── exr ──────┼─ Capture ─ frame(camera, frame) ─ preprocess
//! demo scene ──────────────── demo ─────┘     (lazy, decoded in parallel, bounded cache)
//! ```
//!
//! [`open()`] is the one door: it recognizes what a folder or file is. A reader for each source makes a manifest of it (`readers`),
//! and `transforms` makes cameras and frames of the manifest.
//! Importers convert to the program's conventions (see the crate page); nothing behind this module does.

mod camera;
pub mod cinema;
pub mod colmap;
pub mod conventions;
mod depth_claim;
mod derived_frames;
pub mod exr;
mod frame;
mod greedy_cover;
mod intrinsics;
mod miv;
mod open;
pub mod overlap;
mod parts;
pub mod pictures;
mod pivot;
mod pixel_box;
mod pose_convention;
mod readers;
pub mod sighting;
mod trajectory;
pub mod transforms;
mod values;
mod yuv;

pub use camera::{Camera, in_perspective};
pub(crate) use camera::{along_axis, any_orthographic, is_believable_size};
pub(crate) use derived_frames::with_frames_made_of;
pub use derived_frames::{with_changed_frames, with_reindexed_frames};
pub(crate) use frame::EXPECTED_IN_ONE_PIECE;
pub use frame::{Frame, INVALID_INVERSE_DEPTH};
pub use greedy_cover::{Addition, CoveredSet, GreedyCover};
pub use intrinsics::{Intrinsics, PixelSide, Projection};
pub use open::{Source, open};
pub use parts::{Capture, CaptureParts, FrameSource, Skipped, TruthLoader, TruthView};
pub use pivot::pivot;
pub(crate) use pixel_box::{BoxInPicture, PixelBox};
pub use readers::{Description, NO_CAPTURE, known_sources};
#[cfg(test)]
pub(crate) use values::NO_VALUES;
pub(crate) use values::agree;
pub use values::{MAX_VALUE_CHANNELS, MISSING_VALUE, ValueChannel, Values};
