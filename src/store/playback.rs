//! A store played from disk: of all images only those of the shown frame, and as many others as a bounded cache holds.
//!
//! ```text
//! frame ─▶ images of its span path ─▶ cache, or file: at most MAX_REFERENCES images before each ─▶ SampleSet of that frame
//!                  read_ahead does the same for the frames to come, on whatever thread asks for it
//! ```
//!
//! The set of a frame has every image of the store in its place, those of other frames without samples. Images that two frames
//! share are the very same in both sets, so that what a renderer keeps of a background stays good.

use std::ops::Range;
use std::sync::Arc;

use quick_cache::Weighter;
use quick_cache::sync::Cache;
use rayon::prelude::*;

use super::header::chain;
use super::reader::{Decoded, Store};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::preprocess::SampleSet;

#[derive(Clone)]
struct BytesWeighter;

impl Weighter<usize, Arc<Decoded>> for BytesWeighter {
    fn weight(&self, _index: &usize, decoded: &Arc<Decoded>) -> u64 {
        decoded.image.bytes() as u64 + 1
    }
}

/// Number of images the cache sizes its tables for; more or fewer work as well.
const EXPECTED_IMAGES: usize = 1024;

/// Bytes of decoded images that are kept unless told otherwise.
pub const DEFAULT_CACHE_BYTES: u64 = 1 << 30;

/// An open store whose frames are read when they are asked for. Asking from several threads is fine.
pub struct Playback {
    store: Store,
    /// Every image in its place, none with a sample.
    outline: Arc<SampleSet>,
    cache: Cache<usize, Arc<Decoded>, BytesWeighter>,
}

impl Playback {
    /// Plays `store`, keeping at most `cache_bytes` of decoded images.
    #[must_use]
    pub fn new(store: Store, cache_bytes: u64) -> Self {
        let outline = Arc::new(store.outline());
        Self { store, outline, cache: Cache::with_weighter(EXPECTED_IMAGES, cache_bytes, BytesWeighter) }
    }

    /// The store, which also says what of it could not be read.
    #[must_use]
    pub fn store(&self) -> &Store {
        &self.store
    }

    /// A set with every image of the store in its place and no sample in any.
    #[must_use]
    pub fn outline(&self) -> &Arc<SampleSet> {
        &self.outline
    }

    /// Bytes of decoded images held now.
    #[must_use]
    pub fn cached_bytes(&self) -> u64 {
        self.cache.weight()
    }

    /// The samples at a frame; tiles that are damaged are missing.
    ///
    /// # Errors
    /// `Invalid` where there is no such frame, `Io`, `Cancelled`.
    pub fn at(&self, frame: usize, job: &Job) -> Result<Arc<SampleSet>> {
        let frames = self.outline.frame_count();
        if frame >= frames {
            return Err(Error::invalid(
                &self.outline.name,
                format!("there is no frame {frame}; there are {frames}"),
            ));
        }
        let path = self.path(frame);
        let decoded: Result<Vec<_>> = path.par_iter().map(|&index| self.image(index, job)).collect();
        let mut set = (*self.outline).clone();
        for (index, decoded) in path.into_iter().zip(decoded?) {
            set.images[index] = decoded.image.clone();
        }
        Ok(Arc::new(set))
    }

    /// Decodes the images of some frames, so that [`Playback::at`] finds them in the cache.
    ///
    /// # Errors
    /// As [`Playback::at`].
    pub fn read_ahead(&self, frames: Range<usize>, job: &Job) -> Result<()> {
        for frame in frames.start..frames.end.min(self.outline.frame_count()) {
            self.path(frame).par_iter().try_for_each(|&index| self.image(index, job).map(|_| ()))?;
        }
        Ok(())
    }

    /// The images whose span contains a frame.
    fn path(&self, frame: usize) -> Vec<usize> {
        let images = self.store.info().images.iter().enumerate();
        images.filter(|(_, image)| image.span.contains(frame)).map(|(index, _)| index).collect()
    }

    /// An image from the cache, or decoded from the nearest of its references that is there.
    fn image(&self, index: usize, job: &Job) -> Result<Arc<Decoded>> {
        let mut missing = Vec::new();
        let mut before = None;
        for index in chain(&self.store.info().images, index).unwrap_or_default() {
            before = self.cache.get(&index);
            if before.is_some() {
                break;
            }
            missing.push(index);
        }
        for index in missing.into_iter().rev() {
            job.check()?;
            let decoded = Arc::new(self.store.decode(index, before.as_deref())?);
            self.cache.insert(index, decoded.clone());
            before = Some(decoded);
        }
        before.ok_or_else(|| Error::invalid(&self.outline.name, format!("there is no image {index}")))
    }
}
