//! Reading OpenEXR frames as renderers write them.
//!
//! ```text
//! bytes ── file ── planes of f32 ─┐
//!            │                    ├─ depth (inverse depth), assemble (frame)
//!        channels (who is who) ───┘
//! ```
//!
//! Nothing is decoded before the header has been checked, and only the parts that hold a wanted channel are.

pub mod assemble;
pub mod channels;
pub mod depth;
pub mod file;
mod guard;

pub use assemble::{Layers, NormalSpace};
pub use channels::{ChannelNames, ChannelWishes};
pub use depth::{DepthKind, DepthRules};
pub use file::{ExrFile, MAX_SIDE, Plane, Window};
