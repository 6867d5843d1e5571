//! Layers: one camera at one frame with everything that a comparison required.

mod builder;
mod layer;
mod mixed_pixels;
mod packed_sample;
mod sampling_rate;

pub use builder::LayerBuilder;
pub use layer::CameraLayer;
pub use packed_sample::{COLOR_STEPS, PackedColor, PackedGeometry, Ranks};
pub(crate) use packed_sample::{has_unknown_normal, is_mixed};
pub use sampling_rate::{Rate, ViewingRays, footprint};
