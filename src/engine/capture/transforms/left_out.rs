//! Pictures of a manifest that cannot be used, though the others can: they are left out, counted and named.
//!
//! A picture of a camera with several frames leaves a gap: a frame without samples. Only where no picture is left is the capture
//! refused.

use std::collections::{BTreeMap, BTreeSet};

use super::exr_picture::no_depth;
use super::manifest::{Manifest, PictureEntry};
use super::origin::ManifestOrigin;
use super::placed_entry::PlacedEntry;
use super::pose;
use crate::capture::pictures::{PictureFormat, format_of};
use crate::capture::skipped::Skipped;
use crate::error::{Error, Result};

/// The reason of pictures that are there and cannot be read.
pub(super) const UNREADABLE: &str = "that cannot be read";

/// What is wrong with one picture.
pub(super) struct Fault {
    /// Why it is left out, behind a count of such pictures.
    pub reason: String,
    /// The error if no other picture can be used.
    pub error: Error,
}

/// A manifest whose pictures all have a possible pose.
pub(super) struct Posed {
    pub manifest: Manifest,
    /// Of each picture of it, what is wrong with its own pose: it has that of another picture of its camera.
    pub faults: Vec<Option<Fault>>,
    /// Those that are not in it.
    pub skipped: Vec<Skipped>,
}

/// The numbers of a matrix, bit for bit.
type PoseKey = Vec<u64>;

fn pose_key(entry: &PictureEntry) -> PoseKey {
    entry.transform_matrix.iter().flatten().map(|value| value.to_bits()).collect()
}

fn names_camera(manifest: &Manifest) -> bool {
    manifest.keys.camera.is_some() || manifest.frames.iter().any(|entry| entry.keys.camera.is_some())
}

/// Whether a manifest that names no camera is of one that moves: most poses occur once.
pub(crate) fn is_recording(manifest: &Manifest) -> bool {
    let mut counts: BTreeMap<PoseKey, usize> = BTreeMap::new();
    for entry in &manifest.frames {
        *counts.entry(pose_key(entry)).or_default() += 1;
    }
    let single = counts.values().filter(|count| **count == 1).count();
    !names_camera(manifest) && counts.len() > 1 && 2 * single > counts.len()
}

/// Leaves out pictures with impossible poses, and of a recording those that repeat a pose.
///
/// # Errors
/// That of the first picture if no pose is possible, or if poses mirror that are no exception.
pub(super) fn with_possible_poses(manifest: &Manifest, origin: &ManifestOrigin) -> Result<Posed> {
    let faults: Vec<Option<Fault>> = pose_faults(manifest, origin);
    let all = faults.len();
    let mirrored = manifest.frames.iter().zip(&faults);
    let mirrored =
        mirrored.filter(|(entry, fault)| fault.is_some() && pose::mirrors(&entry.transform_matrix));
    let is_lost = faults.iter().all(Option::is_some) || 2 * mirrored.count() >= all;
    let mut skipped = Vec::new();
    let repeated = repeated_poses(manifest, &faults);
    // The pose of a camera whose other pictures have one.
    let mut known: BTreeMap<String, Vec<Vec<f64>>> = BTreeMap::new();
    for (entry, fault) in manifest.frames.iter().zip(&faults) {
        if let (Some(camera), None) = (&entry.keys.camera, fault) {
            known.entry(camera.clone()).or_insert_with(|| entry.transform_matrix.clone());
        }
    }
    let mut posed = Manifest { keys: manifest.keys.clone(), frames: Vec::new() };
    let mut kept = Vec::new();
    for (index, (entry, fault)) in manifest.frames.iter().zip(faults).enumerate() {
        match fault {
            Some(fault) if is_lost => return Err(fault.error),
            Some(fault) => match entry.keys.camera.as_ref().and_then(|camera| known.get(camera)) {
                Some(matrix) => {
                    posed.frames.push(PictureEntry { transform_matrix: matrix.clone(), ..entry.clone() });
                    kept.push(Some(fault));
                }
                None => Skipped::note(&mut skipped, fault.reason, &entry.file_path),
            },
            None if repeated.contains(&index) => {
                Skipped::note(&mut skipped, "with the pose of another", &entry.file_path);
            }
            None => {
                posed.frames.push(entry.clone());
                kept.push(None);
            }
        }
    }
    Ok(Posed { manifest: posed, faults: kept, skipped })
}

