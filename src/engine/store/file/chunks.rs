//! The chunks that say what a store holds, found and read before any image.
//!
//! The report of a store, deflated where it is long.
//!
//! Purpose: a report says something of each camera, so that of hundreds of small views it would be longer than their samples. Source: zlib
//! (RFC 1950). What differs: a short report stays as it is, so that other programs read it without inflating it.

use std::collections::BTreeMap;
use std::path::Path;

use libdeflater::{CompressionLvl, Compressor, Decompressor};

use super::header::{ImageEntry, VERSION, WITH_DOUBTFUL, WITH_PROJECTIONS, WITH_VALUES, decode_version};
use crate::capture::Camera;
use crate::error::{Error, Result};
use crate::plural::counted;
use crate::samples::{TILE, TILE_SAMPLES};
use crate::settings::Settings;
use crate::store::container::{
    ByteReader, CHECKSUM, CHUNK_HEADER, ChunkHeader, ChunkId, DOUBTFUL, FORM_HEADER, FormReader, HEAD, INDEX,
    IffError, LONG_REPORT, MODEL, PALETTE, PROVENANCE, REPORT, ReadAt, SETTINGS, VALUES, VERDICTS,
    push_varint,
};
use crate::store::image::DoubtfulRuns;

/// The payloads of the chunks that say what a store holds.
pub(crate) struct InfoChunks {
    pub(crate) version: (u16, u16),
    payloads: BTreeMap<ChunkId, Vec<u8>>,
    /// The first chunk of verdicts, which stays where it is.
    pub(crate) verdicts: Option<ChunkHeader>,
}

/// Chunks that every store has once.
pub(crate) const REQUIRED: [ChunkId; 7] = [HEAD, SETTINGS, REPORT, PROVENANCE, PALETTE, MODEL, INDEX];

/// Whether a chunk is one of those that [`InfoChunks`] holds.
pub(crate) fn is_known(id: ChunkId) -> bool {
    REQUIRED.contains(&id) || [DOUBTFUL, LONG_REPORT, VALUES].contains(&id)
}

impl InfoChunks {
    /// Walks over the file until all that are required are found, skipping images and unknown chunks. `DOUB`, `VALU` and `RPTZ` come
    /// before the last of them.
    pub(crate) fn collect(form: &FormReader<Box<dyn ReadAt>>, path: &Path) -> Result<Self> {
        let iff = |error| from_iff(path, error);
        let mut version = None;
        let mut payloads = BTreeMap::new();
        let mut offset = FORM_HEADER;
        let mut required = 0;
        let mut verdicts = None;
        while required < REQUIRED.len()
            && let Some(header) = form.header_at(offset).map_err(iff)?
        {
            if version.is_none() && header.id != HEAD {
                return Err(in_chunk(path, HEAD, "it must be the first chunk"));
            }
            if header.id == VERDICTS {
                verdicts = verdicts.or(Some(header));
            }
            if is_known(header.id) {
                required += usize::from(REQUIRED.contains(&header.id));
                let payload = form.payload(&header).map_err(iff)?;
                if header.id == HEAD && version.is_none() {
                    version = Some(checked_version(&payload, path)?);
                }
                if payloads.insert(header.id, payload).is_some() {
                    return Err(in_chunk(path, header.id, "there are two of them"));
                }
            }
            offset = header.end();
        }
        if let Some(missing) = REQUIRED.iter().find(|id| !payloads.contains_key(*id)) {
            return Err(in_chunk(path, *missing, "it is missing"));
        }
        let version = version.ok_or_else(|| in_chunk(path, HEAD, "it is missing"))?;
        if version.1 >= WITH_DOUBTFUL && !payloads.contains_key(&DOUBTFUL) {
            return Err(in_chunk(path, DOUBTFUL, "it is missing"));
        }
        if version.1 < WITH_VALUES {
            // Kept by a program that does not know them: what they say of places is not true any more.
            payloads.remove(&VALUES);
        } else if version.1 == WITH_VALUES && !payloads.contains_key(&VALUES) {
            return Err(in_chunk(path, VALUES, "it is missing"));
        }
        Ok(Self { version, payloads, verdicts })
    }

