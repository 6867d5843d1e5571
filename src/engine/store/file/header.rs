//! The chunks that say what a store holds: `HEAD` and `INDX`. FORMAT.md lists their bytes.

use std::collections::BTreeSet;

use glam::{DAffine3, DMat3, DVec3};
use serde::{Deserialize, Serialize};

use crate::capture::{Camera, Intrinsics, Projection, any_orthographic, is_believable_size};
use crate::plural::counted;
use crate::samples::{ImageFacts, SampleSet, Span};
use crate::store::container::{ByteReader, push_text};

/// Version of the format. Another major version cannot be read; a minor one only adds chunks that may be skipped.
pub(crate) const VERSION: (u16, u16) = (3, 2);
/// The major version of stores with orthographic cameras: readers that do not know them refuse it.
pub(crate) const WITH_PROJECTIONS: u16 = 4;

/// The minor version in which `DOUB` came, and the one of stores without it.
pub(crate) const WITH_DOUBTFUL: u16 = 1;
const WITHOUT_DOUBTFUL: u16 = 0;
/// The minor version in which `VALU` came: a store of an earlier one that has it was written again by a program that does not know it.
pub(crate) const WITH_VALUES: u16 = 2;

/// Most pixels that one picture of every camera may have together: what is drawn takes a table of them.
const MAX_TOTAL_PIXELS: usize = 1 << 34;
/// How far axes may be from those of a rotation, and `up` from unit length.
const RIGID_TOLERANCE: f64 = 1e-3;

/// The contents of `HEAD`.
pub(crate) struct HeadChunk {
    pub(crate) name: String,
    pub(crate) up_in_world: DVec3,
    pub(crate) cameras: Vec<Camera>,
    pub(crate) frame_numbers: Vec<i64>,
}

/// The position of one sample image, and its contents.
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
    /// The image that this one is predicted from: of the same camera, ending where this one starts.
    pub reference: Option<u32>,
    /// Bytes from the start of the file to the image's chunk.
    pub offset: u64,
    /// Bytes of the chunk's payload.
    pub length: u32,
    /// Bytes of the payload's head, which lists its blocks.
    pub head: u32,
}

/// Images that must be read before one can be: no chain of references is longer.
pub(crate) const MAX_REFERENCES: usize = 7;

/// No reference, in the index.
const NO_REFERENCE: u32 = u32::MAX;

/// The payload of `HEAD`; the version depends on whether the store lists doubtful samples and has scalar values.
pub(crate) fn encode_head(samples: &SampleSet, has_doubtful: bool) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    let has_projections = any_orthographic(&samples.cameras);
    let major = if has_projections { WITH_PROJECTIONS } else { VERSION.0 };
    bytes.extend_from_slice(&major.to_be_bytes());
    let minor = match (samples.values.is_empty(), has_doubtful) {
        (false, _) => WITH_VALUES,
        (true, true) => WITH_DOUBTFUL,
        (true, false) => WITHOUT_DOUBTFUL,
    };
    bytes.extend_from_slice(&minor.to_be_bytes());
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
        if has_projections {
            bytes.push(u8::from(intrinsics.is_orthographic()));
        }
    }
    bytes.extend_from_slice(&(samples.frame_numbers.len() as u32).to_be_bytes());
    for number in &samples.frame_numbers {
        bytes.extend_from_slice(&number.to_be_bytes());
    }
    // Whatever the reader would refuse is refused before it is written.
    decode_head(&bytes)?;
    Ok(bytes)
}

pub(crate) fn decode_head(bytes: &[u8]) -> Result<HeadChunk, String> {
    let mut reader = ByteReader::new(bytes);
    let (major, _minor) = (reader.u16()?, reader.u16()?);
    let has_projections = major == WITH_PROJECTIONS;
    let name = reader.text()?;
    let up_in_world = DVec3::new(reader.f64()?, reader.f64()?, reader.f64()?);
    let cameras = (0..reader.count(4 + 8 + 4 * 8 + 12 * 8)?)
        .map(|_| decode_camera(&mut reader, has_projections))
        .collect::<Result<Vec<_>, _>>()?;
    let frame_numbers = (0..reader.count(8)?).map(|_| reader.i64()).collect::<Result<Vec<_>, _>>()?;
    reader.finish()?;
    if (up_in_world.length() - 1.0).abs() > RIGID_TOLERANCE {
        return Err("up is no unit vector".to_owned());
    }
    let mut names = BTreeSet::new();
    if let Some(camera) = cameras.iter().find(|camera| !names.insert(camera.name.as_str())) {
        return Err(format!("two cameras are called '{}'", camera.name));
    }
    let pixels: usize = cameras.iter().map(|camera| camera.intrinsics.pixel_count()).sum();
    if pixels > MAX_TOTAL_PIXELS {
        return Err(format!("the pictures of the cameras have {pixels} pixels together"));
    }
    if let Some(name) =
        [&name].into_iter().chain(cameras.iter().map(|camera| &camera.name)).find(|name| has_controls(name))
    {
        return Err(format!("a name holds control characters: {name:?}"));
    }
    if !frame_numbers.is_sorted_by(|a, b| a < b) {
        return Err("the frame numbers do not ascend".to_owned());
    }
    Ok(HeadChunk { name, up_in_world, cameras, frame_numbers })
}

