//! `overlook export video`.

use std::io::{ErrorKind, Read, Write};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};

use clap::Args;

use super::super::{Failure, output, progress};
use super::pictures::{FilmArgs, paint};
use crate::color::srgb8_from_linear;
use crate::error::{Error, Result};
use crate::render::Picture;

/// Arguments of `overlook export video`.
#[derive(Debug, Args)]
pub(super) struct VideoArgs {
    #[command(flatten)]
    film: FilmArgs,
    /// The film, as in film.mp4.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Frames a second.
    #[arg(long, default_value_t = 24.0, value_parser = frames_per_second)]
    fps: f64,
}

fn frames_per_second(text: &str) -> std::result::Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if (0.1..=1000.0).contains(&number) {
        Ok(number)
    } else {
        Err("must lie between 0.1 and 1000".to_owned())
    }
}

impl VideoArgs {
    pub(super) fn run(self) -> Result<(), Failure> {
        let playback = super::open(&self.film.store)?;
        let (stops, settings) = self.film.plan(&playback)?;
        let size = stops[0].camera.intrinsics.size();
        let mut ffmpeg = self.start(size)?;
        let mut pipe = ffmpeg.stdin.take();
        let painted = progress::watched(|job| {
            paint(&playback, &stops, &settings, job, |_, picture| {
                let pipe = pipe.as_mut().ok_or_else(|| self.failed("it takes no pictures"))?;
                // What ffmpeg has to say stands on its stderr, and is told below.
                pipe.write_all(&bytes(picture)).map_err(|error| Error::io("ffmpeg", error))
            })
        });
        drop(pipe);
        if matches!(painted, Err(Error::Cancelled)) {
            let _ = ffmpeg.kill();
        }
        let said = finish(ffmpeg);
        painted.map_err(|error| {
            if matches!(error, Error::Io { .. }) {
                said.clone().err().map_or(error, |what| self.failed(&what))
            } else {
                error
            }
        })?;
        said.map_err(|what| self.failed(&what))?;
        output::warn(&playback.store().damage());
        output::print(&format!("Wrote {} frames to {}", stops.len(), self.out.display()))
    }

    fn start(&self, (width, height): (usize, usize)) -> Result<Child> {
        let mut command = Command::new("ffmpeg");
        command.args(["-v", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24"]);
        command.args(["-s", &format!("{width}x{height}"), "-r", &self.fps.to_string(), "-i", "-"]);
        // Players want 4:2:0, which wants even sides.
        command.args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-c:v", "libx264", "-crf", "16"]);
        command.args(["-pix_fmt", "yuv420p", "-movflags", "+faststart"]).arg(&self.out);
        command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        command.spawn().map_err(|error| match error.kind() {
            ErrorKind::NotFound => Error::unsupported(
                self.out.display(),
                "there is no ffmpeg on this machine's PATH; install it, or use overlook export pictures",
            ),
            _ => Error::io("ffmpeg", error),
        })
    }

    fn failed(&self, what: &str) -> Error {
        Error::invalid(self.out.display(), format!("ffmpeg failed: {what}"))
    }
}

/// Waits for ffmpeg; what it said where it failed.
fn finish(mut ffmpeg: Child) -> std::result::Result<(), String> {
    let mut said = String::new();
    if let Some(stderr) = &mut ffmpeg.stderr {
        let _ = stderr.read_to_string(&mut said);
    }
    let status = ffmpeg.wait().map_err(|error| error.to_string())?;
    if status.success() { Ok(()) } else { Err(format!("{status}: {}", said.trim().replace('\n', "; "))) }
}

/// 8-bit sRGB, three bytes a pixel. Holes are black.
fn bytes(picture: &Picture) -> Vec<u8> {
    picture.color.as_slice().iter().flatten().map(|channel| srgb8_from_linear(*channel)).collect()
}
