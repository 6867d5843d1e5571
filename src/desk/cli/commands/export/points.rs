//! `overlook export points`.

use std::path::{Path, PathBuf};

use clap::Args;

use super::frame_files::{frame_index, write_frames};
use crate::cli::input::EditsArgs;
use crate::cli::output::{self, CommandError};
use crate::points;
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::plural::counted;
use overlook_engine::samples::SampleSet;
use overlook_engine::store::playback::Playback;

#[derive(Debug, Args)]
pub(crate) struct PointsArgs {
    /// The store.
    store: PathBuf,
    #[command(flatten)]
    edits: EditsArgs,
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
        self.edits.refuse_inputs(&self.out)?;
        if self.frame.is_some() || self.still {
            output::check_file(&self.out, "points.ply")?;
            output::refuse_store(&self.out)?;
        } else {
            output::check_folder(&self.out)?;
        }
        let playback = self.edits.open_store(&self.store)?;
        let (files, points) = output::watched(|job| self.write(&playback, job))?;
        output::warn(&playback.store().damage());
        output::warn_of_values(&playback.outline().values, "a file of points");
        let (points, out) = (output::count_of(points, "point"), self.out.display());
        output::print(&format!("Wrote {points} to {out} ({})", counted(files, "file")))
    }

    /// Gives how many files and points were written.
    fn write(&self, playback: &Playback, job: &Job) -> Result<(usize, u64)> {
        let at = |frame: usize| playback.at(frame, job);
        if let Some(number) = self.frame {
            let set = at(frame_index(playback, number, &self.store)?)?;
            return Ok((1, write_points(&self.out, &set, |_| true)?));
        }
        if self.still {
            let frames = playback.outline().frame_count();
            return Ok((1, write_points(&self.out, &*at(0)?, |span| span == frames)?));
        }
        let points =
            write_frames(&self.out, "ply", playback, job, |path, set, _| write_points(path, set, |_| true))?;
        Ok((points.len(), points.iter().sum()))
    }
}

/// Writes the samples of a set whose spans have a length that is `wanted`.
fn write_points(path: &Path, set: &SampleSet, wanted: impl Fn(usize) -> bool) -> Result<u64> {
    let images = set.images.iter().filter(|image| wanted(image.span.len())).map(|image| &**image);
    points::write(path, set, images)
}