/// Whether a name would break a line or steer a terminal.
fn has_controls(name: &str) -> bool {
    name.contains(char::is_control)
}

fn decode_camera(reader: &mut ByteReader, has_projections: bool) -> Result<Camera, String> {
    let name = reader.text()?;
    let (width, height) = (reader.u32()?, reader.u32()?);
    if !is_believable_size(width as usize, height as usize) {
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
    let projection = match if has_projections { reader.u8()? } else { 0 } {
        0 => Projection::Perspective,
        1 => Projection::Orthographic,
        other => return Err(format!("camera '{name}' has the unknown projection {other}")),
    };
    let axes = world_from_camera.matrix3;
    let product = axes.transpose() * axes;
    if !product.abs_diff_eq(DMat3::IDENTITY, RIGID_TOLERANCE) || axes.determinant() < 0.0 {
        return Err(format!("the axes of camera '{name}' are no rotation"));
    }
    Ok(Camera {
        name,
        intrinsics: Intrinsics { width, height, fx, fy, cx, cy, projection },
        world_from_camera,
    })
}

/// The version, which comes first whatever else changes.
pub(crate) fn decode_version(head: &[u8]) -> Result<(u16, u16), String> {
    let mut reader = ByteReader::new(head);
    Ok((reader.u16()?, reader.u16()?))
}

/// The index of a file of `file_size` bytes.
pub(crate) fn encode_index(entries: &[ImageEntry], file_size: u64) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(12 + entries.len() * ENTRY_BYTES);
    bytes.extend_from_slice(&file_size.to_be_bytes());
    bytes.extend_from_slice(&(entries.len() as u32).to_be_bytes());
    for entry in entries {
        let ImageEntry { camera, span, samples, tiles, reference, offset, length, head } = *entry;
        let reference = reference.unwrap_or(NO_REFERENCE);
        for number in [camera, span.start, span.end, samples, tiles, reference] {
            bytes.extend_from_slice(&number.to_be_bytes());
        }
        bytes.extend_from_slice(&offset.to_be_bytes());
        bytes.extend_from_slice(&length.to_be_bytes());
        bytes.extend_from_slice(&head.to_be_bytes());
    }
    bytes
}

const ENTRY_BYTES: usize = 10 * 4;

pub(crate) fn decode_index(
    bytes: &[u8],
    file_size: u64,
    cameras: usize,
    frames: usize,
) -> Result<Vec<ImageEntry>, String> {
    let mut reader = ByteReader::new(bytes);
    let stated = reader.u64()?;
    if stated != file_size {
        return Err(format!(
            "the file should have {} but has {file_size}; copy it again",
            counted(stated, "byte")
        ));
    }
    let entries = (0..reader.count(ENTRY_BYTES)?)
        .map(|_| {
            Ok(ImageEntry {
                camera: reader.u32()?,
                span: Span { start: reader.u32()?, end: reader.u32()? },
                samples: reader.u32()?,
                tiles: reader.u32()?,
                reference: Some(reader.u32()?).filter(|reference| *reference != NO_REFERENCE),
                offset: reader.u64()?,
                length: reader.u32()?,
                head: reader.u32()?,
            })
        })
        .collect::<Result<Vec<_>, String>>()?;
    reader.finish()?;
    for entry in &entries {
        let Span { start, end } = entry.span;
        if entry.camera as usize >= cameras || start >= end || end as usize > frames {
            return Err(format!("no camera {} or no frames {start} to {end}", entry.camera));
        }
        if entry.head > entry.length {
            return Err("an image is shorter than its head".to_owned());
        }
    }
    check_held_once(&entries)?;
    // Two entries for one chunk would let a small file claim any number of samples.
    let end = |entry: &ImageEntry| entry.offset.saturating_add(u64::from(entry.length));
    if !entries.is_sorted_by(|a, b| end(a) <= b.offset) {
        return Err("images overlap or are out of order".to_owned());
    }
    let chain = (0..entries.len()).map(|index| chain(&entries, index).map(|chain| chain.len()));
    if chain.into_iter().any(|length| length.is_none_or(|length| length > MAX_REFERENCES + 1)) {
        return Err(
            "an image is predicted from one that does not come before it, or from too many".to_owned()
        );
    }
    Ok(entries)
}

