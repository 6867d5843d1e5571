//! One OpenEXR file: its channels by their full names, and their planes on demand.
//!
//! Files are read through the block interface of the `exr` crate, so that parts without a wanted channel are neither
//! inflated nor stored, and so that sizes are checked before anything is allocated for them.

use std::collections::{HashMap, HashSet};
use std::io::{BufReader, Cursor};
use std::path::Path;

use exr::block::UncompressedBlock;
use exr::block::reader::ChunksReader;
use exr::compression::Compression;
use exr::meta::MetaData;
use exr::meta::attribute::{EnvironmentMap, SampleType, Text};
use exr::meta::header::Header;

use super::channels::ChannelPlane;
use super::color_planes::Primaries;
use super::decoder_guard::{self, guarded};
use super::zip::Inflater;
use crate::capture::camera::{MAX_SIDE, is_believable_size, wrong_size};
use crate::error::{Error, Result};
use crate::plural::counted;
use crate::whole_file;

/// No compression but DWA makes more than a thousand bytes of one, and a pixel has at least one.
const MAX_PIXELS_PER_BYTE: usize = 1100;
/// DWA keeps a few numbers of each 8×8 pixels, and makes those smaller in turn.
const DWA_BLOCK_PIXELS: usize = 64;
/// Ratios of a pixel's width to its height that are believed.
const BELIEVABLE_PIXEL_ASPECTS: std::ops::RangeInclusive<f64> = 0.01..=100.0;
/// Largest file that is read: one frame of the largest believable size with a dozen float channels stays below it.
const MAX_FILE_BYTES: u64 = 4 << 30;

/// One channel of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelInfo {
    /// Layer and suffix, as in `ViewLayer.Depth.Z`, whether the file has one part or one part per pass.
    pub name: String,
    /// Whether its samples are half floats.
    pub is_half: bool,
    /// Whether its samples are whole numbers.
    pub is_whole: bool,
    /// Largest relative error that the file's numbers were rounded with; 0 where they are whole `f32`.
    pub step_relative: f32,
    part: usize,
    index: usize,
}

/// A rectangle of pixels in the coordinates of the file's display window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DataWindow {
    x: i64,
    y: i64,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

/// An OpenEXR file whose header has been read and found believable.
pub struct ExrFile {
    place: String,
    bytes: Vec<u8>,
    channels: Vec<ChannelInfo>,
    display: DataWindow,
    data: Vec<DataWindow>,
    pixels_per_byte: Vec<usize>,
    /// The primaries that the header states; Rec.709's where it states none.
    pub(crate) primaries: Primaries,
}

impl ExrFile {
    /// Reads the file and its header; `place` names it, with its frame, in errors.
    ///
    /// # Errors
    /// `Io` where it cannot be read, `Invalid` for a damaged or absurd header, `Unsupported` for deep or subsampled
    /// pictures and for compressions newer than ZIP, PIZ and DWA.
    pub fn open(path: &Path, place: &str) -> Result<Self> {
        whole_file::refuse_pipe(path)?;
        let length = std::fs::metadata(path).map_err(|error| unreadable(path, place, error))?.len();
        if length > MAX_FILE_BYTES {
            let what = format!("{length} bytes are too many for one picture; save it again");
            return Err(Error::invalid(place, what));
        }
        let bytes = std::fs::read(path).map_err(|error| unreadable(path, place, error))?;
        Self::from_bytes(bytes, place)
    }

    /// As [`ExrFile::open`], from the bytes of a file.
    ///
    /// # Errors
    /// As [`ExrFile::open`], but for `Io`.
    pub fn from_bytes(bytes: Vec<u8>, place: &str) -> Result<Self> {
        let headers = guarded(place, || {
            let reader = exr::block::read(Cursor::new(bytes.as_slice()), false)?;
            Ok(reader.headers().to_vec())
        })?;
        let mut channels: Vec<ChannelInfo> = Vec::new();
        let mut data = Vec::new();
        let mut in_full = Vec::new();
        for (part, header) in headers.iter().enumerate() {
            data.push(data_window(header, place)?);
            let part_name = header.own_attributes.layer_name.as_ref().map(readable);
            let prefix = part_name.filter(|part| headers.len() > 1 && !part.is_empty());
            in_full.extend(header.channels.list.iter().map(|channel| {
                prefix.as_ref().map_or_else(
                    || readable(&channel.name),
                    |part| format!("{part}.{}", readable(&channel.name)),
                )
            }));
            channels.extend(header.channels.list.iter().enumerate().map(|(index, channel)| ChannelInfo {
                name: full_name(prefix.as_deref(), &readable(&channel.name)),
                is_half: channel.sample_type == SampleType::F16,
                is_whole: channel.sample_type == SampleType::U32,
                step_relative: step_relative(channel.sample_type, header.compression),
                part,
                index,
            }));
        }
        tell_apart(&mut channels, &in_full);
        let pixels_per_byte = headers.iter().map(|header| max_pixels_per_byte(header.compression)).collect();
        let stated = headers.iter().find_map(|header| header.shared_attributes.chromaticities);
        let primaries = stated.map_or(Primaries::Rec709, Primaries::of_header);
        let display = headers.first().map(|header| header.shared_attributes.display_window);
        let Some(display) = display else {
            return Err(Error::invalid(place, "the file holds no picture; save it again"));
        };
        let display = DataWindow {
            x: i64::from(display.position.0),
            y: i64::from(display.position.1),
            width: display.size.0,
            height: display.size.1,
        };
        Ok(Self { place: place.to_owned(), bytes, channels, display, data, pixels_per_byte, primaries })
    }

