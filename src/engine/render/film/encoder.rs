//! A film file: H.264 in MP4, or an animated GIF.

use std::fs::File;
use std::io::{BufWriter, Seek, Write};
use std::path::{Path, PathBuf};

use rusty_h264_common::YuvPlanes;
use rusty_h264_encoder::{Encoder, EncoderConfig, Preset};
use tempfile::TempPath;

use super::gif::GifFilm;
use super::h264;
use super::mp4::{self, Track};
use crate::color::srgb8_from_linear;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::render::vantage::Picture;
use crate::whole_file;

/// The step between levels of a coefficient, as the format counts it: pictures of detailed scenes differ by 1.6 of 255 in the mean,
/// most of it because four pixels share a color.
const QUANTIZER: u8 = 17;

/// Seconds after which a player can start without the pictures before.
const SECONDS_PER_KEY_PICTURE: f64 = 2.0;

/// The largest picture that the format's levels know, in blocks of 16×16 pixels, and the longest side in pixels.
const MOST_BLOCKS: usize = 139_264;
const LONGEST_SIDE: usize = 16_384;

/// The levels of the format: their number, and what they allow: blocks of 16×16 pixels of a picture, and of a second.
const LEVELS: [(u8, usize, f64); 10] = [
    (30, 1_620, 40_500.0),
    (31, 3_600, 108_000.0),
    (40, 8_192, 245_760.0),
    (42, 8_704, 522_240.0),
    (50, 22_080, 589_824.0),
    (51, 36_864, 983_040.0),
    (52, 36_864, 2_073_600.0),
    (60, MOST_BLOCKS, 4_177_920.0),
    (61, MOST_BLOCKS, 8_355_840.0),
    (62, MOST_BLOCKS, 16_711_680.0),
];

/// A film that takes one picture after another. It takes its name when it is complete: dropped before [`FilmEncoder::finish`] it
/// leaves nothing behind, and an earlier file of that name stays.
pub struct FilmEncoder(Coder);

/// By the ending of the film's name.
enum Coder {
    Mp4(Box<Mp4Film>),
    Gif(Box<GifFilm>),
}

impl FilmEncoder {
    /// Starts a film of `width` by `height` pixels at `out`, as in `film.mp4` or `film.gif`. A side with an odd number of pixels is one
    /// longer in MP4, whose last pixel is there twice.
    ///
    /// # Errors
    /// `Unsupported` for another extension than `.mp4`, `.m4v` or `.gif`, and for sides beyond 16384 pixels or pictures of more than 35
    /// million in MP4, and for more than 50 pictures a second in GIF; `Io` where the folder cannot be written.
    pub fn start(out: &Path, size: [usize; 2], frames_per_second: f64) -> Result<Self> {
        let extension = out.extension().unwrap_or_default().to_ascii_lowercase();
        Ok(Self(match extension.to_str() {
            Some("gif") => Coder::Gif(Box::new(GifFilm::start(out, size, frames_per_second)?)),
            Some("mp4" | "m4v") => Coder::Mp4(Box::new(Mp4Film::start(out, size, frames_per_second)?)),
            _ => {
                let what = "videos are written as MP4 or GIF; name it with .mp4 or .gif, or export pictures for another program";
                return Err(Error::unsupported(out.display(), what));
            }
        }))
    }

    /// Tells players that the pictures are equirectangular, so that they show a part to look around in; a GIF cannot say so.
    pub fn mark_equirectangular(&mut self) {
        if let Coder::Mp4(film) = &mut self.0 {
            film.track.is_equirectangular = true;
        }
    }

    /// Adds a picture of the size given at the start. Holes are black.
    ///
    /// # Errors
    /// `Invalid` for a picture of another size, `Io` where the disk is full.
    pub fn add(&mut self, picture: &Picture) -> Result<()> {
        match &mut self.0 {
            Coder::Mp4(film) => film.add(picture),
            Coder::Gif(film) => film.add(picture),
        }
    }

    /// Completes the film.
    ///
    /// # Errors
    /// `Io` where the disk is full or the film cannot take its name; `Cancelled`.
    pub fn finish(self, job: &Job) -> Result<()> {
        job.check()?;
        match self.0 {
            Coder::Mp4(film) => film.finish(),
            Coder::Gif(film) => film.finish(),
        }
    }
}

/// A film as H.264 in MP4.
struct Mp4Film {
    encoder: Encoder,
    track: Track,
    /// The coded pictures, until the index before them is known.
    coded: BufWriter<File>,
    unfinished: TempPath,
    out: PathBuf,
}

