//! Splatting: samples painted into the pixels that they cover.

mod blend;
mod surface;
mod zkey;

pub(crate) use blend::{BLEND_REACH, LEAST_WEIGHT, Sum, blend};
pub(crate) use surface::{SplatInput, surface};
pub(crate) use zkey::{CORE, inverse_depth_of, key, nearness, slot_of};