    /// Bytes of some chunks in the file.
    pub(crate) fn bytes(&self, ids: &[ChunkId]) -> u64 {
        let of_chunk = |id: &ChunkId| {
            let payload = self.get(*id).len() as u64 + CHECKSUM;
            CHUNK_HEADER + payload.next_multiple_of(2)
        };
        ids.iter().filter(|id| self.payloads.contains_key(*id)).map(of_chunk).sum()
    }

    /// The payload of a chunk; empty where there is none.
    pub(crate) fn get(&self, id: ChunkId) -> &[u8] {
        self.payloads.get(&id).map_or(&[], Vec::as_slice)
    }
}

/// Settings come and go between versions, which does the samples no harm: unknown ones are left out with a warning.
pub(crate) fn decode_settings(toml: &[u8]) -> Result<(Settings, Vec<String>), String> {
    let text = std::str::from_utf8(toml).map_err(|error| error.to_string())?;
    let (settings, unknown) = Settings::known_from_toml(text).ok_or("it is not TOML")?;
    let warn = |stated: String| format!("made with {stated}, which this Overlook does not know");
    Ok((settings, unknown.into_iter().map(warn).collect()))
}

fn checked_version(head: &[u8], path: &Path) -> Result<(u16, u16)> {
    let version = decode_version(head).map_err(|what| in_chunk(path, HEAD, what))?;
    if ![VERSION.0, WITH_PROJECTIONS].contains(&version.0) {
        let what = format!(
            "the store has version {}.{}, this Overlook reads {}.x and {WITH_PROJECTIONS}.x; use the Overlook that wrote it or preprocess again",
            version.0, version.1, VERSION.0
        );
        return Err(Error::unsupported(path.display(), what));
    }
    Ok(version)
}

pub(crate) fn in_chunk(path: &Path, id: ChunkId, what: impl std::fmt::Display) -> Error {
    Error::invalid(format!("{}: chunk '{}'", path.display(), id.escape_ascii()), what.to_string())
}

pub(crate) fn from_iff(path: &Path, error: IffError) -> Error {
    match error {
        IffError::Io(error) => Error::io(path, error),
        IffError::TooLarge { .. } => Error::unsupported(
            path.display(),
            "one image would take more than 4 GiB; preprocess smaller pictures",
        ),
        error @ IffError::Malformed { .. } => Error::invalid(path.display(), error.to_string()),
    }
}

/// The payload for the runs of images, by their place in the index, ascending.
pub(crate) fn encode_doubtful(images: &[(usize, DoubtfulRuns)]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut next = 0;
    for (index, runs) in images {
        push_varint(&mut bytes, (index - next) as u64);
        next = index + 1;
        let lengths = runs.lengths();
        push_varint(&mut bytes, lengths.len() as u64);
        lengths.for_each(|length| push_varint(&mut bytes, u64::from(length)));
    }
    bytes
}

/// The runs of images, by their place in the index.
pub(crate) fn decode_doubtful(
    payload: &[u8],
    images: &[ImageEntry],
    cameras: &[Camera],
) -> Result<BTreeMap<usize, DoubtfulRuns>, String> {
    let mut reader = ByteReader::new(payload);
    let mut all = BTreeMap::new();
    let mut next = 0_usize;
    while !reader.rest.is_empty() {
        let index = next.saturating_add(reader.varint()? as usize);
        let entry = images.get(index).ok_or_else(|| format!("there is no image {index}"))?;
        next = index + 1;
        let (width, height) = cameras[entry.camera as usize].intrinsics.size();
        let pixels = width.div_ceil(TILE) * height.div_ceil(TILE) * TILE_SAMPLES;
        let count = reader.varint()?;
        // A run takes a byte at least.
        if count > reader.rest.len() as u64 {
            return Err("the chunk is too short".to_owned());
        }
        all.insert(index, DoubtfulRuns::from_lengths((0..count).map(|_| reader.varint()), pixels)?);
    }
    Ok(all)
}

/// Shorter reports stay as they are, bytes.
const LONG: usize = 1 << 16;

/// What readers find in place of a long report where they do not know the chunk that holds it.
pub(super) const EMPTY: &str = "{}";

/// Deflate makes at most this many bytes of one.
const MOST_PER_BYTE: usize = 1032;

/// Bytes before the deflated report: a `u32`, its length once inflated.
const LENGTH: usize = 4;

