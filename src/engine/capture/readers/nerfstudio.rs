//! `transforms.json` of nerfstudio and instant-ngp, and our superset of it.

use super::place::SourceFolder;
use super::reader::{Description, ReadSource, Reader, SaidBy};
use crate::capture::transforms::{MANIFEST_NAME, Manifest, ManifestOrigin, is_recording};
use crate::error::Result;
use crate::whole_file;

/// Reads a manifest: the file itself, or the one in the folder.
pub(super) const NERFSTUDIO: Reader = Reader {
    source: "transforms.json (nerfstudio, instant-ngp, Overlook)",
    marks: MANIFEST_NAME,
    stands_for_folder: |_| true,
    is_here: |place| match &place.file {
        Some(name) => name == MANIFEST_NAME || (is_json(name) && holds_frames(place)),
        None => place.has(MANIFEST_NAME),
    },
    poses: "camera to world; camera x right, y up, looking along −z",
    depth: "",
    lens: "",
    read,
};

fn read(place: &SourceFolder, mut description: Description) -> Result<ReadSource> {
    let path = place.join(place.file.as_deref().unwrap_or(MANIFEST_NAME));
    let manifest = Manifest::read(&path)?;
    description.is_recording = is_recording(&manifest);
    description.found = manifest.frames.len();
    let origin = ManifestOrigin::of_file(&path);
    Ok(ReadSource { manifest, origin, inputs: vec![path], description, said_by: SaidBy::Manifest })
}

fn is_json(name: &str) -> bool {
    name.to_ascii_lowercase().ends_with(".json")
}

/// Whether a JSON file lists pictures as a manifest does. One that is no JSON counts too: reading it names the fault.
fn holds_frames(place: &SourceFolder) -> bool {
    let Ok(bytes) = whole_file::read_all(&place.path) else { return false };
    let document: Result<serde_json::Value, _> = serde_json::from_slice(&bytes);
    document.map_or(true, |document| document.get("frames").is_some())
}
