//! Lossless coding of the samples in a block of pixels: prediction from neighbors, then entropy coding of what is left.
//!
//! ```text
//! block ─ walk: prediction, context ─▶ residual ─ integers ─▶ token + plain bits ─ rans, by the model of the context ─▶ bytes
//! ```

pub mod coders;
pub mod integers;
pub mod model;
pub mod near;
pub mod rans;
pub mod walk;
