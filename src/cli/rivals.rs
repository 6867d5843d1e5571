//! What the input takes in other lossless forms: `overlook preprocess --measure-rivals`.
//!
//! ZIP-compressed EXR with half-float color and 32-bit depth, what captures come as; and video with motion between frames, made by
//! the ffmpeg on this machine where there is one: color in 8-bit sRGB as lossless H.264, inverse depth in 16 bits, scaled to each camera's
//! nearest point, as FFV1. The same bytes, each frame xor the one before, through the zstd on this machine are what two lines of code get.

use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use rayon::prelude::*;

use crate::capture::{Capture, Frame, exr_write};
use crate::color::srgb8_from_linear;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::store::{InputFiles, Rivals};

/// Largest number of a 16-bit pixel.
const LARGEST: f32 = 65_535.0;

/// Measures all rivals; those that need an ffmpeg or a zstd are `None` where there is none, and where it fails: what it said is a
/// warning.
///
/// # Errors
/// Whatever decoding the capture gives, `Io`, `Cancelled`.
pub(super) fn measure(capture: &Capture, job: &Job) -> Result<Rivals> {
    let folder = tempfile::tempdir().map_err(|error| Error::io(std::env::temp_dir(), error))?;
    let zip_exr = zip_exr(capture, folder.path(), job)?;
    let (ffmpeg, zstd) = (is_there("ffmpeg", "-version"), is_there("zstd", "--version"));
    if !ffmpeg && !zstd {
        return Ok(Rivals { zip_exr, ..Rivals::default() });
    }
    let form = |name, is_there: bool| is_there.then(|| Form::new(name, folder.path()));
    let mut color = form("lossless video of color", ffmpeg);
    let mut depth = form("lossless video of depth", ffmpeg);
    let mut changes = form("each frame xor the one before", zstd);
    job.start("Measuring other forms", 2 * capture.cameras.len() * capture.frame_count());
    for (camera, named) in capture.cameras.iter().enumerate() {
        let size = named.intrinsics.size();
        if let Some(color) = &mut color {
            color.start("ffmpeg", &video("rgb24", size, &["-c:v", "libx264rgb", "-qp", "0"]), "color.mkv");
        }
        if let Some(depth) = &mut depth {
            let codec = ["-c:v", "ffv1", "-level", "3", "-coder", "2"];
            depth.start("ffmpeg", &video("gray16le", size, &codec), "depth.mkv");
        }
        if let Some(changes) = &mut changes {
            changes.start("zstd", &["-3", "-q", "-f", "-o"].map(str::to_owned), "xor.zst");
        }
        let mut before = Vec::new();
        displayed(capture, camera, job, |rgb, gray| {
            for (form, bytes) in [(&mut color, rgb), (&mut depth, gray)] {
                if let Some(form) = form {
                    form.feed(bytes);
                }
            }
            if let Some(changes) = &mut changes {
                changes.feed(&xor(&mut before, [rgb, gray].concat()));
            }
        })?;
        [&mut color, &mut depth, &mut changes].into_iter().flatten().for_each(Form::finish);
    }
    let [video_color, video_depth, xor_zstd] = [color, depth, changes].map(|form| form?.measured(job));
    Ok(Rivals { zip_exr, video_color, video_depth, xor_zstd })
}

fn is_there(program: &str, argument: &str) -> bool {
    let found = Command::new(program).arg(argument).stdout(Stdio::null()).stderr(Stdio::null()).status();
    found.is_ok_and(|status| status.success())
}

fn size_of(path: &Path) -> Result<u64> {
    Ok(std::fs::metadata(path).map_err(|error| Error::io(path, error))?.len())
}

fn zip_exr(capture: &Capture, folder: &Path, job: &Job) -> Result<u64> {
    let (cameras, frames) = (capture.cameras.len(), capture.frame_count());
    job.start("Measuring EXR", cameras * frames);
    let sizes = (0..cameras * frames).into_par_iter().map(|index| {
        job.check()?;
        let frame = capture.frame(index / frames, index % frames)?;
        let path = folder.join(format!("{index}.exr"));
        let bare = Frame { normal_in_world: None, ..(*frame).clone() };
        exr_write::write_frame(&path, &bare)?;
        let size = size_of(&path)?;
        std::fs::remove_file(&path).map_err(|error| Error::io(&path, error))?;
        job.advance(1);
        Ok(size)
    });
    sizes.sum()
}

/// Hands on every frame of a camera: 8-bit sRGB colors, and inverse depths in 16 bits, of which the camera's largest is the largest.
fn displayed(capture: &Capture, camera: usize, job: &Job, mut take: impl FnMut(&[u8], &[u8])) -> Result<()> {
    let frames = capture.frame_count();
    let mut nearest = f32::MIN_POSITIVE;
    for frame in 0..frames {
        job.check()?;
        let frame = capture.frame(camera, frame)?;
        nearest = frame.inverse_depth.as_slice().iter().copied().fold(nearest, f32::max);
        job.advance(1);
    }
    for frame in 0..frames {
        job.check()?;
        let frame = capture.frame(camera, frame)?;
        let channels = frame.color.as_slice().iter().flatten();
        let rgb: Vec<u8> = channels.map(|channel| srgb8_from_linear(channel.to_f32())).collect();
        let levels = frame.inverse_depth.as_slice().iter();
        let gray: Vec<u8> = levels
            .flat_map(|depth| ((depth.max(0.0) / nearest * LARGEST).round() as u16).to_le_bytes())
            .collect();
        take(&rgb, &gray);
        job.advance(1);
    }
    Ok(())
}

