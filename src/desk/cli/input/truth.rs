//! The truth that `sweep`, `stress` and `tune` compare pictures with.

use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::RangedU64ValueParser;

use super::fingerprint;
use crate::cli::output::CommandError;
use overlook_engine::capture::{Capture, transforms};
use overlook_engine::plural::counted;
use overlook_lab::truth::{self, Truth};

/// Raised when the same input, truth and settings are measured differently.
const MEASURE: u32 = 1;

/// Options for the truth and for the frames to use.
#[derive(Debug, Args)]
pub(crate) struct TruthArgs {
    /// Vantages whose truth is known [default: the capture's novel/transforms.json, or else --cross-validate].
    #[arg(long, value_name = "TRANSFORMS", conflicts_with = "cross_validate")]
    pub(crate) views: Option<PathBuf>,
    /// Leave each camera out in turn and score against its frames, where the others could have seen what it saw.
    #[arg(long)]
    cross_validate: bool,
    /// Use only this many frames, spread over the capture, frames with truth among them.
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..))]
    pub(crate) frames: Option<usize>,
}

impl TruthArgs {
    /// The capture to work on, and its truth.
    pub(crate) fn open(&self, path: &Path, opened: &Capture) -> Result<(Capture, Truth), CommandError> {
        let truth = self.truth(path, opened)?;
        let Some(frames) = self.frames else { return Ok((opened.clone(), truth)) };
        Ok(truth::frames(opened, truth, frames)?)
    }

    /// The manifest of the views with truth, if there is one.
    fn views(&self, path: &Path) -> Option<PathBuf> {
        let beside = || if self.cross_validate { None } else { transforms::truth_beside(path) };
        self.views.clone().or_else(beside)
    }

    /// The truth at all frames.
    pub(crate) fn truth(&self, path: &Path, capture: &Capture) -> Result<Truth, CommandError> {
        match self.views(path) {
            Some(views) => Ok(Truth::Views(transforms::open_views_of(&views, capture.frames_are_ranked())?)),
            None if capture.cameras.len() >= Truth::HoldOut.least_cameras() => Ok(Truth::HoldOut),
            None => Err(CommandError::Usage(format!(
                "{} comes without truth views and has a single camera, which cannot be left out; name views with --views",
                path.display()
            ))),
        }
    }

    /// The truth in words.
    pub(crate) fn words(&self, capture: &Capture, truth: &Truth) -> String {
        let source = match (truth, &self.views) {
            (Truth::HoldOut, _) => "each camera left out in turn".to_owned(),
            (Truth::Views(_), Some(path)) => path.display().to_string(),
            (Truth::Views(_), None) => "the capture's own views".to_owned(),
        };
        format!("{source}; {}", counted(self.frames_looked_at(capture), "frame"))
    }

    fn frames_looked_at(&self, capture: &Capture) -> usize {
        self.frames.map_or(capture.frame_count(), |frames| frames.min(capture.frame_count()))
    }

    /// Identifies measurements that may be mixed: milliseconds depend on the number of threads, and the truth on the contents of
    /// its files. `opened` is the capture of `path` with all its frames.
    pub(crate) fn fingerprint(
        &self,
        path: &Path,
        opened: &Capture,
        truth: &Truth,
    ) -> Result<String, CommandError> {
        let source = match truth {
            Truth::HoldOut => "cameras left out",
            Truth::Views(_) => "views",
        };
        Ok(format!(
            "{}.{MEASURE} {} {:?} {source}; {} frames; {} threads; {}",
            env!("CARGO_PKG_VERSION"),
            opened.name,
            opened.frame_numbers,
            self.frames_looked_at(opened),
            rayon::current_num_threads(),
            fingerprint::state(path, opened, self.views(path).as_deref())?
        ))
    }
}
