//! The chunks that say what a store holds: `HEAD` and `INDX`. FORMAT.md lists their bytes.

use glam::{DAffine3, DMat3, DVec3};

use crate::capture::{Camera, Intrinsics};
use crate::preprocess::{SampleSet, Span};

use super::bytes::{ByteReader, push_text};

/// Version of the format. Another major version cannot be read; a minor one only adds chunks that may be skipped.
pub const VERSION: (u16, u16) = (1, 0);

/// Longest side of a picture, so that tiles can be counted in 16 bits.
const MAX_SIDE: u32 = 1 << 20;

/// What `HEAD` says.
pub(super) struct Head {
    pub(super) name: String,
    pub(super) up_in_world: DVec3,
    pub(super) cameras: Vec<Camera>,
    pub(super) frame_numbers: Vec<i64>,
}

/// Where one sample image stands, and what it holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageEntry {
    /// Index of the camera.
    pub camera: u32,
    /// Frames over which every sample of the image holds.
    pub span: Span,
    /// Samples in the image.
    pub samples: u32,
    /// Tiles that hold a sample.
    pub tiles: u32,
    /// Bytes from the start of the file to the image's chunk.
    pub offset: u32,
    /// Bytes of the chunk's payload.
    pub length: u32,
}

pub(super) fn encode_head(samples: &SampleSet) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    bytes.extend_from_slice(&VERSION.0.to_be_bytes());
    bytes.extend_from_slice(&VERSION.1.to_be_bytes());
    push_text(&mut bytes, &samples.name);
    push_numbers(&mut bytes, &samples.up_in_world.to_array());
    bytes.extend_from_slice(&(samples.cameras.len() as u32).to_be_bytes());
    for camera in &samples.cameras {
        let intrinsics = &camera.intrinsics;
        push_text(&mut bytes, &camera.name);
        bytes.extend_from_slice(&intrinsics.width.to_be_bytes());
        bytes.extend_from_slice(&intrinsics.height.to_be_bytes());
        push_numbers(&mut bytes, &[intrinsics.fx, intrinsics.fy, intrinsics.cx, intrinsics.cy]);
        push_numbers(&mut bytes, &camera.world_from_camera.to_cols_array());
    }
    bytes.extend_from_slice(&(samples.frame_numbers.len() as u32).to_be_bytes());
    for number in &samples.frame_numbers {
        bytes.extend_from_slice(&number.to_be_bytes());
    }
    // Whatever the reader would refuse is refused before it is written.
    decode_head(&bytes)?;
    Ok(bytes)
}

pub(super) fn decode_head(bytes: &[u8]) -> Result<Head, String> {
    let mut reader = ByteReader::new(bytes);
    let _version = (reader.u16()?, reader.u16()?);
    let name = reader.text()?;
    let up_in_world = DVec3::new(reader.f64()?, reader.f64()?, reader.f64()?);
    let cameras = (0..reader.count(4 + 8 + 4 * 8 + 12 * 8)?)
        .map(|_| decode_camera(&mut reader))
        .collect::<Result<Vec<_>, _>>()?;
    let frame_numbers = (0..reader.count(8)?).map(|_| reader.i64()).collect::<Result<Vec<_>, _>>()?;
    reader.finish()?;
    if !frame_numbers.is_sorted_by(|a, b| a < b) {
        return Err("the frame numbers do not ascend".to_owned());
    }
    Ok(Head { name, up_in_world, cameras, frame_numbers })
}

fn decode_camera(reader: &mut ByteReader) -> Result<Camera, String> {
    let name = reader.text()?;
    let (width, height) = (reader.u32()?, reader.u32()?);
    if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
        return Err(format!("camera '{name}' has {width}×{height} pixels"));
    }
    let [fx, fy, cx, cy] = read_numbers(reader)?;
    if fx <= 0.0 || fy <= 0.0 {
        return Err(format!("camera '{name}' has a focal length of {fx}×{fy} pixels"));
    }
    let columns: [f64; 12] = read_numbers(reader)?;
    let world_from_camera = DAffine3 {
        matrix3: DMat3::from_cols_slice(&columns[..9]),
        translation: DVec3::from_slice(&columns[9..]),
    };
    Ok(Camera { name, intrinsics: Intrinsics { width, height, fx, fy, cx, cy }, world_from_camera })
}

/// The version, which stands first whatever else changes.
pub(super) fn decode_version(head: &[u8]) -> Result<(u16, u16), String> {
    let mut reader = ByteReader::new(head);
    Ok((reader.u16()?, reader.u16()?))
}

pub(super) fn encode_index(entries: &[ImageEntry]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(4 + entries.len() * ENTRY_BYTES);
    bytes.extend_from_slice(&(entries.len() as u32).to_be_bytes());
    for entry in entries {
        let ImageEntry { camera, span, samples, tiles, offset, length } = *entry;
        for number in [camera, span.start, span.end, samples, tiles, offset, length] {
            bytes.extend_from_slice(&number.to_be_bytes());
        }
    }
    bytes
}

const ENTRY_BYTES: usize = 7 * 4;

pub(super) fn decode_index(bytes: &[u8]) -> Result<Vec<ImageEntry>, String> {
    let mut reader = ByteReader::new(bytes);
    let entries = (0..reader.count(ENTRY_BYTES)?)
        .map(|_| {
            Ok(ImageEntry {
                camera: reader.u32()?,
                span: Span { start: reader.u32()?, end: reader.u32()? },
                samples: reader.u32()?,
                tiles: reader.u32()?,
                offset: reader.u32()?,
                length: reader.u32()?,
            })
        })
        .collect::<Result<Vec<_>, String>>()?;
    reader.finish()?;
    // Two entries for one chunk would let a small file stand for any number of samples.
    let end = |entry: &ImageEntry| u64::from(entry.offset) + u64::from(entry.length);
    if !entries.is_sorted_by(|a, b| end(a) <= u64::from(b.offset)) {
        return Err("images overlap or are out of order".to_owned());
    }
    Ok(entries)
}

fn push_numbers(bytes: &mut Vec<u8>, numbers: &[f64]) {
    for number in numbers {
        bytes.extend_from_slice(&number.to_be_bytes());
    }
}

fn read_numbers<const N: usize>(reader: &mut ByteReader) -> Result<[f64; N], String> {
    let mut numbers = [0.0; N];
    for number in &mut numbers {
        *number = reader.f64()?;
    }
    Ok(numbers)
}
