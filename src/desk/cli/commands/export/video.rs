//! `overlook export video`.

use std::path::PathBuf;

use clap::Args;

use super::pictures::{FilmArgs, paint};
use crate::cli::output::{self, CommandError};
use overlook_engine::error::Error;
use overlook_engine::plural::counted;
use overlook_engine::render::film::FilmEncoder;

#[derive(Debug, Args)]
pub(crate) struct VideoArgs {
    #[command(flatten)]
    film: FilmArgs,
    /// The video file, as in video.mp4.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Frames a second.
    #[arg(long, default_value_t = 24.0, value_parser = frames_per_second)]
    fps: f64,
}

pub(super) fn frames_per_second(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if (0.1..=1000.0).contains(&number) { Ok(number) } else { Err("must be between 0.1 and 1000".to_owned()) }
}

impl VideoArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        output::check_file(&self.out, "video.mp4")?;
        let (playback, stops, settings) = self.film.plan()?;
        self.film.refuse_inputs(&self.out)?;
        let (width, height) = stops.vantages[0].camera.intrinsics.size();
        let mut encoder = FilmEncoder::start(&self.out, [width, height], self.fps)?;
        let notice = output::watched(|job| {
            let painted = paint(&playback, &stops, &settings, job, |_, picture| encoder.add(picture));
            let written = painted.and_then(|notice| encoder.finish(job).map(|()| notice));
            // Who stops a film may have stopped ffmpeg with it, which is no failure of that.
            written.map_err(|error| if job.is_cancelled() { Error::Cancelled } else { error })
        })?;
        output::warn(notice.as_slice());
        output::warn(&playback.store().damage());
        output::print(&format!("Wrote {} to {}", counted(stops.numbers.len(), "frame"), self.out.display()))
    }
}
