//! A film file, written by the ffmpeg on this machine.

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

/// Players want 4:2:0, which wants even sides. Left to itself, ffmpeg would use the matrix of standard definition, whatever
/// the size, and players that of high definition: greens and reds would shift.
const FILTERS: &str = "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv";

/// What the numbers mean, so that no player has to guess: Rec.709 primaries and matrix, sRGB's own curve, and the range of
/// television.
const COLOR_TAGS: [&str; 8] =
    ["-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "iec61966-2-1", "-color_range", "tv"];

/// Bytes of what a failing ffmpeg says that are told.
const MOST_SAID: u64 = 2000;
/// How often is looked whether the film is whole.
const PATIENCE: Duration = Duration::from_millis(10);

/// A running ffmpeg that is given one picture after another. The film takes its name once it is whole: dropped before
/// [`FilmEncoder::finish`], nothing is left of it, and what had that name before stays.
pub struct FilmEncoder {
    ffmpeg: Child,
    pipe: Option<ChildStdin>,
    /// What it says: a file, as a pipe that is full would hold it up.
    words: File,
    /// What is written until it is whole and takes its name.
    unfinished: Option<tempfile::TempPath>,
    out: PathBuf,
}

impl FilmEncoder {
    /// Starts ffmpeg on a film of `width` by `height` pixels; its format is that which `out` is named after, as in `film.mp4`.
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
        let words = tempfile::tempfile().map_err(|error| Error::io(std::env::temp_dir(), error))?;
        command.stderr(words.try_clone().map_err(|error| Error::io(std::env::temp_dir(), error))?);
        // Ctrl-C in a terminal reaches every process of its group; how the film ends is decided here.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut ffmpeg = command.spawn().map_err(|error| match error.kind() {
            ErrorKind::NotFound => Error::unsupported(
                out.display(),
                "there is no ffmpeg on this machine's PATH to write a film with; install it, or export pictures instead",
            ),
            _ => Error::io("ffmpeg", error),
        })?;
        let pipe = ffmpeg.stdin.take();
        Ok(Self { ffmpeg, pipe, words, unfinished: Some(unfinished), out: out.to_path_buf() })
    }

    /// Adds a picture of the size that was named at the start. Holes are black.
    ///
    /// # Errors
    /// `Invalid` with what ffmpeg said, where it failed.
    pub fn add(&mut self, picture: &Picture) -> Result<()> {
        let bytes: Vec<u8> =
            picture.color.as_slice().iter().flatten().map(|channel| srgb8_from_linear(*channel)).collect();
        let written = self.pipe.as_mut().map(|pipe| pipe.write_all(&bytes));
        if matches!(written, Some(Ok(()))) {
            return Ok(());
        }
        // It went away: what it has to say stands on its stderr.
        self.pipe = None;
        let status = self.ffmpeg.wait();
        let said = status.map_err(|error| error.to_string()).and_then(|status| self.said(status));
        Err(self.failed(&said.err().unwrap_or_else(|| "it takes no more pictures".to_owned())))
    }

    /// Waits until the film is whole.
    ///
    /// # Errors
    /// `Invalid` with what ffmpeg said, where it failed; `Io` where the film cannot take its name; `Cancelled`.
    pub fn finish(mut self, job: &Job) -> Result<()> {
        self.pipe = None;
        let status = loop {
            job.check()?;
            match self.ffmpeg.try_wait().map_err(|error| Error::io("ffmpeg", error))? {
                Some(status) => break status,
                None => std::thread::sleep(PATIENCE),
            }
        };
        self.said(status).map_err(|what| self.failed(&what))?;
        let unfinished = self.unfinished.take();
        unfinished.map_or(Ok(()), |unfinished| whole_file::persist(unfinished, &self.out))
    }

    /// What ffmpeg said where it failed.
    fn said(&mut self, status: ExitStatus) -> std::result::Result<(), String> {
        if status.success() {
            return Ok(());
        }
        let mut said = Vec::new();
        let _ = self.words.rewind().and_then(|()| (&self.words).take(MOST_SAID).read_to_end(&mut said));
        Err(format!("{status}: {}", String::from_utf8_lossy(&said).trim().replace('\n', "; ")))
    }

    fn failed(&self, what: &str) -> Error {
        Error::invalid(self.out.display(), format!("ffmpeg failed: {what}"))
    }
}

impl Drop for FilmEncoder {
    fn drop(&mut self) {
        // Of a film that is whole there is no process left to end.
        let _ = self.ffmpeg.kill();
        let _ = self.ffmpeg.wait();
    }
}
