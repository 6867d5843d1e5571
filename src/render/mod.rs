//! Rendering (the paper, §3.3): paints the kept samples into a vantage.
//!
//! ```text
//! SampleSet ─ images at the frame ─ project ─▶ splat (depth, then color) ─▶ Layer (background) ─┐
//!                                                                          Layer (foreground) ─┴ compose ─▶ resolve ─▶ fill ─▶ Picture
//! ```
//!
//! The background layer depends on the vantage alone and is kept while the vantage is still; the foreground of each frame
//! is painted over it by depth, as the paper does.

mod compose;
pub mod cpu;
mod fill;
mod project;
mod splat;
pub mod vantage;

pub use cpu::CpuRenderer;
pub use fill::fill;
pub use vantage::{NO_IMAGE, Picture, RenderStats, Vantage};
