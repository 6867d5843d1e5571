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
    let written = |images: &[LeveledImage]| -> Result<PageText> {
        let packed = chunks::pack(set, images, job)?;
        let html =
            html::page(&header::of(set, options, sky.as_deref(), &packed)?, options, &packed, &set.name)?;
        Ok(PageText { html, samples: images.iter().map(|image| image.samples.len() as u64).sum() })
    };
    let whole: Vec<_> = set.images.iter().map(|image| LeveledImage::fine(Arc::clone(image))).collect();
    let Some(most) = options.at_most else { return written(&whole) };
    let finest = written(&whole)?;
    if finest.html.len() as u64 <= most {
        return Ok(finest);
    }
    let mut tried_bytes = 0;
    let best = Coarsening::new(set, job)?.finest(SEARCH_STEPS, |images| {
        let tried = written(images)?;
        tried_bytes = tried.html.len() as u64;
        Ok((tried_bytes <= most).then_some(tried))
    })?;
    best.ok_or_else(|| {
        // Nothing but the coarsest was tried.
        let what = format!(
            "is not written: at its coarsest the page takes {}, more than the {most} that it may",
            counted(tried_bytes, "byte")
        );
        Error::invalid(&set.name, what)
    })
}
