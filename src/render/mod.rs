//! Rendering (the paper, §3.3): paints the kept samples into a vantage.
//!
//! ```text
//! SampleSet ─ images at the frame ─ project ─▶ splat (depth, then color) ─▶ Layer (background) ─┐
//!                                                                          Layer (foreground) ─┴ compose ─▶ resolve ─▶ Picture
//! ```
//!
//! The background layer depends on the vantage alone and is kept while the vantage is still; the foreground of each frame
//! is painted over it by depth, as the paper does.

pub mod backend;
mod blend;
mod compose;
pub mod cpu;
mod cull;
mod dense_tile;
mod footprint;
mod frame_samples;
mod gather;
pub mod gpu;
mod keys;
mod project;
mod simd;
mod surface;
pub mod vantage;

pub use backend::{Painter, Renderer};
pub use cpu::CpuRenderer;
pub use gpu::{AdapterChoice, GpuRenderer};
pub use vantage::{NO_IMAGE, Picture, RenderStats, Vantage};
