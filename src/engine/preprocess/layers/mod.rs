//! Layers: one camera at one frame with everything that a comparison needs.

mod blended_pixels;
mod builder;
mod flying_pixels;
mod layer;
mod layer_record;
mod packed_sample;
mod rated_samples;
mod sampling_rate;
mod surface_edge;

pub(crate) use builder::LayerBuilder;
pub(crate) use layer::CameraLayer;
pub(crate) use packed_sample::{
    ABSENT_RANK, COLOR_STEPS, PackedColor, PackedGeometry, Rank, has_unknown_normal, is_blended_sky, is_mixed,
};
pub(crate) use rated_samples::{RatedSamples, SampleRun};
pub(crate) use sampling_rate::{Rate, ViewingRays, footprint};
