//! `overlook verify`: whether everything in a store can be read, and what cannot.

use std::path::PathBuf;

use clap::Args;

use super::{Failure, output, progress};
use crate::error::Error;
use crate::store;

/// Arguments of `overlook verify`.
#[derive(Debug, Args)]
pub(super) struct VerifyArgs {
    /// The store.
    store: PathBuf,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

impl VerifyArgs {
    pub(super) fn run(self) -> Result<(), Failure> {
        let verified = progress::watched(|job| store::verify(&self.store, job))?;
        output::warn(&verified.damage);
        if self.json {
            output::print_json(&verified)?;
        } else if verified.damage.is_empty() {
            output::print(&format!(
                "{} is whole: {} samples in {} images, {}\nPlayed {} frames in {:.2} s, {:.2} GB/s of input; the first after {:.0} ms",
                self.store.display(),
                output::count(verified.samples),
                output::count(verified.images as u64),
                output::bytes(verified.bytes),
                verified.frames,
                verified.seconds,
                verified.input_gb_per_s,
                1e3 * verified.seconds_to_first_frame
            ))?;
        }
        if verified.damage.is_empty() {
            return Ok(());
        }
        Err(Failure::Work(Error::invalid(
            self.store.display(),
            format!(
                "{} parts are damaged (see above); copy it again or preprocess the capture again",
                verified.damage.len()
            ),
        )))
    }
}
