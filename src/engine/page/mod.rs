//! One HTML file that plays a store in any browser: `assets/page/` with the kept samples packed into it.
//!
//! ```text
//! SampleSet ─ budget ─▶ images, some coarser ─ chunks ─▶ streams of bytes ─ gzip ─▶ base64 ─ html ─▶ scene.html
//!                                                          image_code
//! ```
//!
//! A sample is stored once, with the span that it holds for: its pixel, its inverse depth and its color. Position and footprint follow
//! from these in the page, as they do in the renderer. Inverse depth errs by as much as the store grants; color is 8-bit sRGB. What
//! browsers decompress by themselves is gzip, which knows no numbers: they are predicted from their neighbors, and what is left of
//! like kind is put side by side. `assets/page/decode.js` is the reader, and says the bytes.

mod budget;
mod chunks;
mod header;
mod html;
mod image_code;
mod options;

use std::path::Path;
use std::sync::Arc;

use crate::capture::in_perspective;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::plural::counted;
use crate::samples::SampleSet;
use crate::store::file::Store;
use crate::whole_file;

use chunks::{BEST, Packed, QUICK};

pub(crate) use budget::{Coarsening, LeveledImage};
pub(crate) use chunks::gzipped;

pub use budget::coarsened;
pub use html::escaped;
pub use options::{PageOptions, PagePath, PageScalarBar};

/// What was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PageSummary {
    /// Bytes of the file.
    pub bytes: u64,
    /// Samples in the page.
    pub samples: u64,
    /// Samples of the store.
    pub samples_of_store: u64,
}

/// Writes the page of a store.
///
/// # Errors
/// `Io`, `Cancelled`; `Invalid` where the store holds no sample, or where no page of it is as small as `at_most`. Nothing is written
/// then. Damaged parts of the store are left out: see [`Store::damage`].
pub fn write(path: &Path, store: &Store, options: &PageOptions, job: &Job) -> Result<PageSummary> {
    write_set(path, &store.read_all(job)?, options, job)
}

/// Writes the page of samples that are in memory.
///
/// # Errors
/// As [`write()`].
pub fn write_set(path: &Path, set: &SampleSet, options: &PageOptions, job: &Job) -> Result<PageSummary> {
    let text = page(set, options, job).map_err(|error| match error {
        Error::Invalid { what, .. } => Error::invalid(path.display(), what),
        other => other,
    })?;
    whole_file::write_all(path, &text.html)?;
    Ok(PageSummary {
        bytes: text.html.len() as u64,
        samples: text.samples,
        samples_of_store: set.sample_count(),
    })
}

/// A whole page, and the samples in it.
#[derive(Clone, Debug)]
pub struct PageText {
    /// The file's text.
    pub html: String,
    /// Samples in the page.
    pub samples: u64,
}

/// Halvings by which the largest page within a budget is searched for.
const SEARCH_STEPS: usize = 7;

/// Bytes of base64 for a byte.
const BASE64: f64 = 4.0 / 3.0;

/// A page that is estimated to have up to this many times the bytes that it may is tried: estimates err by some percent.
const MAY_FIT: f64 = 1.02;

/// Pages that turn out too large before the coarsest is taken, and how much more than by their excess estimates are then raised.
const MOST_MISSES: usize = 3;
const BEYOND_MISS: f64 = 1.005;

/// The page of samples that are in memory, as text.
///
/// # Errors
/// `Cancelled`; `Invalid` naming the capture where it holds no sample, or where no page of it is as small as `at_most`; `Unsupported`
/// where a camera is orthographic.
pub fn page(set: &SampleSet, options: &PageOptions, job: &Job) -> Result<PageText> {
    if set.sample_count() == 0 {
        return Err(Error::invalid(&set.name, "is not written: the store holds no sample that can be shown"));
    }
    in_perspective(
        &set.cameras,
        &set.name,
        "a page draws cameras in perspective alone; export splats or points",
    )?;
    let sky = header::sky_of(set)?;
    let pages = Pages { set, options, sky, job };
    let whole: Vec<_> = set.images.iter().map(|image| LeveledImage::fine(Arc::clone(image))).collect();
    match options.at_most {
        Some(most) => pages.within(most, &whole),
        None => pages.written(&whole),
    }
}

/// Pages of samples, some of which may be merged.
struct Pages<'a> {
    set: &'a SampleSet,
    options: &'a PageOptions,
    sky: Option<Vec<u8>>,
    job: &'a Job,
}

impl Pages<'_> {
    fn html(&self, packed: &Packed) -> Result<String> {
        let header = header::of(self.set, self.options, self.sky.as_deref(), packed)?;
        html::page(&header, self.options, packed, &self.set.name)
    }

    fn written(&self, images: &[LeveledImage]) -> Result<PageText> {
        let html = self.html(&chunks::pack(self.set, images, BEST, self.job)?)?;
        Ok(PageText { html, samples: images.iter().map(|image| image.samples.len() as u64).sum() })
    }

    /// The bytes of a page without its chunks, and those of its chunks by the quick compression.
    fn parts(&self, images: &[LeveledImage]) -> Result<[f64; 2]> {
        let packed = chunks::pack(self.set, images, QUICK, self.job)?;
        let bytes: usize = packed.chunks.iter().map(|chunk| chunk.bytes.len()).sum();
        let chunks = bytes as f64 * BASE64;
        Ok([self.html(&packed)?.len() as f64 - chunks, chunks])
    }

    /// About the bytes of a page, given those by the best compression for each byte by the quick one.
    fn estimated(&self, images: &[LeveledImage], best_to_quick: f64) -> Result<f64> {
        let [rest, chunks] = self.parts(images)?;
        Ok(rest + chunks * best_to_quick)
    }

    /// The finest page of at most so many bytes. Sizes are estimated while it is searched for; a page that misses is corrected for.
    fn within(&self, most: u64, whole: &[LeveledImage]) -> Result<PageText> {
        let mut best_to_quick = chunks::best_to_quick(self.set, whole)?;
        if self.estimated(whole, best_to_quick)? <= most as f64 * MAY_FIT {
            let page = self.written(whole)?;
            if page.html.len() as u64 <= most {
                return Ok(page);
            }
        }
        let coarsening = Coarsening::new(self.set, self.job)?;
        for _ in 0..MOST_MISSES {
            let found = coarsening.finest(SEARCH_STEPS, |images| {
                Ok((self.estimated(images, best_to_quick)? <= most as f64).then(|| images.to_vec()))
            })?;
            let Some(images) = found else { break };
            let page = self.written(&images)?;
            if page.html.len() as u64 <= most {
                return Ok(page);
            }
            let [rest, chunks] = self.parts(&images)?;
            best_to_quick = (page.html.len() as f64 - rest) / chunks * BEYOND_MISS;
        }
        let coarsest = self.written(&coarsening.coarsest())?;
        let bytes = coarsest.html.len() as u64;
        if bytes <= most {
            return Ok(coarsest);
        }
        let what = format!(
            "is not written: at its coarsest the page takes {}, more than the {most} that it may",
            counted(bytes, "byte")
        );
        Err(Error::invalid(&self.set.name, what))
    }
}
