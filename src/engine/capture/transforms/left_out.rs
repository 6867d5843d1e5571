//! Pictures of a manifest that cannot be used, though the others can: they are left out, counted and named.
//!
//! A picture of a camera with several frames leaves a gap: a frame without samples. Only where no picture is left is the capture
//! refused.

use std::collections::{BTreeMap, BTreeSet};

use super::exr_picture::no_depth;
use super::manifest::{Manifest, PictureEntry};
use super::manifest_file::ManifestOrigin;
use super::placed_entry::PlacedEntry;
use super::pose;
use crate::capture::parts::Skipped;
use crate::capture::pictures::{PictureFormat, format_of};
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
    /// What is wrong with the pose of each of its pictures, which has that of another picture of its camera.
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
    let mut posed = Manifest { keys: manifest.keys.clone(), ..Manifest::default() };
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

/// The pictures of a capture that are left out.
pub(super) struct LeftOut {
    skipped: Vec<Skipped>,
    /// The error of the first one.
    first: Option<Error>,
}

impl LeftOut {
    /// With those that are no entries any more.
    pub(super) fn new(skipped: Vec<Skipped>) -> Self {
        Self { skipped, first: None }
    }

    /// A line for each reason.
    pub(super) fn lines(&self) -> impl Iterator<Item = String> {
        self.skipped.iter().map(Skipped::line)
    }

    fn leave_out(&mut self, entry: &mut PlacedEntry, fault: Fault) {
        entry.is_left_out = true;
        Skipped::note(&mut self.skipped, fault.reason, &entry.file_path);
        self.first.get_or_insert(fault.error);
    }

    /// Leaves out the entries with a fault of their pose.
    pub(super) fn by_pose(&mut self, entries: &mut [PlacedEntry], faults: Vec<Option<Fault>>) {
        for (entry, fault) in entries.iter_mut().zip(faults) {
            if let Some(fault) = fault {
                self.leave_out(entry, fault);
            }
        }
    }

    /// Puts gaps where cameras lack a frame that others have, if these are exceptions.
    pub(super) fn fill_gaps(
        &mut self,
        by_camera: &mut BTreeMap<String, BTreeMap<i64, PlacedEntry>>,
        numbers: &BTreeSet<i64>,
    ) {
        /// Fewer than one of so many pictures. Where more are missing, frames are numbered wrongly rather than lost.
        const OF: usize = 4;
        let pictures = by_camera.len() * numbers.len();
        let there: usize = by_camera.values().map(BTreeMap::len).sum();
        if OF * (pictures - there) >= pictures {
            return;
        }
        for frames in by_camera.values_mut() {
            for number in numbers {
                let gap = frames.values().next().map(|entry| entry.gap_at(*number));
                if let (Some(gap), false) = (gap, frames.contains_key(number)) {
                    Skipped::note(&mut self.skipped, "that are in no file", gap.place.clone());
                    frames.insert(*number, gap);
                }
            }
        }
    }

    /// Leaves out the entries whose files cannot be used, then cameras and frames without any other, and gives the numbers of the
    /// frames. Cameras are looked at in this `order`.
    ///
    /// # Errors
    /// That of the first entry that was left out, if no other is there.
    pub(super) fn by_files(
        &mut self,
        order: &[String],
        by_camera: &mut BTreeMap<String, BTreeMap<i64, PlacedEntry>>,
    ) -> Result<Vec<i64>> {
        for name in order {
            let frames = by_camera.get_mut(name).into_iter().flat_map(BTreeMap::values_mut);
            for entry in frames.filter(|entry| !entry.is_left_out) {
                if let Some(fault) = file_fault(entry) {
                    self.leave_out(entry, fault);
                }
            }
        }
        by_camera.retain(|_, frames| frames.values().any(|entry| !entry.is_left_out));
        let read = by_camera.values().flatten().filter(|(_, entry)| !entry.is_left_out);
        let numbers: BTreeSet<i64> = read.map(|(number, _)| *number).collect();
        for frames in by_camera.values_mut() {
            frames.retain(|number, _| numbers.contains(number));
        }
        match self.first.take() {
            Some(error) if by_camera.is_empty() => Err(error),
            _ => Ok(numbers.into_iter().collect()),
        }
    }
}