/// A camera has at most one image of a span: two would hold its pixels twice.
pub(crate) fn check_held_once(entries: &[ImageEntry]) -> Result<(), String> {
    let mut held = BTreeSet::new();
    match entries.iter().find(|entry| !held.insert((entry.camera, entry.span))) {
        None => Ok(()),
        Some(ImageEntry { camera, span: Span { start, end }, .. }) => {
            Err(format!("two images of camera {camera} hold frames {start} to {end}"))
        }
    }
}

/// An image and those it is predicted from, itself first; `None` where a reference is not what it must be.
pub(crate) fn chain(entries: &[ImageEntry], index: usize) -> Option<Vec<usize>> {
    let mut chain = vec![index];
    let mut entry = entries.get(index)?;
    while let Some(reference) = entry.reference
        && chain.len() <= MAX_REFERENCES + 1
    {
        let before = entries.get(reference as usize)?;
        // References lead back in time, so that no chain is a ring.
        if before.camera != entry.camera || before.span.end != entry.span.start {
            return None;
        }
        chain.push(reference as usize);
        entry = before;
    }
    Some(chain)
}

/// Chooses what each image is predicted from: of the same camera, ending where it starts, the one with most samples; none where
/// too many would have to be read before it.
pub(crate) fn choose_references(images: &[&ImageFacts]) -> Vec<Option<u32>> {
    let mut ending_at = std::collections::BTreeMap::<(u32, u32), usize>::new();
    for (index, image) in images.iter().enumerate() {
        let best = ending_at.entry((image.camera, image.span.end)).or_insert(index);
        if image.samples > images[*best].samples {
            *best = index;
        }
    }
    let mut order: Vec<usize> = (0..images.len()).collect();
    order.sort_by_key(|index| images[*index].span.start);
    let mut references = vec![None; images.len()];
    let mut before = vec![0; images.len()];
    for index in order {
        let image = &images[index];
        if let Some(&reference) = ending_at.get(&(image.camera, image.span.start))
            && before[reference] < MAX_REFERENCES
        {
            before[index] = before[reference] + 1;
            references[index] = Some(reference as u32);
        }
    }
    references
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

/// Where a store comes from. What is not known is left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Provenance {
    /// Program and version that wrote the store.
    pub program: String,
    /// The files that were read.
    pub inputs: Option<InputFiles>,
    /// Whether frames are numbered by the order of times that are fractions, so that a view's time of 1 may mean another frame.
    pub frames_are_ranked: bool,
    /// What each plane of the samples takes in the store, bytes; filled in by the writer, except where samples are coded plainly.
    pub planes: Option<PlaneBytes>,
}

/// Bytes of the store, by what they hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PlaneBytes {
    /// Which pixels hold a sample.
    pub mask: u64,
    /// Inverse depth.
    pub depth: u64,
    /// Green, coded before red and blue.
    pub green: u64,
    /// Red.
    pub red: u64,
    /// Blue.
    pub blue: u64,
    /// Normals.
    pub normals: u64,
}

impl PlaneBytes {
    /// From the bits of the seven planes in their order.
    pub(crate) fn of_bits(bits: [f64; 7]) -> Self {
        let [mask, depth, green, red, blue, normal_x, normal_y] = bits;
        let bytes = |bits: f64| (bits / 8.0).round() as u64;
        Self {
            mask: bytes(mask),
            depth: bytes(depth),
            green: bytes(green),
            red: bytes(red),
            blue: bytes(blue),
            normals: bytes(normal_x + normal_y),
        }
    }
}

impl Default for Provenance {
    fn default() -> Self {
        Self {
            program: concat!("overlook ", env!("CARGO_PKG_VERSION")).to_owned(),
            inputs: None,
            frames_are_ranked: false,
            planes: None,
        }
    }
}

/// The files of a capture, as far as it takes to see whether they changed.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct InputFiles {
    /// How many.
    pub files: u64,
    /// Bytes of all of them.
    pub bytes: u64,
    /// CRC-32 of the list of every file's name, size and CRC-32, one a line, as `{crc:08x} {bytes} {name}`, sorted by name.
    pub crc32: u32,
}
