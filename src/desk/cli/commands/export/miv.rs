//! `overlook export miv`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::input::EditsArgs;
use crate::cli::output::{self, CommandError};
use overlook_engine::capture::miv::write_sequence;
use overlook_engine::error::Error;
use overlook_engine::plural::counted;
use overlook_engine::settings::CaptureSettings;

#[derive(Debug, Args)]
pub(crate) struct MivArgs {
    /// The capture.
    capture: PathBuf,
    /// Folder for NAME.json and the raw video below NAME.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Name of the sequence [default: the capture's].
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    #[command(flatten)]
    edits: EditsArgs,
}

impl MivArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        output::check_folder(&self.out)?;
        let capture = self.edits.open_capture(&self.capture, &CaptureSettings::default())?;
        let name = self.name.unwrap_or_else(|| capture.name.clone());
        if name.is_empty() || name.starts_with('.') || name.contains(['/', '\\']) {
            let what = format!("'{name}' names no folder; give another --name");
            return Err(Error::invalid(self.out.display(), what).into());
        }
        let sequence = self.out.join(format!("{name}.json"));
        output::refuse_capture_files(&self.capture, None, &sequence)?;
        self.edits.refuse_inputs(&sequence)?;
        let inputs = capture.files();
        let content = self.out.join(&name).canonicalize();
        let is_read = |file: &PathBuf| {
            let folder = file.parent().and_then(|folder| folder.canonicalize().ok());
            content.as_ref().is_ok_and(|content| folder.as_ref() == Some(content))
        };
        if inputs.iter().any(is_read) {
            let what = "holds the pictures of this capture; name another folder with --out";
            return Err(Error::invalid(self.out.join(&name).display(), what).into());
        }
        output::watched(|job| write_sequence(&self.out, &name, &capture, job))?;
        output::warn_of_values(capture.value_channels(), "MPEG immersive video");
        output::print(&format!(
            "Wrote {}, {}, to {}",
            counted(capture.cameras.len(), "camera"),
            counted(capture.frame_count(), "frame"),
            sequence.display()
        ))
    }
}
