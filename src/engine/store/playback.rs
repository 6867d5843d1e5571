//! A store played from disk: of all images only those of the shown frame, and as many others as a bounded cache holds.
//!
//! ```text
//! frame ─▶ images of its span path ─▶ cache, or file: at most MAX_REFERENCES images before each ─▶ SampleSet of that frame
//!                  read_ahead_from does the same for the frames to come, on the calling thread
//! ```
//!
//! The set of a frame has every image of the store in its place, those of other frames without samples. Images that two frames
//! share are the very same in both sets, as long as the cache holds them, so that what a renderer keeps of a background stays good. Asked for what a vantage needs
//! ([`Playback::seen_from`]), an image holds the blocks that any vantage has needed so far; others are decoded on demand.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use quick_cache::Weighter;
use quick_cache::sync::Cache;
use rayon::prelude::*;

use crate::capture::{Camera, EXPECTED_IN_ONE_PIECE};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::samples::{SampleSet, Span};
use crate::store::file::{Store, chain};
use crate::store::image::{Decoded, VisibleBlocks, visible_blocks};

#[derive(Clone)]
struct ImageBytes;

impl Weighter<usize, Arc<Decoded>> for ImageBytes {
    fn weight(&self, _index: &usize, decoded: &Arc<Decoded>) -> u64 {
        let blocks = decoded.head.as_ref().map_or(0, |head| size_of_val(head.blocks.as_slice()));
        (decoded.image.bytes() + blocks) as u64 + 1
    }
}

/// Bytes of decoded images that are kept by default.
pub const DEFAULT_CACHE_BYTES: u64 = 1 << 30;

/// An open store whose frames are read on demand, from any number of threads.
pub struct Playback {
    store: Store,
    /// Every image in its place, none with a sample.
    outline: Arc<SampleSet>,
    cache: Cache<usize, Arc<Decoded>, ImageBytes>,
}

/// One sample of a store, without its color.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredSample {
    /// The frames for which it stands.
    pub span: Span,
    /// 1 / planar z; 0 at infinity.
    pub inverse_depth: f32,
    /// One value per channel of the store.
    pub values: Vec<f32>,
    /// Whether it is shown only where no other sample is.
    pub is_doubtful: bool,
}

impl Playback {
    /// Plays `store`, keeping at most `cache_bytes` of decoded images.
    #[must_use]
    pub fn new(store: Store, cache_bytes: u64) -> Self {
        let outline = Arc::new(store.outline());
        Self { store, outline, cache: Cache::with_weighter(EXPECTED_IN_ONE_PIECE, cache_bytes, ImageBytes) }
    }

