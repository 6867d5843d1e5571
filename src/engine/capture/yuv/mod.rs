//! Raw planar video (`.yuv`): pictures one after the other, without a header.
//!
//! Size and format are in the file's name or in the manifest. Planes follow each other: all of luma, then, halved both ways, U and V.
//! Samples of more than 8 bits are little-endian 16-bit words, low-aligned.

mod color;
mod format;
mod picture;

pub(crate) use color::ColorMatrix;
pub(crate) use format::PixelFormat;
pub(crate) use picture::{LevelOrder, LevelRange, YuvFile, encode_color, encode_levels, pictures_in};
