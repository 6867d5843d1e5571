//! Reading OpenEXR frames as renderers write them.
//!
//! ```text
//! bytes ── file, zip ── planes ─┐
//!            │                  ├─ depth (inverse depth), color_planes, assemble (frame)
//!        channels (who is who) ─┘
//! ```
//!
//! `channel_finder` looks for the channels that `channels` describes. Nothing is decoded before the header has been checked,
//! and only the parts that hold a wanted channel are.

pub mod assemble;
mod channel_finder;
pub mod channels;
pub mod color_planes;
pub mod depth;
pub mod file;
mod guard;
pub mod plane;
mod zip;

pub use assemble::{DepthTrouble, Layers, NormalSpace};
pub use channels::{ChannelNames, ChannelWishes};
pub use color_planes::ColorPlanes;
pub use depth::{DepthKind, DepthRules, HALF_MAX, MISS_DEPTH};
pub use file::{ChannelInfo, ExrFile, Window};
pub use plane::Plane;
