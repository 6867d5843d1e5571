//! An image of a store, as far as it was read.

use std::sync::Arc;

use super::image_chunk::{BlockEntry, Damage, ImageHead};
use super::visible_blocks::VisibleBlocks;
use crate::samples::SampleImage;

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
