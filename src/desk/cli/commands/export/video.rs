//! `overlook export video`.

use std::path::PathBuf;

use clap::Args;

use super::pictures::FilmArgs;
use crate::cli::output::{self, CommandError};
use overlook_engine::plural::counted;
use overlook_engine::render::film::FilmEncoder;

#[derive(Debug, Args)]
pub(crate) struct VideoArgs {
    #[command(flatten)]
    film: FilmArgs,
    /// The video file, as in video.mp4: H.264, which every player and browser shows.
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
        let film = self.film.plan(self.fps)?;
        self.film.refuse_inputs(&self.out)?;
        let notice = output::watched(|job| {
            // Only now does Ctrl-C clean up.
            let mut encoder = FilmEncoder::start(&self.out, film.size(), self.fps)?;
            if film.panorama.is_some() {
                encoder.mark_equirectangular();
            }
            let painted = film.paint(job, |_, frame| encoder.add(frame.shown()));
            painted.and_then(|notice| encoder.finish(job).map(|()| notice))
        })?;
        output::warn(notice.as_slice());
        output::warn(&film.damage());
        output::print(&format!(
            "Wrote {} to {}",
            counted(film.stops.numbers.len(), "frame"),
            self.out.display()
        ))
    }
}