impl Mp4Film {
    fn start(out: &Path, size: [usize; 2], frames_per_second: f64) -> Result<Self> {
        let [width, height] = size.map(|side| side.next_multiple_of(2));
        let too_large = || {
            let what = format!("no video can have {}×{} pixels; make it smaller", size[0], size[1]);
            Error::unsupported(out.display(), what)
        };
        if width.max(height) > LONGEST_SIDE || width.min(height) == 0 {
            return Err(too_large());
        }
        let blocks = width.div_ceil(16) * height.div_ceil(16);
        let fits =
            |level: &&(u8, usize, f64)| level.1 >= blocks && level.2 >= blocks as f64 * frames_per_second;
        let (highest, most, _) = LEVELS[LEVELS.len() - 1];
        if blocks > most {
            return Err(too_large());
        }
        if [width, height] != size {
            let [columns, rows] = size;
            log::warn!(
                "{}: the sides of an MP4 are even: {columns}×{rows} is written as {width}×{height}, its last pixels twice",
                out.display()
            );
        }
        let mut config = EncoderConfig::new(width, height);
        config.level_idc = LEVELS.iter().find(fits).map_or(highest, |level| level.0);
        config.preset = Preset::Balanced;
        config.qp = QUANTIZER;
        config.framerate = frames_per_second as f32;
        config.gop_size = (SECONDS_PER_KEY_PICTURE * frames_per_second).ceil().max(1.0) as u32;
        // Each picture comes out as it goes in.
        config.mbtree = false;
        let encoder =
            Encoder::new(config).map_err(|error| Error::unsupported(out.display(), error.to_string()))?;
        let temporary = || tempfile::tempfile_in(whole_file::folder_of(out));
        Ok(Self {
            encoder,
            track: Track {
                size: [width, height].map(|side| side as u16),
                frames_per_second,
                parameter_sets: [Vec::new(), Vec::new()],
                picture_bytes: Vec::new(),
                key_pictures: Vec::new(),
                is_equirectangular: false,
            },
            unfinished: whole_file::beside(out, ".mp4")?.into_temp_path(),
            coded: BufWriter::new(temporary().map_err(|error| Error::io(out, error))?),
            out: out.to_path_buf(),
        })
    }

    fn add(&mut self, picture: &Picture) -> Result<()> {
        let size = self.track.size.map(usize::from);
        let given = [picture.color.width(), picture.color.height()];
        let planes = Planes::of(picture, size);
        let views = YuvPlanes::tight(size[0], size[1], &planes.luma, &planes.blue, &planes.red);
        let views = views.filter(|_| given.map(|side| side.next_multiple_of(2)) == size);
        let coded = views.map(|views| self.encoder.encode_planes(&views));
        let Some(Ok(coded)) = coded else {
            let what = format!("a picture of size {given:?} does not fit a film of size {size:?}");
            return Err(Error::invalid(self.out.display(), what));
        };
        self.take(&coded).map_err(|error| Error::io(&self.out, error))
    }

    /// Writes a coded picture and keeps what the index says of it.
    fn take(&mut self, coded: &[u8]) -> std::io::Result<()> {
        for unit in h264::units(coded) {
            match h264::kind(unit) {
                h264::SEQUENCE_PARAMETERS => {
                    let told = h264::with_color_space(unit).unwrap_or_else(|| unit.to_vec());
                    self.track.parameter_sets[0] = told;
                }
                h264::PICTURE_PARAMETERS => self.track.parameter_sets[1] = unit.to_vec(),
                // Every picture is one slice.
                kind @ (h264::SLICE | h264::KEY_SLICE) => {
                    if kind == h264::KEY_SLICE {
                        self.track.key_pictures.push(self.track.picture_bytes.len() as u32);
                    }
                    self.track.picture_bytes.push(unit.len() as u32 + 4);
                    self.coded.write_all(&(unit.len() as u32).to_be_bytes())?;
                    self.coded.write_all(unit)?;
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn finish(self) -> Result<()> {
        let write = || {
            let mut coded = self.coded.into_inner().map_err(std::io::IntoInnerError::into_error)?;
            coded.rewind()?;
            let mut film = BufWriter::new(File::create(&self.unfinished)?);
            mp4::write(&self.track, &mut coded, &mut film)?;
            film.flush()
        };
        write().map_err(|error| Error::io(&self.out, error))?;
        whole_file::persist(self.unfinished, &self.out)
    }
}

/// A picture as Rec. 709 brightness and two color differences of television range, these of four pixels each.
struct Planes {
    luma: Vec<u8>,
    blue: Vec<u8>,
    red: Vec<u8>,
}

/// Shares of red and blue in brightness.
const RED: f32 = 0.2126;
const BLUE: f32 = 0.0722;

impl Planes {
    fn of(picture: &Picture, [width, height]: [usize; 2]) -> Self {
        let (columns, rows) = (picture.color.width(), picture.color.height());
        let mut planes = Self {
            luma: vec![16; width * height],
            blue: vec![128; width * height / 4],
            red: vec![128; width * height / 4],
        };
        let color = |x: usize, y: usize| {
            let pixel = picture.color[(x.min(columns - 1), y.min(rows - 1))];
            pixel.map(|channel| f32::from(srgb8_from_linear(channel)))
        };
        let brightness = |[red, green, blue]: [f32; 3]| RED * red + (1.0 - RED - BLUE) * green + BLUE * blue;
        for y in 0..height / 2 {
            for x in 0..width / 2 {
                let mut mean = [0.0; 3];
                for (column, row) in [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| (2 * x + dx, 2 * y + dy))
                {
                    let pixel = color(column, row);
                    planes.luma[row * width + column] = (16.5 + brightness(pixel) * 219.0 / 255.0) as u8;
                    mean = [0, 1, 2].map(|channel| mean[channel] + pixel[channel] / 4.0);
                }
                let difference = |channel: f32, share: f32| {
                    (128.5 + (channel - brightness(mean)) / (2.0 * (1.0 - share)) * 224.0 / 255.0) as u8
                };
                planes.blue[y * width / 2 + x] = difference(mean[2], BLUE);
                planes.red[y * width / 2 + x] = difference(mean[0], RED);
            }
        }
        planes
    }
}