/// The payload of the chunk that holds a report (JSON); `None` for one that stays as it is.
pub(super) fn packed(report: &str) -> Option<Vec<u8>> {
    let length = u32::try_from(report.len()).ok().filter(|_| report.len() >= LONG)?;
    let mut compressor = Compressor::new(CompressionLvl::best());
    let mut payload = vec![0; LENGTH + compressor.zlib_compress_bound(report.len())];
    payload[..LENGTH].copy_from_slice(&length.to_be_bytes());
    let bytes = compressor.zlib_compress(report.as_bytes(), &mut payload[LENGTH..]).ok()?;
    payload.truncate(LENGTH + bytes);
    Some(payload)
}

/// The report in such a payload.
///
/// # Errors
/// What is wrong with the payload.
pub(super) fn unpacked(payload: &[u8]) -> Result<String, String> {
    let (length, deflated) = payload.split_first_chunk::<LENGTH>().ok_or("it is too short")?;
    let length = u32::from_be_bytes(*length) as usize;
    if length > deflated.len().saturating_mul(MOST_PER_BYTE) {
        return Err(format!("{} cannot hold {length}", counted(deflated.len(), "byte")));
    }
    let mut report = vec![0; length];
    let bytes = Decompressor::new().zlib_decompress(deflated, &mut report);
    let bytes = bytes.map_err(|error| format!("it cannot be inflated: {error}"))?;
    if bytes != length {
        return Err(format!("it holds {} in place of {length}", counted(bytes, "byte")));
    }
    String::from_utf8(report).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::Intrinsics;
    use crate::samples::Span;
    use glam::DVec3;

    #[test]
    fn runs_come_back_for_the_images_that_have_some_and_what_names_no_image_is_refused() {
        let lens = Intrinsics::from_horizontal_angle(40, 20, 1.0);
        let cameras = [Camera::look_at("c", lens, DVec3::ZERO, DVec3::Y, DVec3::Z)];
        let entry = ImageEntry {
            camera: 0,
            span: Span { start: 0, end: 1 },
            samples: 1,
            tiles: 1,
            reference: None,
            offset: 0,
            length: 0,
            head: 0,
        };
        let images = vec![entry; 5];
        let runs =
            |lengths: &[u64]| DoubtfulRuns::from_lengths(lengths.iter().copied().map(Ok), 1536).unwrap();
        let written = [(1, runs(&[0, 300])), (3, runs(&[7, 1, 1000]))];
        let bytes = encode_doubtful(&written);
        assert_eq!(decode_doubtful(&bytes, &images, &cameras).unwrap(), BTreeMap::from(written));
        assert_eq!(decode_doubtful(&[], &images, &cameras).unwrap(), BTreeMap::new());
        assert!(decode_doubtful(&bytes, &images[..3], &cameras).unwrap_err().contains("no image 3"));
        for cut in 1..bytes.len() {
            let _ = decode_doubtful(&bytes[..cut], &images, &cameras);
        }
        assert!(decode_doubtful(&[0, 0xff, 0xff, 0x7f], &images, &cameras).is_err());
    }

    fn long() -> String {
        let numbers: Vec<String> = (0..20_000).map(|number| (number * number % 9973).to_string()).collect();
        format!("{{\"numbers\":[{}]}}", numbers.join(","))
    }

    #[test]
    fn a_long_report_takes_less_and_comes_back_and_a_short_one_stays() {
        let report = long();
        let payload = packed(&report).unwrap();
        assert!(2 * payload.len() < report.len());
        assert_eq!(unpacked(&payload).unwrap(), report);
        assert_eq!(packed(&report[..LONG - 1]), None);
    }

    #[test]
    fn a_damaged_payload_is_an_error_and_makes_no_large_buffer() {
        let payload = packed(&long()).unwrap();
        for cut in [0, 3, 4, 5, payload.len() / 2, payload.len() - 1] {
            assert!(unpacked(&payload[..cut]).is_err(), "{cut}");
        }
        let mut lies = payload.clone();
        lies[..LENGTH].fill(0xff);
        assert!(unpacked(&lies).unwrap_err().contains("cannot hold"));
        lies[..LENGTH].copy_from_slice(&70_000_u32.to_be_bytes());
        assert!(unpacked(&lies).is_err());
    }
}
