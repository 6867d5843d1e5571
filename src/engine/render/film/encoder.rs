//! A film file, written by the ffmpeg of this machine.

use std::fs::File;
use std::io::{ErrorKind, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::time::Duration;

use crate::color::srgb8_from_linear;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::render::vantage::Picture;
use crate::whole_file;

/// Players need 4:2:0, which needs even sides. By default ffmpeg uses the color matrix of standard definition and players that of
/// high definition: greens and reds would shift.
const FILTERS: &str = "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv";

/// The color space, for players: Rec.709 primaries and matrix, the sRGB curve, and television range.
const COLOR_TAGS: [&str; 8] =
    ["-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "iec61966-2-1", "-color_range", "tv"];

/// Bytes of ffmpeg's error output that an error quotes at most.
const MAX_QUOTED: u64 = 2000;

/// How often it is checked whether ffmpeg has ended.
const POLL_INTERVAL: Duration = Duration::from_millis(10);

/// A running ffmpeg that encodes one picture after another. The film takes its name when it is complete: dropped before
/// [`FilmEncoder::finish`] it leaves nothing behind, and an earlier file of that name stays.
pub struct FilmEncoder {
    ffmpeg: Child,
    pipe: Option<ChildStdin>,
    /// Its error output: a file, because a full pipe would block it.
    stderr: File,
    /// The file until it is complete.
    unfinished: Option<tempfile::TempPath>,
    out: PathBuf,
}

impl FilmEncoder {
    /// Starts ffmpeg on a film of `width` by `height` pixels, in the format of the extension of `out`, as in `film.mp4`.
    ///
    /// # Errors
    /// `Unsupported` where there is no ffmpeg, `Io` where it cannot be started or the folder cannot be written.
    pub fn start(out: &Path, [width, height]: [usize; 2], frames_per_second: f64) -> Result<Self> {
        let extension = out.extension().map_or("mp4".into(), |extension| extension.to_string_lossy());
        let unfinished = whole_file::beside(out, &format!(".{extension}"))?.into_temp_path();
        let mut command = Command::new("ffmpeg");
        command.args(["-v", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24"]);
        command.args(["-s", &format!("{width}x{height}"), "-r", &frames_per_second.to_string(), "-i", "-"]);
        command.args(["-vf", FILTERS, "-c:v", "libx264", "-crf", "16", "-pix_fmt", "yuv420p"]);
        command.args(COLOR_TAGS).args(["-movflags", "+faststart"]).arg(&unfinished);
        command.stdin(Stdio::piped()).stdout(Stdio::null());
        let stderr = tempfile::tempfile().map_err(|error| Error::io(std::env::temp_dir(), error))?;
        command.stderr(stderr.try_clone().map_err(|error| Error::io(std::env::temp_dir(), error))?);
        // Ctrl-C in a terminal reaches every process of its group; only this program may end ffmpeg.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut ffmpeg = command.spawn().map_err(|error| match error.kind() {
            ErrorKind::NotFound => Error::unsupported(
                out.display(),
                "there is no ffmpeg on this machine's PATH to write a video with; install it, or export pictures instead",
            ),
            _ => Error::io("ffmpeg", error),
        })?;
        let pipe = ffmpeg.stdin.take();
        Ok(Self { ffmpeg, pipe, stderr, unfinished: Some(unfinished), out: out.to_path_buf() })
    }

    /// Adds a picture of the size given at the start. Holes are black.
    ///
    /// # Errors
    /// `Invalid` with ffmpeg's error output, where it failed.
    pub fn add(&mut self, picture: &Picture) -> Result<()> {
        let bytes: Vec<u8> =
            picture.color.as_slice().iter().flatten().map(|channel| srgb8_from_linear(*channel)).collect();
        let written = self.pipe.as_mut().map(|pipe| pipe.write_all(&bytes));
        if matches!(written, Some(Ok(()))) {
            return Ok(());
        }
        // It ended: the reason is in its error output.
        self.pipe = None;
        let status = self.ffmpeg.wait();
        let ended = status.map_err(|error| error.to_string()).and_then(|status| self.check(status));
        Err(self.failed(&ended.err().unwrap_or_else(|| "it takes no more pictures".to_owned())))
    }

    /// Waits until the film is complete.
    ///
    /// # Errors
    /// `Invalid` with ffmpeg's error output, where it failed; `Io` where the film cannot take its name; `Cancelled`.
    pub fn finish(mut self, job: &Job) -> Result<()> {
        self.pipe = None;
        let status = loop {
            job.check()?;
            match self.ffmpeg.try_wait().map_err(|error| Error::io("ffmpeg", error))? {
                Some(status) => break status,
                None => std::thread::sleep(POLL_INTERVAL),
            }
        };
        self.check(status).map_err(|what| self.failed(&what))?;
        let unfinished = self.unfinished.take();
        unfinished.map_or(Ok(()), |unfinished| whole_file::persist(unfinished, &self.out))
    }

    /// The error output of ffmpeg, if it failed.
    fn check(&mut self, status: ExitStatus) -> std::result::Result<(), String> {
        if status.success() {
            return Ok(());
        }
        let mut output = Vec::new();
        let _ = self.stderr.rewind().and_then(|()| (&self.stderr).take(MAX_QUOTED).read_to_end(&mut output));
        Err(format!("{status}: {}", String::from_utf8_lossy(&output).trim().replace('\n', "; ")))
    }

    fn failed(&self, what: &str) -> Error {
        Error::invalid(self.out.display(), format!("ffmpeg failed: {what}"))
    }
}

impl Drop for FilmEncoder {
    fn drop(&mut self) {
        // Both fail, without harm, if ffmpeg has ended.
        let _ = self.ffmpeg.kill();
        let _ = self.ffmpeg.wait();
    }
}