    /// Width of a pixel over its height; `None` where the header cannot be read or states an absurd ratio.
    #[must_use]
    pub fn pixel_aspect(path: &Path) -> Option<f64> {
        let file = BufReader::new(whole_file::open(path).ok()?);
        let meta = guarded("", || MetaData::read_from_buffered(file, false)).ok()?;
        let aspect = f64::from(meta.headers.first()?.shared_attributes.pixel_aspect);
        BELIEVABLE_PIXEL_ASPECTS.contains(&aspect).then_some(aspect)
    }

    /// The channels, part by part.
    #[must_use]
    pub fn channels(&self) -> &[ChannelInfo] {
        &self.channels
    }

    /// The window to decode for a camera of `expected` size, or the whole picture where that is not known.
    ///
    /// The display window is the camera's picture; the data window may be smaller (a cropped render) or larger
    /// (overscan). Where only the data window has the camera's size, it is the picture.
    ///
    /// # Errors
    /// `Invalid` where neither window has the expected size.
    pub fn window(&self, expected: Option<(usize, usize)>) -> Result<DataWindow> {
        let Some(expected) = expected else {
            return believable(self.display, &self.place);
        };
        std::iter::once(&self.display)
            .chain(&self.data)
            .find(|window| (window.width, window.height) == expected)
            .copied()
            .ok_or_else(|| wrong_size(&self.place, (self.display.width, self.display.height), expected))
    }

    /// Decodes the channels with these indices (into [`ExrFile::channels`]), in their order; one may be there twice.
    ///
    /// # Errors
    /// `Invalid` for damaged data, `Unsupported` for what the decoder does not know.
    pub fn decode(&self, wanted: &[usize], window: DataWindow) -> Result<Vec<ChannelPlane>> {
        for &channel in wanted {
            let part = self.channels[channel].part;
            self.check_length(window, part)?;
            self.check_length(self.data[part], part)?;
        }
        let pixels = window.width * window.height;
        let unknown = |&channel: &usize| ChannelPlane::unknown(self.channels[channel].is_half, pixels);
        let mut planes: Vec<ChannelPlane> = wanted.iter().map(unknown).collect();
        guarded(&self.place, || self.decode_blocks(wanted, window, &mut planes))?;
        for (at, channel) in wanted.iter().enumerate() {
            if let Some(first) = wanted[..at].iter().position(|other| other == channel) {
                planes[at] = planes[first].clone();
            }
        }
        Ok(planes)
    }

    /// Refuses a window that the file is too short to fill in the compression of a part, before it is allocated.
    fn check_length(&self, window: DataWindow, part: usize) -> Result<()> {
        let DataWindow { width, height, .. } = believable(window, &self.place)?;
        if width * height / self.pixels_per_byte[part] <= self.bytes.len() {
            return Ok(());
        }
        let bytes = self.bytes.len();
        let what = format!(
            "the file is too short for {width}×{height} pixels ({}); save it again",
            counted(bytes, "byte")
        );
        Err(Error::invalid(&self.place, what))
    }

    fn decode_blocks(
        &self,
        wanted: &[usize],
        window: DataWindow,
        planes: &mut [ChannelPlane],
    ) -> exr::error::Result<()> {
        let reader = exr::block::read(Cursor::new(self.bytes.as_slice()), false)?;
        let is_wanted_part = |part| wanted.iter().any(|&channel| self.channels[channel].part == part);
        let chunks = reader.filter_chunks(false, |_, _, block| {
            block.level == exr::math::Vec2(0, 0) && is_wanted_part(block.layer)
        })?;
        let expected = chunks.expected_chunk_count();
        let meta = chunks.meta_data().clone();
        let mut seen = HashSet::with_capacity(expected.min(MAX_SIDE));
        let mut inflater = Inflater::new();
        for chunk in chunks {
            let chunk = chunk?;
            decoder_guard::check_chunk(&chunk, &meta)?;
            let block = inflater.pixels(chunk, &meta)?;
            seen.insert((block.index.layer, block.index.pixel_position));
            self.copy_block(&meta.headers[block.index.layer], &block, wanted, window, planes);
        }
        // Every block carries its own position; a damaged one may name a neighbor's and leave a gap behind.
        if seen.len() == expected {
            Ok(())
        } else {
            Err(exr::error::Error::Invalid("two blocks claim the same place".into()))
        }
    }

