//! Size of the store of the whole capture. A budget of bytes is for what `preprocess` writes, with all frames and cameras, even
//! if tuning uses only some.

use overlook_engine::capture::Capture;
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::preprocess::{BufferedResult, preprocess_buffered};
use overlook_engine::settings::{RenderSettings, Settings};
use overlook_engine::store::file::{self, Extras, InputFiles, Provenance};

/// Stores of one capture, by their settings.
pub(super) struct WholeStores<'a> {
    capture: &'a Capture,
    /// Settings but for those of painting, and bytes.
    known: Vec<(Settings, u64)>,
}

impl<'a> WholeStores<'a> {
    pub(super) fn of(capture: &'a Capture) -> Self {
        Self { capture, known: Vec::new() }
    }

    /// Bytes that the store takes at most.
    pub(super) fn bytes(&mut self, settings: &Settings, job: &Job) -> Result<u64> {
        let of_samples = Settings { render: RenderSettings::default(), ..settings.clone() };
        let known = self.known.iter().find(|(known, _)| *known == of_samples).map(|(_, bytes)| *bytes);
        let bytes = known.map_or_else(|| most_bytes(self.capture, &of_samples, job), Ok)?;
        if known.is_none() {
            self.known.push((of_samples.clone(), bytes));
        }
        // A store also holds the settings of rendering; chunks are padded to even lengths.
        let words = |settings: &Settings| settings.to_toml().len().next_multiple_of(2) as u64;
        Ok(bytes - words(&of_samples) + words(settings))
    }

    /// The fewest bytes so far.
    pub(super) fn least(&self) -> Option<u64> {
        self.known.iter().map(|(_, bytes)| *bytes).min()
    }
}

/// Bytes of the store, with the longest record of where it comes from.
fn most_bytes(capture: &Capture, settings: &Settings, job: &Job) -> Result<u64> {
    let folder = tempfile::tempdir().map_err(|error| Error::io(std::env::temp_dir(), error))?;
    let BufferedResult { outline, images, report } = preprocess_buffered(capture, settings, job)?;
    let inputs = InputFiles { files: u64::MAX, bytes: u64::MAX, crc32: u32::MAX };
    let provenance = Provenance { inputs: Some(inputs), ..Provenance::default() };
    let extras = Extras { report: report.to_json()?, provenance, ..Extras::default() };
    let path = folder.path().join("whole.ovl");
    file::write_spooled(&path, &outline, &images, &extras, job)
}
