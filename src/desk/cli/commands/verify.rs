//! `overlook verify`: whether everything in a store can be read, and what cannot.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use serde::Serialize;

use crate::cli::output::{self, CommandError};
use overlook_engine::error::Error;
use overlook_engine::job::Job;
use overlook_engine::plural::counted;
use overlook_engine::render::{CpuRenderer, Vantage};
use overlook_engine::store::file::Store;
use overlook_engine::store::playback::{DEFAULT_CACHE_BYTES, Playback, Verification, verify};

#[derive(Debug, Args)]
pub(crate) struct VerifyArgs {
    /// The store.
    store: PathBuf,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct VerifyOutput {
    /// Seconds from opening the file to a picture of its first frame from its first camera; `None` if that cannot be rendered.
    seconds_to_first_picture: Option<f64>,
    #[serde(flatten)]
    verified: Verification,
}

/// Opens the store anew and paints its first frame, on the CPU.
fn seconds_to_first_picture(path: &Path, job: &Job) -> Option<f64> {
    let started = Instant::now();
    let playback = Playback::new(Store::open(path).ok()?, DEFAULT_CACHE_BYTES);
    let camera = playback.outline().cameras.first()?.clone();
    let samples = playback.seen_from(&camera, 0, job).ok()?;
    let settings = playback.store().info().settings.render.clone();
    let painted = CpuRenderer::new().render(&samples, &Vantage { camera, frame: 0 }, &settings, job);
    painted.is_ok().then(|| started.elapsed().as_secs_f64())
}

impl VerifyArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        let (seconds_to_first_picture, verified) = output::watched(|job| {
            let seconds = seconds_to_first_picture(&self.store, job);
            Ok::<_, Error>((seconds, verify(&self.store, job)?))
        })?;
        output::warn(&verified.damage);
        if self.json {
            output::print_json(&VerifyOutput { seconds_to_first_picture, verified: verified.clone() })?;
        } else if verified.damage.is_empty() {
            let picture = seconds_to_first_picture
                .map_or(String::new(), |seconds| format!(", a picture of it after {:.0} ms", 1e3 * seconds));
            let samples = output::count_of(verified.samples, "sample");
            let images = output::count_of(verified.images as u64, "image");
            let (bytes, first_ms) = (output::bytes(verified.bytes), 1e3 * verified.seconds_to_first_frame);
            let Verification { frames, seconds, input_gb_per_s, .. } = verified;
            output::print(&format!(
                "{} is whole: {samples} in {images}, {bytes}\nPlayed {} in {seconds:.2} s, \
                 {input_gb_per_s:.2} GB/s of input; the first frame's samples were there after {first_ms:.0} ms{picture}",
                self.store.display(),
                counted(frames, "frame")
            ))?;
        }
        if verified.damage.is_empty() {
            return Ok(());
        }
        let parts = verified.damage.len();
        let what =
            format!("{parts} parts are damaged (see above); copy it again or preprocess the capture again");
        Err(CommandError::Work(Error::invalid(self.store.display(), what)))
    }
}
