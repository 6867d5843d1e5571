//! The samples of one image as bytes, and back.

mod blocks;
mod color_ranks;
mod doubtful;
mod image_chunk;
mod precision;
mod value_blocks;
mod visible_blocks;

use std::sync::Arc;

use crate::samples::SampleImage;
pub(crate) use blocks::BlockCoding;
pub(crate) use color_ranks::{ColorRanks, UsedColors};
pub(crate) use doubtful::DoubtfulRuns;
pub use image_chunk::{BlockEntry, ImageHead};
pub(crate) use image_chunk::{Damage, ReferenceImage, check, count, decode, decode_head, encode};
pub(crate) use precision::{check_again, color_room, depth_shift, reduce};
pub(crate) use value_blocks::{ImageValues, ValueCodes, ValueCoding, count_values, encode_values};
pub(crate) use visible_blocks::{VisibleBlocks, visible_blocks};

/// An image as far as it was read, and what of it could not be.
#[derive(Clone, Debug)]
pub(crate) struct Decoded {
    pub(crate) image: Arc<SampleImage>,
    /// Where its blocks are; `None` where not even that could be read.
    pub(crate) head: Option<Arc<ImageHead>>,
    /// For every block of the head, whether it was read.
    pub(crate) read: Vec<bool>,
    pub(crate) damage: Vec<Damage>,
}

impl Decoded {
    /// The visible blocks (all where `None`) that have not been read.
    pub(crate) fn missing(&self, visible: Option<&VisibleBlocks>) -> Vec<&BlockEntry> {
        let blocks = self.head.iter().flat_map(|head| &head.blocks).zip(&self.read);
        let wanted = |block: &BlockEntry| visible.is_none_or(|visible| visible.has(block.place));
        blocks.filter(|(block, read)| !**read && wanted(block)).map(|(block, _)| block).collect()
    }

    /// Whether the visible blocks, or all, have been read.
    pub(crate) fn has(&self, visible: Option<&VisibleBlocks>) -> bool {
        self.missing(visible).is_empty()
    }
}
