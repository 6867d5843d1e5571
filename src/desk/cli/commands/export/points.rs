//! `overlook export points`.

use std::path::{Path, PathBuf};

use clap::Args;

use super::ply;
use crate::cli::input;
use crate::cli::output::{self, CommandError};
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::plural::counted;
use overlook_engine::store::playback::Playback;

#[derive(Debug, Args)]
pub(crate) struct PointsArgs {
    /// The store.
    store: PathBuf,
    /// The PLY file; without --frame and --static a folder, in which each frame gets a file.
    #[arg(long, value_name = "PATH")]
    out: PathBuf,
    /// Only this frame, by its number in the capture.
    #[arg(long, value_name = "NUMBER", conflicts_with = "still", allow_negative_numbers = true)]
    frame: Option<i64>,
    /// Only what stays the same over all frames.
    #[arg(long = "static")]
    still: bool,
}

impl PointsArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        output::refuse_input(&self.store, &self.out)?;
        if self.frame.is_some() || self.still {
            output::check_file(&self.out, "points.ply")?;
            output::refuse_store(&self.out)?;
        } else {
            output::check_folder(&self.out)?;
        }
        let playback = input::open_store(&self.store)?;
        let (files, points) = output::watched(|job| self.write(&playback, job))?;
        output::warn(&playback.store().damage());
        let (points, out) = (output::count_of(points, "point"), self.out.display());
        output::print(&format!("Wrote {points} to {out} ({})", counted(files, "file")))
    }

    /// Gives how many files and points were written.
    fn write(&self, playback: &Playback, job: &Job) -> Result<(usize, u64)> {
        let info = playback.store().info();
        let frames = info.frame_numbers.len();
        if let Some(number) = self.frame {
            let frame = info.frame_numbers.binary_search(&number).map_err(|_| {
                Error::invalid(self.store.display(), format!("there is no frame {number} in it"))
            })?;
            return Ok((1, write_frame(&self.out, playback, frame, |_| true, job)?));
        }
        if self.still {
            return Ok((1, write_frame(&self.out, playback, 0, |span| span == frames, job)?));
        }
        std::fs::create_dir_all(&self.out).map_err(|error| Error::io(&self.out, error))?;
        job.start("Writing points", frames);
        let mut points = 0;
        for (frame, number) in info.frame_numbers.iter().enumerate() {
            let path = self.out.join(format!("{number:04}.ply"));
            points += write_frame(&path, playback, frame, |_| true, job)?;
            job.advance(1);
        }
        Ok((frames, points))
    }
}

/// Writes the samples of a frame whose spans have a length that is `wanted`.
fn write_frame(
    path: &Path,
    playback: &Playback,
    frame: usize,
    wanted: impl Fn(usize) -> bool,
    job: &Job,
) -> Result<u64> {
    let set = playback.at(frame, job)?;
    let images = set.images.iter().filter(|image| wanted(image.span.len())).map(|image| &**image);
    ply::write(path, &set, images)
}
