//! The samples of one image as bytes, and back.

mod blocks;
mod color_ranks;
mod decoded;
mod doubtful;
mod image_chunk;
mod precision;
mod value_blocks;
mod visible_blocks;

pub(crate) use blocks::BlockCoding;
pub(crate) use color_ranks::{ColorRanks, UsedColors};
pub(crate) use decoded::Decoded;
pub(crate) use doubtful::DoubtfulRuns;
pub use image_chunk::{BlockEntry, ImageHead};
pub(crate) use image_chunk::{Damage, ReferenceImage, check, count, decode, decode_head, encode};
pub(crate) use precision::{check_again, color_room, depth_shift, reduce};
pub(crate) use value_blocks::{ImageValues, ValueCodes, ValueCoding, count_values, encode_values};
pub(crate) use visible_blocks::{VisibleBlocks, visible_blocks};
