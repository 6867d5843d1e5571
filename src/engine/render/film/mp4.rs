//! The boxes of an MP4 file with one H.264 video (ISO/IEC 14496-12 and 14496-15): the index before the pictures, so that a film plays
//! while it still loads.

use std::io::{self, Read, Write};

/// Ticks of a picture: rates with three decimals, as in 23.976, are exact.
const TICKS_PER_PICTURE: u32 = 1000;

/// Seconds since 1904 are not told: the same film is the same file.
const NO_DATE: u32 = 0;

/// What the index says of a film.
pub(super) struct Track {
    /// In pixels.
    pub(super) size: [u16; 2],
    pub(super) frames_per_second: f64,
    /// The sequence and picture parameter sets, with their header byte.
    pub(super) parameter_sets: [Vec<u8>; 2],
    /// Bytes of each picture.
    pub(super) picture_bytes: Vec<u32>,
    /// The pictures that need no other, from 0.
    pub(super) key_pictures: Vec<u32>,
    /// Whether the pictures are equirectangular, which players turn into a view to look around in.
    pub(super) is_equirectangular: bool,
}

/// Writes the film. `pictures` has the coded pictures, one after another, each of its NAL units behind its length.
pub(super) fn write(track: &Track, pictures: &mut impl Read, out: &mut impl Write) -> io::Result<()> {
    let file_type = boxed("ftyp", [b"isom".as_slice(), &512_u32.to_be_bytes(), b"isomiso2avc1mp41"]);
    let data: u64 = track.picture_bytes.iter().map(|bytes| u64::from(*bytes)).sum();
    // A box of more than four gigabytes has its size behind its name.
    let mut header = Vec::new();
    if let Ok(size) = u32::try_from(data + 8) {
        header.extend(size.to_be_bytes());
        header.extend(b"mdat");
    } else {
        header.extend(1_u32.to_be_bytes());
        header.extend(b"mdat");
        header.extend((data + 16).to_be_bytes());
    }
    // The place of the pictures is a number of fixed length in the index, whose own length does not depend on it.
    let before = file_type.len() + movie(track, 0).len() + header.len();
    out.write_all(&file_type)?;
    out.write_all(&movie(track, before as u32))?;
    out.write_all(&header)?;
    io::copy(pictures, out).map(drop)
}

/// A box of parts; its name has four letters.
fn boxed<'a>(name: &str, parts: impl IntoIterator<Item = &'a [u8]>) -> Vec<u8> {
    let mut bytes = vec![0; 4];
    bytes.extend(name.as_bytes());
    for part in parts {
        bytes.extend(part);
    }
    let size = bytes.len() as u32;
    bytes[..4].copy_from_slice(&size.to_be_bytes());
    bytes
}

/// A box of 32-bit numbers.
fn numbers(name: &str, numbers: impl IntoIterator<Item = u32>) -> Vec<u8> {
    let bytes: Vec<u8> = numbers.into_iter().flat_map(u32::to_be_bytes).collect();
    boxed(name, [bytes.as_slice()])
}

/// No turn, as 16.16 and 2.30 numbers.
const UPRIGHT: [u32; 9] = [0x1_0000, 0, 0, 0, 0x1_0000, 0, 0, 0, 0x4000_0000];

fn movie(track: &Track, first_picture_at: u32) -> Vec<u8> {
    let pictures = track.picture_bytes.len() as u32;
    let ticks_per_second = (track.frames_per_second * f64::from(TICKS_PER_PICTURE)).round() as u32;
    let length = pictures.saturating_mul(TICKS_PER_PICTURE);
    let [width, height] = track.size.map(u32::from);
    let dates = [0, NO_DATE, NO_DATE];
    let rate_and_volume = [0x1_0000, 0x100_0000, 0, 0];
    let movie_header = dates
        .into_iter()
        .chain([ticks_per_second, length])
        .chain(rate_and_volume)
        .chain(UPRIGHT)
        .chain([0; 6])
        .chain([2]);
    // Shown, in the film and its preview; number 1.
    let track_header = [3, NO_DATE, NO_DATE, 1, 0, length, 0, 0, 0, 0].into_iter().chain(UPRIGHT);
    let track_header = track_header.chain([width << 16, height << 16]);
    // No language.
    let media_header = dates.into_iter().chain([ticks_per_second, length, 0x55c4_0000]);
    let handler = boxed("hdlr", [&[0; 8], b"vide".as_slice(), &[0; 12], b"video\0"]);
    let here = numbers("url ", [1]);
    let references = boxed("dref", [[0, 0, 0, 0, 0, 0, 0, 1].as_slice(), &here]);
    let places = boxed("dinf", [references.as_slice()]);
    let video_header = numbers("vmhd", [1, 0, 0]);
    let table = sample_table(track, first_picture_at);
    let information = boxed("minf", [video_header.as_slice(), &places, &table]);
    let media_header = numbers("mdhd", media_header);
    let media = boxed("mdia", [media_header.as_slice(), &handler, &information]);
    let track = boxed("trak", [numbers("tkhd", track_header).as_slice(), &media]);
    boxed("moov", [numbers("mvhd", movie_header).as_slice(), &track])
}

