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

/// Measures all rivals; those that need an ffmpeg or a zstd are `None` where there is none.
///
/// # Errors
/// Whatever decoding the capture gives, `Io`, `Cancelled`.
pub(super) fn measure(capture: &Capture, job: &Job) -> Result<Rivals> {
    let folder = tempfile::tempdir().map_err(|error| Error::io(std::env::temp_dir(), error))?;
    let zip_exr = zip_exr(capture, folder.path(), job)?;
    let mut rivals = Rivals { zip_exr, ..Rivals::default() };
    let (ffmpeg, zstd) = (is_there("ffmpeg", "-version"), is_there("zstd", "--version"));
    if !ffmpeg && !zstd {
        return Ok(rivals);
    }
    job.start("Measuring other forms", 2 * capture.cameras.len() * capture.frame_count());
    for (camera, named) in capture.cameras.iter().enumerate() {
        let mut video = ffmpeg.then(|| Video::start(folder.path(), named.intrinsics.size())).transpose()?;
        let mut changes = zstd.then(|| Changes::start(folder.path())).transpose()?;
        displayed(capture, camera, job, |rgb, gray| {
            if let Some(video) = &mut video {
                video.color.feed(rgb)?;
                video.depth.feed(gray)?;
            }
            changes.as_mut().map_or(Ok(()), |changes| changes.feed([rgb, gray].concat()))
        })?;
        if let Some(Video { color, depth }) = video {
            *rivals.video_color.get_or_insert(0) += color.finish()?;
            *rivals.video_depth.get_or_insert(0) += depth.finish()?;
        }
        if let Some(changes) = changes {
            *rivals.xor_zstd.get_or_insert(0) += changes.zstd.finish()?;
        }
    }
    Ok(rivals)
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
fn displayed(
    capture: &Capture,
    camera: usize,
    job: &Job,
    mut take: impl FnMut(&[u8], &[u8]) -> Result<()>,
) -> Result<()> {
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
        take(&rgb, &gray)?;
        job.advance(1);
    }
    Ok(())
}

/// A program that reads from us and writes a file.
struct Program {
    name: &'static str,
    child: Child,
    out: PathBuf,
}

impl Program {
    fn start(name: &'static str, arguments: &[&str], out: PathBuf) -> Result<Self> {
        let mut command = Command::new(name);
        command.args(arguments).arg(&out).stdin(Stdio::piped()).stdout(Stdio::null());
        let child = command.spawn().map_err(|error| Error::io(name, error))?;
        Ok(Self { name, child, out })
    }

    fn feed(&mut self, bytes: &[u8]) -> Result<()> {
        match &mut self.child.stdin {
            Some(pipe) => pipe.write_all(bytes).map_err(|error| Error::io(self.name, error)),
            None => Err(Error::invalid(self.name, "takes no pictures")),
        }
    }

    /// Bytes of the file, once it is whole.
    fn finish(mut self) -> Result<u64> {
        drop(self.child.stdin.take());
        let status = self.child.wait().map_err(|error| Error::io(self.name, error))?;
        if status.success() {
            size_of(&self.out)
        } else {
            Err(Error::invalid(self.name, format!("failed: {status}")))
        }
    }
}

/// Color and depth of a camera as lossless video.
struct Video {
    color: Program,
    depth: Program,
}

impl Video {
    fn start(folder: &Path, (width, height): (usize, usize)) -> Result<Self> {
        let size = format!("{width}x{height}");
        let start = |name: &str, format: &str, codec: &[&str]| {
            let input = ["-v", "error", "-y", "-f", "rawvideo", "-pix_fmt", format, "-s", &size, "-i", "-"];
            Program::start("ffmpeg", &[&input, codec].concat(), folder.join(name))
        };
        Ok(Self {
            color: start("color.mkv", "rgb24", &["-c:v", "libx264rgb", "-qp", "0"])?,
            depth: start("depth.mkv", "gray16le", &["-c:v", "ffv1", "-level", "3", "-coder", "2"])?,
        })
    }
}

/// Each frame of a camera xor the one before, through zstd.
struct Changes {
    zstd: Program,
    before: Vec<u8>,
}

impl Changes {
    fn start(folder: &Path) -> Result<Self> {
        let zstd = Program::start("zstd", &["-3", "-q", "-f", "-o"], folder.join("xor.zst"))?;
        Ok(Self { zstd, before: Vec::new() })
    }

    fn feed(&mut self, frame: Vec<u8>) -> Result<()> {
        self.before.resize(frame.len(), 0);
        let change: Vec<u8> = frame.iter().zip(&self.before).map(|(now, before)| now ^ before).collect();
        self.before = frame;
        self.zstd.feed(&change)
    }
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
