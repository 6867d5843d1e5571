//! Splatting: samples painted into the pixels that they cover.

mod band_rows;
mod blend;
mod input;
mod packed_tile;
mod surface;
mod zkey;

pub(crate) use blend::{BLEND_REACH, BlendSum, LEAST_WEIGHT, blend};
pub(crate) use input::StageInput;
pub(crate) use surface::surface;
pub(crate) use zkey::{CORE, TRUSTED, inverse_depth_of, key, nearness, slot_of};
