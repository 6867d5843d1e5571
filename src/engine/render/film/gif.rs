//! A film file: an animated GIF, for pages and slides that play no video.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use image::codecs::gif::{GifEncoder, Repeat};
use image::{Delay, Rgba, RgbaImage};
use tempfile::TempPath;

use crate::color::srgb8_from_linear;
use crate::error::{Error, Result};
use crate::render::vantage::Picture;
use crate::whole_file;

/// Browsers slow down what shows more pictures a second.
const MOST_A_SECOND: f64 = 50.0;

/// The longest side that the format can name, pixels.
const LONGEST_SIDE: usize = u16::MAX as usize;

/// The byte that every GIF ends with.
const TRAILER: u8 = 0x3b;

/// How thoroughly the 256 colors of a picture are chosen: 1 takes longest, 30 is quickest.
const SPEED: i32 = 3;

/// A GIF that takes one picture after another, and repeats without end.
pub(super) struct GifFilm {
    /// Unbuffered, so that no error of writing is lost when it is dropped.
    encoder: GifEncoder<File>,
    size: [usize; 2],
    frames_per_second: f64,
    pictures: u32,
    unfinished: TempPath,
    out: PathBuf,
}

impl GifFilm {
    /// As [`FilmEncoder::start`](super::FilmEncoder::start).
    pub(super) fn start(out: &Path, size: [usize; 2], frames_per_second: f64) -> Result<Self> {
        let refused = |what: String| Err(Error::unsupported(out.display(), what));
        if frames_per_second > MOST_A_SECOND {
            return refused(format!(
                "a GIF plays at most {MOST_A_SECOND} pictures a second, not {frames_per_second}; give fewer, or write MP4"
            ));
        }
        if size.iter().any(|side| *side == 0 || *side > LONGEST_SIDE) {
            return refused(format!("no GIF can have {}×{} pixels; make it smaller", size[0], size[1]));
        }
        let unfinished = whole_file::beside(out, ".gif")?.into_temp_path();
        let file = File::create(&unfinished).map_err(|error| Error::io(out, error))?;
        let mut encoder = GifEncoder::new_with_speed(file, SPEED);
        encoder.set_repeat(Repeat::Infinite).map_err(|error| failed(out, error))?;
        Ok(Self { encoder, size, frames_per_second, pictures: 0, unfinished, out: out.to_path_buf() })
    }

    /// As [`FilmEncoder::add`](super::FilmEncoder::add).
    pub(super) fn add(&mut self, picture: &Picture) -> Result<()> {
        let (width, height) = picture.color.size();
        if [width, height] != self.size {
            let what = format!(
                "a picture of size {:?} does not fit a film of size {:?}",
                [width, height],
                self.size
            );
            return Err(Error::invalid(self.out.display(), what));
        }
        let pixels = RgbaImage::from_fn(width as u32, height as u32, |x, y| {
            let [red, green, blue] = picture.color[(x as usize, y as usize)].map(srgb8_from_linear);
            Rgba([red, green, blue, 255])
        });
        // The format counts hundredths of a second: roundings may not add up.
        let until = |pictures: u32| (f64::from(pictures) * 100.0 / self.frames_per_second).round() as u32;
        let hundredths = until(self.pictures + 1) - until(self.pictures);
        let shown = Delay::from_numer_denom_ms(10 * hundredths, 1);
        self.pictures += 1;
        let frame = image::Frame::from_parts(pixels, 0, 0, shown);
        self.encoder.encode_frame(frame).map_err(|error| failed(&self.out, error))
    }

    /// As [`FilmEncoder::finish`](super::FilmEncoder::finish).
    pub(super) fn finish(self) -> Result<()> {
        // The encoder writes the last byte as it goes, and tells no error.
        drop(self.encoder);
        let last_byte = || -> std::io::Result<u8> {
            let (mut file, mut last) = (File::open(&self.unfinished)?, [0]);
            file.seek(SeekFrom::End(-1))?;
            file.read_exact(&mut last)?;
            Ok(last[0])
        };
        if last_byte().map_err(|error| Error::io(&self.out, error))? != TRAILER {
            return Err(Error::io(&self.out, std::io::ErrorKind::StorageFull.into()));
        }
        whole_file::persist(self.unfinished, &self.out)
    }
}

fn failed(out: &Path, error: image::ImageError) -> Error {
    match error {
        image::ImageError::IoError(error) => Error::io(out, error),
        error => Error::unsupported(out.display(), error.to_string()),
    }
}
