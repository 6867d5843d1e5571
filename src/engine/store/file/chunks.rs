//! The chunks that say what a store holds, found and read before any image.

use std::collections::BTreeMap;
use std::path::Path;

use super::header::{VERSION, WITH_DOUBTFUL, WITH_PROJECTIONS, WITH_VALUES, decode_version};
use crate::error::{Error, Result};
use crate::settings::Settings;
use crate::store::container::{
    CHECKSUM, CHUNK_HEADER, ChunkId, DOUBTFUL, FORM_HEADER, FormReader, HEAD, INDEX, IffError, LONG_REPORT,
    MODEL, PALETTE, PROVENANCE, REPORT, ReadAt, SETTINGS, VALUES,
};

/// The payloads of the chunks that say what a store holds.
pub(crate) struct InfoChunks {
    pub(crate) version: (u16, u16),
    payloads: BTreeMap<ChunkId, Vec<u8>>,
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
        while required < REQUIRED.len()
            && let Some(header) = form.header_at(offset).map_err(iff)?
        {
            if version.is_none() && header.id != HEAD {
                return Err(in_chunk(path, HEAD, "it must be the first chunk"));
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
        Ok(Self { version, payloads })
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
