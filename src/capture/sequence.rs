//! The bounded cache of decoded frames that stands between a capture and everybody who reads it.

use std::sync::Arc;

use quick_cache::Weighter;
use quick_cache::sync::Cache;

use super::Frame;
use crate::error::Result;

/// `(camera, frame)`, as the source counts them.
pub type FrameKey = (usize, usize);

#[derive(Clone)]
struct BytesWeighter;

impl Weighter<FrameKey, Arc<Frame>> for BytesWeighter {
    fn weight(&self, _key: &FrameKey, frame: &Arc<Frame>) -> u64 {
        frame.bytes() as u64
    }
}

/// Decoded frames, least valuable first out, never more than the given number of bytes.
///
/// A frame that two threads ask for at once is decoded once; the other waits.
pub struct FrameCache {
    cache: Cache<FrameKey, Arc<Frame>, BytesWeighter>,
}

/// Number of frames the cache sizes its tables for; more or fewer work as well.
const EXPECTED_FRAMES: usize = 256;

impl FrameCache {
    /// A cache that holds at most `capacity_bytes` of decoded frames.
    #[must_use]
    pub fn new(capacity_bytes: usize) -> Self {
        Self { cache: Cache::with_weighter(EXPECTED_FRAMES, capacity_bytes as u64, BytesWeighter) }
    }

    /// The frame from the cache, or decoded by `load` and kept where it fits.
    ///
    /// # Errors
    /// Whatever `load` gives; errors are not cached, so that a mended file is read again.
    pub fn get_or_load(&self, key: FrameKey, load: impl FnOnce() -> Result<Frame>) -> Result<Arc<Frame>> {
        self.cache.get_or_insert_with(&key, || load().map(Arc::new))
    }

    /// Bytes of decoded frames held now.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.cache.weight()
    }
}