    fn copy_block(
        &self,
        header: &Header,
        block: &UncompressedBlock,
        wanted: &[usize],
        window: DataWindow,
        planes: &mut [ChannelPlane],
    ) {
        let part = block.index.layer;
        let origin = self.data[part];
        for line in block.lines(&header.channels) {
            let Some(slot) = wanted.iter().position(|&channel| {
                self.channels[channel].part == part && self.channels[channel].index == line.location.channel
            }) else {
                continue;
            };
            let y = origin.y + line.location.position.1 as i64 - window.y;
            if !(0..window.height as i64).contains(&y) {
                continue;
            }
            let first_x = origin.x + line.location.position.0 as i64 - window.x;
            let start = (-first_x).max(0) as usize;
            let end = (window.width as i64 - first_x).clamp(0, line.location.sample_count as i64) as usize;
            if start >= end {
                continue;
            }
            let at = y as usize * window.width + (first_x + start as i64) as usize;
            let kind = header.channels.list[line.location.channel].sample_type;
            planes[slot].set(at..at + end - start, &line.value[start * kind.bytes_per_sample()..], kind);
        }
    }
}

fn max_pixels_per_byte(compression: Compression) -> usize {
    match compression {
        Compression::DWAA(_) | Compression::DWAB(_) => DWA_BLOCK_PIXELS * MAX_PIXELS_PER_BYTE,
        _ => MAX_PIXELS_PER_BYTE,
    }
}

/// Gives channels of several parts that would have one name `part.channel`, so that none hides another.
fn tell_apart(channels: &mut [ChannelInfo], in_full: &[String]) {
    let mut counts: HashMap<String, usize> = HashMap::new();
    for channel in channels.iter() {
        *counts.entry(channel.name.clone()).or_default() += 1;
    }
    for (channel, in_full) in channels.iter_mut().zip(in_full) {
        if counts[&channel.name] > 1 {
            channel.name.clone_from(in_full);
        }
    }
}

/// A name as UTF-8, or as Latin-1 if it is no UTF-8: the format leaves it to the writer, and nearly all write UTF-8.
fn readable(name: &Text) -> String {
    std::str::from_utf8(name.as_slice()).map_or_else(|_| name.to_string(), ToOwned::to_owned)
}

/// Half a unit in the last of the 11 binary digits of a half float, or of the 16 that PXR24 leaves of a float.
fn step_relative(sample_type: SampleType, compression: Compression) -> f32 {
    match (sample_type, compression) {
        (SampleType::F16, _) => 1.0 / 2048.0,
        (SampleType::F32, Compression::PXR24) => 1.0 / 65_536.0,
        _ => 0.0,
    }
}

/// `part.channel`, unless the channel bears the part's name already: Blender 5 names both in full, others do not.
fn full_name(part: Option<&str>, channel: &str) -> String {
    match part {
        Some(part) if !part.is_empty() => {
            let repeats = channel.strip_prefix(part).is_some_and(|rest| rest.starts_with('.'));
            if repeats || channel.contains('.') { channel.to_owned() } else { format!("{part}.{channel}") }
        }
        _ => channel.to_owned(),
    }
}

fn data_window(header: &Header, place: &str) -> Result<DataWindow> {
    if header.deep {
        return Err(Error::unsupported(place, "deep pictures are not supported; save it again flattened"));
    }
    if header.channels.list.iter().any(|channel| channel.sampling != exr::math::Vec2(1, 1)) {
        return Err(Error::unsupported(place, "subsampled channels are not supported; save it again as RGB"));
    }
    if let Some(map) = header.own_attributes.environment_map {
        let kind = match map {
            EnvironmentMap::LatitudeLongitude => "a panorama of the whole sphere",
            EnvironmentMap::Cube => "the six sides of a cube",
        };
        let what = format!(
            "the header says that it is {kind} (envmap), which is not read; render perspective pictures of it"
        );
        return Err(Error::unsupported(place, what));
    }
    let position = header.own_attributes.layer_position;
    Ok(DataWindow {
        x: i64::from(position.0),
        y: i64::from(position.1),
        width: header.layer_size.0,
        height: header.layer_size.1,
    })
}

fn believable(window: DataWindow, place: &str) -> Result<DataWindow> {
    let DataWindow { width, height, .. } = window;
    if is_believable_size(width, height) {
        Ok(window)
    } else {
        Err(Error::invalid(
            place,
            format!("the header claims {width}×{height} pixels, which cannot be; save it again"),
        ))
    }
}

fn unreadable(path: &Path, place: &str, error: std::io::Error) -> Error {
    if error.kind() == std::io::ErrorKind::NotFound {
        Error::invalid(place, "the file is missing; put it back or take its entry out of the manifest")
    } else {
        Error::io(path, error)
    }
}