/// When, how long and where each picture is: all in one chunk.
fn sample_table(track: &Track, first_picture_at: u32) -> Vec<u8> {
    let pictures = track.picture_bytes.len() as u32;
    let description = boxed("stsd", [[0, 0, 0, 0, 0, 0, 0, 1].as_slice(), &sample_entry(track)]);
    let times = numbers("stts", [0, 1, pictures, TICKS_PER_PICTURE]);
    let keys = [0, track.key_pictures.len() as u32];
    let keys = numbers("stss", keys.into_iter().chain(track.key_pictures.iter().map(|key| key + 1)));
    let chunks = numbers("stsc", [0, 1, 1, pictures, 1]);
    let sizes = numbers("stsz", [0, 0, pictures].into_iter().chain(track.picture_bytes.iter().copied()));
    let places = numbers("stco", [0, 1, first_picture_at]);
    boxed("stbl", [description.as_slice(), &times, &keys, &chunks, &sizes, &places])
}

/// The size, the parameter sets and the colors.
fn sample_entry(track: &Track) -> Vec<u8> {
    let [width, height] = track.size.map(u16::to_be_bytes);
    let [sequence, picture] = &track.parameter_sets;
    let mut decoder = vec![1];
    decoder.extend(sequence.get(1..4).unwrap_or_default());
    // Lengths of four bytes; one set each.
    decoder.extend([0xff, 0xe1]);
    decoder.extend((sequence.len() as u16).to_be_bytes());
    decoder.extend(sequence);
    decoder.push(1);
    decoder.extend((picture.len() as u16).to_be_bytes());
    decoder.extend(picture);
    if sequence.get(1).is_some_and(|profile| *profile >= 100) {
        // 4:2:0, 8 bits, no extensions.
        decoder.extend([0xfd, 0xf8, 0xf8, 0]);
    }
    let decoder = boxed("avcC", [decoder.as_slice()]);
    let [primaries, curve, matrix] = super::h264::COLOR_SPACE.map(u16::from).map(u16::to_be_bytes);
    let color = boxed("colr", [b"nclx".as_slice(), &primaries, &curve, &matrix, &[0]]);
    let square_pixels = numbers("pasp", [1, 1]);
    let sphere = if track.is_equirectangular { equirectangular() } else { Vec::new() };
    let resolution = 0x48_0000_u32.to_be_bytes();
    boxed(
        "avc1",
        [
            [0, 0, 0, 0, 0, 0, 0, 1].as_slice(),
            &[0; 16],
            &width,
            &height,
            &resolution,
            &resolution,
            &[0, 0, 0, 0, 0, 1],
            &[0; 32],
            &[0, 24, 0xff, 0xff],
            &decoder,
            &color,
            &square_pixels,
            &sphere,
        ],
    )
}

/// Google's *Spherical Video V2*: one eye, the whole sphere.
fn equirectangular() -> Vec<u8> {
    let one_eye = boxed("st3d", [[0; 5].as_slice()]);
    let source = boxed("svhd", [[0, 0, 0, 0].as_slice(), b"Overlook\0"]);
    let pose = numbers("prhd", [0; 4]);
    let whole = numbers("equi", [0; 5]);
    let projection = boxed("proj", [pose.as_slice(), &whole]);
    let sphere = boxed("sv3d", [source.as_slice(), &projection]);
    [one_eye, sphere].concat()
}
