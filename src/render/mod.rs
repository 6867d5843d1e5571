//! Rendering (the paper, §3.3): paints the kept samples into a vantage.
//!
//! ```text
//! SampleSet ─ frame_samples ─▶ tiles of the frame ─ cull ─▶ bands ─ project, footprint ─▶ surface ─▶ keys ─▶ blend ─▶ sums
//!                                                                                          │                        │
//!      Picture ◀─ fill ◀─ resolve ◀─ gather ◀─ lookup: back into the cameras ◀─ silhouette ─┴────────────────────────┘
//! ```
//!
//! The *surface* stage finds the nearest sample of every pixel. What follows depends on the kernel: `point` shows that
//! sample; `block` and `surfel` *blend* all samples of its surface; `gather` looks its surface point up in the cameras.
//! The background depends on the vantage alone and is kept while the vantage is still; the foreground of each frame is
//! painted over it by depth, as the paper does, where it is and where it was.

pub mod backend;
mod blend;
mod blocks;
pub mod cpu;
mod cull;
mod dense_tile;
mod fill;
mod footprint;
mod frame_samples;
mod gather;
pub mod gpu;
mod keys;
mod lookup;
pub mod pick;
mod project;
mod resolve;
mod silhouette;
mod simd;
mod surface;
pub mod vantage;

pub use backend::{Painter, Renderer};
pub use cpu::CpuRenderer;
pub use fill::fill;
pub use gpu::{AdapterChoice, GpuRenderer};
pub use pick::{Picked, pick};
pub use vantage::{NO_IMAGE, Picture, RenderStats, Vantage};