/// A program that reads from us and writes a file.
struct Program {
    name: &'static str,
    child: Child,
    out: PathBuf,
    /// A file rather than a pipe, which a program that has much to say would fill and then wait.
    says: PathBuf,
}

impl Program {
    fn start(name: &'static str, arguments: &[String], out: PathBuf) -> std::io::Result<Self> {
        let says = out.with_extension("said");
        let mut command = Command::new(name);
        command.args(arguments).arg(&out).stdin(Stdio::piped()).stdout(Stdio::null());
        let child = command.stderr(File::create(&says)?).spawn()?;
        Ok(Self { name, child, out, says })
    }

    /// Bytes of the file, once it is whole; else what the program said last, and where it said nothing how it ended.
    fn finish(&mut self) -> Result<u64, String> {
        drop(self.child.stdin.take());
        let status = self.child.wait().map_err(|error| error.to_string())?;
        if status.success() {
            return size_of(&self.out).map_err(|error| error.to_string());
        }
        let said = std::fs::read(&self.says).unwrap_or_default();
        let said = String::from_utf8_lossy(&said);
        let last = said.lines().map(str::trim).rfind(|line| !line.is_empty());
        Err(format!("{} failed: {}", self.name, last.map_or_else(|| status.to_string(), str::to_owned)))
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // Of one that has ended there is no process left to end.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// What a program makes of one camera after another.
struct Form<'a> {
    name: &'static str,
    folder: &'a Path,
    /// Bytes of the cameras that are done, or why they cannot be told.
    bytes: Result<u64, String>,
    running: Option<Program>,
}

impl<'a> Form<'a> {
    fn new(name: &'static str, folder: &'a Path) -> Self {
        Self { name, folder, bytes: Ok(0), running: None }
    }

    /// Starts on a camera, unless another one failed.
    fn start(&mut self, program: &'static str, arguments: &[String], file: &str) {
        if self.bytes.is_ok() {
            match Program::start(program, arguments, self.folder.join(file)) {
                Ok(running) => self.running = Some(running),
                Err(error) => self.bytes = Err(format!("{program}: {error}")),
            }
        }
    }

    fn feed(&mut self, bytes: &[u8]) {
        let Some(running) = &mut self.running else { return };
        let Some(Err(error)) = running.child.stdin.as_mut().map(|pipe| pipe.write_all(bytes)) else { return };
        // It went away: what it has to say comes before what the pipe says.
        let said = running.finish().err();
        self.bytes = Err(said.unwrap_or_else(|| format!("{}: {error}", running.name)));
        self.running = None;
    }

    /// Ends with a camera.
    fn finish(&mut self) {
        if let (Some(mut running), Ok(before)) = (self.running.take(), &self.bytes) {
            self.bytes = running.finish().map(|bytes| before + bytes);
        }
    }

    fn measured(self, job: &Job) -> Option<u64> {
        self.bytes.map_err(|what| job.warn(format!("{} is not measured: {what}", self.name))).ok()
    }
}

/// What ffmpeg is told before the file to write.
fn video(format: &str, (width, height): (usize, usize), codec: &[&str]) -> Vec<String> {
    let size = format!("{width}x{height}");
    let input = ["-v", "error", "-y", "-f", "rawvideo", "-pix_fmt", format, "-s", &size, "-i", "-"];
    input.iter().chain(codec).map(|word| (*word).to_owned()).collect()
}

/// A frame xor the one before, which it takes the place of; the first is as it is.
fn xor(before: &mut Vec<u8>, frame: Vec<u8>) -> Vec<u8> {
    before.resize(frame.len(), 0);
    let change = frame.iter().zip(&*before).map(|(now, before)| now ^ before).collect();
    *before = frame;
    change
}

/// Reads every file of a capture once more and sums them up; `None` where it does not come from files.
///
/// # Errors
/// `Io`, `Cancelled`.
pub(super) fn input_files(capture: &Capture, job: &Job) -> Result<Option<InputFiles>> {
    let files = capture.files();
    job.start("Summing the input up", files.len());
    // Names count from the folder that all files share, so that a capture may move as a whole.
    let root = files.iter().skip(1).fold(files.first().and_then(|path| path.parent()), |root, path| {
        root.and_then(|root| root.ancestors().find(|root| path.starts_with(root)))
    });
    let root = root.unwrap_or(Path::new(""));
    let read = files.par_iter().map(|path| {
        job.check()?;
        let (bytes, crc32) = sum_of(path).map_err(|error| Error::io(path, error))?;
        job.advance(1);
        let name = path.strip_prefix(root).unwrap_or(path).display().to_string();
        Ok((name, bytes, crc32))
    });
    let mut read: Vec<(String, u64, u32)> = read.collect::<Result<_>>()?;
    read.sort();
    let lines: Vec<String> =
        read.iter().map(|(name, bytes, crc)| format!("{crc:08x} {bytes} {name}\n")).collect();
    let list = lines.concat();
    Ok((!read.is_empty()).then(|| InputFiles {
        files: read.len() as u64,
        bytes: read.iter().map(|(_, bytes, _)| bytes).sum(),
        crc32: crc32fast::hash(list.as_bytes()),
    }))
}

/// Length and CRC-32 of a file, read piece by piece through one small buffer.
fn sum_of(path: &Path) -> std::io::Result<(u64, u32)> {
    let mut file = BufReader::with_capacity(1 << 18, File::open(path)?);
    let (mut bytes, mut crc32) = (0, crc32fast::Hasher::new());
    loop {
        let piece = file.fill_buf()?;
        if piece.is_empty() {
            return Ok((bytes, crc32.finalize()));
        }
        crc32.update(piece);
        let length = piece.len();
        bytes += length as u64;
        file.consume(length);
    }
}
