//! An image of a store, as far as it was read.

use std::sync::Arc;

use super::images::{BlockEntry, Damage, ImageHead};
use super::sight::Places;
use crate::preprocess::SampleImage;

/// An image as far as it was read, and what of it could not be.
#[derive(Clone, Debug)]
pub(super) struct Decoded {
    pub(super) image: Arc<SampleImage>,
    /// Where its blocks are; `None` where not even that could be read.
    pub(super) head: Option<Arc<ImageHead>>,
    /// For every block of the head, whether it was read.
    pub(super) read: Vec<bool>,
    pub(super) damage: Vec<Damage>,
}

impl Decoded {
    /// The blocks at some places (all where `None`) that have not been read.
    pub(super) fn missing(&self, places: Option<&Places>) -> Vec<&BlockEntry> {
        let blocks = self.head.iter().flat_map(|head| &head.blocks).zip(&self.read);
        let wanted = |block: &BlockEntry| places.is_none_or(|places| places.has(block.place));
        blocks.filter(|(block, read)| !**read && wanted(block)).map(|(block, _)| block).collect()
    }

    /// Whether the blocks at some places, or all, have been read.
    pub(super) fn has(&self, places: Option<&Places>) -> bool {
        self.missing(places).is_empty()
    }
}
