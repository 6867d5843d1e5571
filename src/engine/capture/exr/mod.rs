//! Reading OpenEXR frames as renderers write them.
//!
//! ```text
//! bytes ── file, zip ── planes ─┐
//!            │                  ├─ depth (inverse depth), color_planes, transparency, assemble (frame)
//!        channels (who is who) ─┘
//! ```
//!
//! `channel_finder` looks for the channels that `channels` describes. Nothing is decoded before the header has been checked,
//! and only the parts that hold a wanted channel are.

mod assemble;
mod channel_finder;
mod channels;
mod color_planes;
mod decoder_guard;
mod depth;
mod file;
mod header;
mod transparency;
mod write;
mod zip;

pub(crate) use assemble::{DepthTrouble, Layers, NormalSpace};
pub use channels::ChannelPlane;
pub(crate) use channels::{ChannelNames, ChannelWishes};
pub(crate) use color_planes::{ColorPlanes, Primaries};
pub(crate) use depth::{DepthKind, DepthRules, HALF_MAX, MISS_DEPTH};
pub use file::{ChannelInfo, DataWindow, ExrFile};
pub(crate) use header::HeaderAttributes;
pub(crate) use transparency::AlphaPlane;
pub(crate) use write::{value_channel, write_frame, write_picture};