    /// The store, which also knows what of it could not be read.
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
        let path = self.path(frame)?;
        self.set(path, |_| None, job)
    }

    /// The samples at a frame that painting it from a vantage needs: the picture is the same as with all. Blocks of 64×64 pixels that it
    /// does not need stay undecoded, unless they were decoded before.
    ///
    /// # Errors
    /// As [`Playback::at`].
    pub fn seen_from(&self, vantage: &Camera, frame: usize, job: &Job) -> Result<Arc<SampleSet>> {
        let path = self.path(frame)?;
        let visible = self.needed(vantage, &path, job)?;
        self.set(path, |camera| visible.get(camera), job)
    }

    /// The sample that a pixel of a camera has at a frame; `None` where another sample stands for it, or nothing. Only the block around
    /// the pixel is decoded.
    ///
    /// # Errors
    /// As [`Playback::at`].
    pub fn sample_at(
        &self,
        frame: usize,
        camera: usize,
        (x, y): (usize, usize),
        job: &Job,
    ) -> Result<Option<StoredSample>> {
        let Some(size) = self.outline.cameras.get(camera).map(|camera| camera.intrinsics.size()) else {
            return Ok(None);
        };
        let block = VisibleBlocks::of_pixel(size, (x, y));
        for index in self.path(frame)? {
            if self.store.info().images[index].camera as usize != camera {
                continue;
            }
            let decoded = self.image(index, Some(&block), job)?;
            let image = &decoded.image;
            if let Some((sample, inverse_depth)) = image.sample_at(x, y) {
                let (values, is_doubtful) = (image.values.of(sample).to_vec(), image.is_doubtful(x, y));
                return Ok(Some(StoredSample { span: image.span, inverse_depth, values, is_doubtful }));
            }
        }
        Ok(None)
    }

    /// For each camera, the blocks of some images that a vantage needs.
    fn needed(&self, vantage: &Camera, path: &[usize], job: &Job) -> Result<Vec<VisibleBlocks>> {
        let images = &self.store.info().images;
        let cameras = &self.outline.cameras;
        let heads: Result<Vec<_>> = path
            .iter()
            .map(|&index| {
                job.check()?;
                let camera = images[index].camera as usize;
                if let Some(decoded) = self.cache.get(&index) {
                    return Ok((camera, decoded));
                }
                // No block is visible: the head alone is read.
                let decoded =
                    Arc::new(self.store.decode(index, None, None, Some(&VisibleBlocks::default()))?);
                self.cache.insert(index, decoded.clone());
                Ok((camera, decoded))
            })
            .collect();
        let heads = heads?;
        let blocks = heads.iter().flat_map(|(camera, decoded)| {
            let blocks = decoded.head.iter().flat_map(|head| &head.blocks);
            blocks.map(|block| (*camera, block))
        });
        Ok(visible_blocks(vantage, cameras, blocks))
    }

    /// The outline with some images in it, each read at the visible blocks of its camera, or all.
    fn set<'a>(
        &self,
        path: Vec<usize>,
        visible: impl Fn(usize) -> Option<&'a VisibleBlocks> + Sync,
        job: &Job,
    ) -> Result<Arc<SampleSet>> {
        let camera = |index: usize| self.store.info().images[index].camera as usize;
        let decoded: Result<Vec<_>> =
            path.par_iter().map(|&index| self.image(index, visible(camera(index)), job)).collect();
        let mut set = (*self.outline).clone();
        for (index, decoded) in path.into_iter().zip(decoded?) {
            set.images[index] = decoded.image.clone();
        }
        Ok(Arc::new(set))
    }

    /// Decodes what painting some frames from a vantage needs, so that [`Playback::seen_from`] finds it in the cache.
    ///
    /// # Errors
    /// As [`Playback::at`].
    pub fn read_ahead_from(&self, vantage: &Camera, frames: Range<usize>, job: &Job) -> Result<()> {
        for frame in frames.start..frames.end.min(self.outline.frame_count()) {
            self.seen_from(vantage, frame, job)?;
        }
        Ok(())
    }

    /// The images whose span contains a frame.
    fn path(&self, frame: usize) -> Result<Vec<usize>> {
        let frames = self.outline.frame_count();
        if frame >= frames {
            let what = format!("there is no frame {frame}; there are {frames}");
            return Err(Error::invalid(&self.outline.name, what));
        }
        let images = self.store.info().images.iter().enumerate();
        Ok(images.filter(|(_, image)| image.span.contains(frame)).map(|(index, _)| index).collect())
    }

    /// An image with its visible blocks, or all: from the cache, or decoded from the nearest of its references that is there.
    fn image(&self, index: usize, visible: Option<&VisibleBlocks>, job: &Job) -> Result<Arc<Decoded>> {
        let mut missing = Vec::new();
        let mut before = None;
        for index in chain(&self.store.info().images, index).unwrap_or_default() {
            let cached = self.cache.get(&index);
            if cached.as_ref().is_some_and(|cached| cached.has(visible)) {
                before = cached;
                break;
            }
            missing.push((index, cached));
        }
        for (index, cached) in missing.into_iter().rev() {
            job.check()?;
            let decoded = self.store.decode(index, cached.as_deref(), before.as_deref(), visible)?;
            let decoded = Arc::new(decoded);
            self.cache.insert(index, decoded.clone());
            before = Some(decoded);
        }
        before.ok_or_else(|| Error::invalid(&self.outline.name, format!("there is no image {index}")))
    }
}

/// Decoded images that are kept meanwhile, bytes.
const CACHE_BYTES: u64 = 256 << 20;

/// Bytes of one input pixel as 8-bit color and 32-bit depth.
const INPUT_PIXEL_BYTES: f64 = 7.0;

/// What became of the reading.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Verification {
    /// Images read.
    pub images: usize,
    /// Frames played, in their order.
    pub frames: usize,
    /// Samples by the index of the store.
    pub samples: u64,
    /// Bytes of the file.
    pub bytes: u64,
    /// Wall-clock seconds from opening the file to the first frame's samples.
    pub seconds_to_first_frame: f64,
    /// Wall-clock seconds of all frames.
    pub seconds: f64,
    /// Bytes of the input, as 8-bit color and 32-bit depth, that one second of reading frames represents, in 10⁹.
    pub input_gb_per_s: f64,
    /// One line for everything that is damaged: which chunk, at which byte, and what of it is lost.
    pub damage: Vec<String>,
}

/// Reads every chunk of a store: checksums, tables, and every sample.
///
/// # Errors
/// As [`Store::open`], where nothing of the store can be shown; `Io` and `Cancelled`. Damaged images are no error:
/// see [`Verification::damage`].
pub fn verify(path: &Path, job: &Job) -> Result<Verification> {
    let started = Instant::now();
    let playback = Playback::new(Store::open(path)?, CACHE_BYTES);
    let info = playback.store().info();
    let frames = info.frame_numbers.len();
    let mut seconds_to_first_frame = 0.0;
    job.start("Reading the store", frames);
    for frame in 0..frames {
        job.check()?;
        playback.at(frame, job)?;
        if frame == 0 {
            seconds_to_first_frame = started.elapsed().as_secs_f64();
        }
        job.advance(1);
    }
    let seconds = started.elapsed().as_secs_f64();
    let pixels: usize = info.cameras.iter().map(|camera| camera.intrinsics.pixel_count()).sum();
    let input_bytes = INPUT_PIXEL_BYTES * (pixels * frames) as f64;
    let mut damage = playback.store().check_chunks()?;
    damage.extend(playback.store().damage());
    damage.extend(playback.store().check_verdicts().err().map(|error| error.to_string()));
    Ok(Verification {
        images: info.images.len(),
        frames,
        samples: info.sample_count(),
        bytes: info.bytes,
        seconds_to_first_frame,
        seconds,
        input_gb_per_s: input_bytes / seconds.max(1e-9) / 1e9,
        damage,
    })
}
