//! `overlook export points`, and each way out with no other arguments.

use std::path::PathBuf;

use clap::Args;

use crate::cli::input::StoreArgs;
use crate::cli::output::{self, CommandError};
use crate::ways_out::{Frames, Options, Shared, WayOut};
use overlook_engine::error::Error;
use overlook_engine::plural::counted;
use overlook_engine::render::film::FilmSource;

#[derive(Debug, Args)]
pub(crate) struct SamplesArgs {
    #[command(flatten)]
    from: StoreArgs,
    /// The file; without --frame and --static a folder, in which each frame gets a file.
    #[arg(long, value_name = "PATH")]
    out: PathBuf,
    /// Only this frame, by its number in the capture.
    #[arg(long, value_name = "NUMBER", conflicts_with = "still", allow_negative_numbers = true)]
    frame: Option<i64>,
    /// Only what stays the same over all frames.
    #[arg(long = "static")]
    still: bool,
}

impl SamplesArgs {
    pub(crate) fn run(self, way: &WayOut) -> Result<(), CommandError> {
        let Some((kinds, write)) = way.write else {
            return Err(Error::unsupported(way.command, "it is not made of samples alone").into());
        };
        let kind = &kinds[0];
        let is_file = self.frame.is_some() || self.still;
        let example = format!("{}.{}", kind.stem, kind.endings[0]);
        self.from.check_out(&self.out, is_file.then_some(&example))?;
        let playback = self.from.open()?;
        let frames = match self.from.frame(&playback, self.frame)? {
            Some(frame) => Frames::One(frame),
            None if self.still => Frames::Still,
            None => Frames::Every,
        };
        let (options, count) = (Options::default(), output::count_of);
        let shared = Shared { kind, options, frames, frames_per_second: 24.0, path: None, count };
        let source = FilmSource::Disk(playback.clone());
        output::export(&[playback], Some(&format!("a file of {}", way.command)), |job| {
            let (said, files) = write(&self.out, &source, &shared, job)?;
            Ok((format!("Wrote {said} to {} ({})", self.out.display(), counted(files, "file")), None))
        })
    }
}