fn pose_faults(manifest: &Manifest, origin: &ManifestOrigin) -> Vec<Option<Fault>> {
    let fault = |(index, entry): (usize, &PictureEntry)| {
        let convention = entry.keys.clone().or(&manifest.keys).pose_convention();
        let why = pose::checked(&entry.transform_matrix, convention).err()?;
        let place = pose::place_of(origin, index, &entry.file_path);
        let (what, _advice) = why.split_once(';').unwrap_or((why, ""));
        Some(Fault { reason: format!("whose transform_matrix {what}"), error: pose::refused(&place, why) })
    };
    manifest.frames.iter().enumerate().map(fault).collect()
}

/// The pictures of a recording whose pose another one before them has.
fn repeated_poses(manifest: &Manifest, faults: &[Option<Fault>]) -> BTreeSet<usize> {
    let is_timed = |entry: &PictureEntry| entry.keys.frame.or(entry.keys.time).is_some();
    if !is_recording(manifest) || manifest.frames.iter().any(is_timed) {
        return BTreeSet::new();
    }
    let mut seen = BTreeSet::new();
    let entries = manifest.frames.iter().zip(faults).enumerate();
    let repeats = entries.filter(|(_, (entry, fault))| fault.is_none() && !seen.insert(pose_key(entry)));
    repeats.map(|(index, _)| index).collect()
}

/// What is wrong with the files of a picture; `None` if nothing is.
fn file_fault(entry: &PlacedEntry) -> Option<Fault> {
    if let Some((what, error)) = entry.files.missing(&entry.place) {
        return Some(Fault { reason: format!("whose {what} file is missing"), error });
    }
    let holds_depth = match format_of(&entry.files.color, &entry.place) {
        Ok(PictureFormat::Exr) | Err(_) => true,
        Ok(_) => false,
    };
    let lacks_depth = entry.files.depth.is_none() && !holds_depth;
    lacks_depth.then(|| Fault { reason: "without depth".to_owned(), error: no_depth(&entry.place) })
}

/// Puts gaps where cameras lack a frame that others have, if these are exceptions, and notes them.
pub(super) fn fill_gaps(
    by_camera: &mut BTreeMap<String, BTreeMap<i64, PlacedEntry>>,
    frame_numbers: &[i64],
    skipped: &mut Vec<Skipped>,
) {
    /// Of so many pictures one may be missing. Where more are, frames are numbered wrongly rather than lost.
    const OF: usize = 4;
    let pictures = by_camera.len() * frame_numbers.len();
    let there: usize = by_camera.values().map(BTreeMap::len).sum();
    if OF * (pictures - there) >= pictures {
        return;
    }
    for frames in by_camera.values_mut() {
        for number in frame_numbers {
            let gap = frames.values().next().map(|entry| entry.gap_at(*number));
            if let (Some(gap), false) = (gap, frames.contains_key(number)) {
                Skipped::note(skipped, "that are in no file", gap.place.clone());
                frames.insert(*number, gap);
            }
        }
    }
}

/// Marks the entries that cannot be used, by the faults of their poses and files, and notes them.
///
/// # Errors
/// That of the first entry if all have a fault.
pub(super) fn leave_out(
    entries: &mut [PlacedEntry],
    faults: Vec<Option<Fault>>,
    skipped: &mut Vec<Skipped>,
) -> Result<()> {
    let mut first = None;
    let mut is_any_read = false;
    for (entry, fault) in entries.iter_mut().zip(faults) {
        let Some(fault) = fault.or_else(|| file_fault(entry)) else {
            is_any_read = true;
            continue;
        };
        entry.is_left_out = true;
        Skipped::note(skipped, fault.reason, &entry.file_path);
        first.get_or_insert(fault.error);
    }
    match first {
        Some(error) if !is_any_read => Err(error),
        _ => Ok(()),
    }
}
