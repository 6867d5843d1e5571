//! What is known: plain data.

pub(crate) mod display;
pub(crate) mod scene_values;
pub(crate) mod value_look;

pub(crate) use display::{Background, Channel, Display, EXPOSURES, LEVELS, PictureHistogram, ToneCurve};
pub(crate) use value_look::{FrameValues, ValueLook, titled_value};
