//! Layers: one camera at one frame with everything that a comparison needs.

mod builder;
mod layer;
mod mixed_pixels;
mod packed_sample;
mod sampling_rate;

pub use builder::LayerBuilder;
pub use layer::CameraLayer;
pub use packed_sample::{COLOR_STEPS, Facet, Look, MIXED, Ranks, UNSURE};
pub use sampling_rate::{Rate, ViewingRays, footprint};
