//! A page that plays the scene.

use std::path::Path;

use super::shared::{FileKind, Options, Scope, Shared, Size, WayOut, temporary_folder};
use super::store::samples_of;
use crate::text::bytes;
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::page::{self, PageOptions, PageSummary};
use overlook_engine::render::film::FilmSource;
use overlook_engine::store::file::{Extras, Store, write_with};

pub(crate) const WAY: WayOut = WayOut {
    name: "Interactive page",
    used: "One HTML file that plays the scene from any viewpoint, in any browser and offline: to mail, to publish, or to put beside \
           a paper.",
    button: "Make the page…",
    command: "page",
    about: "One HTML file that plays the scene from any viewpoint, in any browser and offline",
    kind: |_| &PAGE,
    size,
    write: Some((&[PAGE], share)),
};

/// A page.
pub(crate) const PAGE: FileKind = FileKind::of_samples("Share an interactive page", &["html", "htm"], "");

/// Bytes of a page for each byte of its store, measured on built-in and recorded scenes (0.96 to 1.07), and of an empty page.
pub(crate) const PAGE_BY_STORE: f64 = 1.0;
pub(crate) const EMPTY_PAGE: f64 = 90e3;

fn size(scope: &Scope, options: &Options) -> Size {
    let size = EMPTY_PAGE + scope.facts.store_bytes * PAGE_BY_STORE;
    match options.page_at_most().map(|most| most as f64) {
        Some(most) if most < size => {
            Size::about(most, format!("made coarser from {}", bytes(size.round() as u64)))
        }
        _ => Size::about(size, samples_of(scope.facts.samples, size)),
    }
}

fn share(path: &Path, source: &FilmSource, shared: &Shared, job: &Job) -> Result<(String, usize)> {
    let some = |text: &str| (!text.trim().is_empty()).then(|| text.trim().to_owned());
    let options = PageOptions {
        scalar_bar: None,
        title: some(&shared.options.title),
        text: some(&shared.options.text),
        frames_per_second: shared.frames_per_second,
        path: shared.path.clone(),
        at_most: shared.options.page_at_most(),
    };
    let written = write(path, source, &options, job)?;
    let of = if written.samples < written.samples_of_store {
        format!(" in place of {}", (shared.count)(written.samples_of_store, "sample"))
    } else {
        String::new()
    };
    let samples = (shared.count)(written.samples, "sample");
    Ok((format!("a page of {} with {samples}{of}", bytes(written.bytes)), 1))
}

/// Writes the page. That of samples in memory is the page of their store, byte for byte.
///
/// # Errors
/// As [`page::write()`].
pub(crate) fn write(
    path: &Path,
    source: &FilmSource,
    options: &PageOptions,
    job: &Job,
) -> Result<PageSummary> {
    match source {
        FilmSource::Disk(playback) => page::write(path, playback.store(), options, job),
        FilmSource::Memory(samples) => {
            let folder = temporary_folder()?;
            let store = folder.path().join("scene.ovl");
            job.start("Rounding samples", 0);
            write_with(&store, samples, &Extras::default(), job)?;
            page::write(path, &Store::open(&store)?, options, job)
        }
    }
}
