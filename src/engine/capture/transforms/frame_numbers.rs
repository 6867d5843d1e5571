//! Which frame a picture is: by its `frame` or `time`, by a number in its file's name, or by its place in the list.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::manifest::{Keys, Manifest, PictureEntry};
use super::numbers_in_names::NumbersInNames;
use crate::error::{Error, Result};

/// The number of every entry's frame: its `frame`, or its `time` where these are whole, their rank where they are fractions (as
/// nerfstudio's 0 to 1); without any, the numbers in file names, or else the order of appearance within the camera.
///
/// # Errors
/// `Invalid` if only some entries have a frame, or some have frames and some have fractions of time.
pub(crate) fn frame_numbers(
    keys: &[Keys],
    entries: &[PictureEntry],
    cameras: &[String],
    path: &Path,
) -> Result<Vec<i64>> {
    let given: Vec<f64> = keys.iter().filter_map(|keys| keys.frame.or(keys.time)).collect();
    if given.is_empty() {
        let by_name = NumbersInNames::find(entries, cameras).map(|numbers| numbers.frames(cameras));
        return Ok(by_name.unwrap_or_else(|| numbers_by_appearance(cameras)));
    }
    let refuse = |what: &str| Err(Error::invalid(path.display(), what));
    if given.len() < keys.len() {
        return refuse("some entries have a \"time\" and some do not; give it in all of them");
    }
    if given.iter().copied().all(is_number) {
        return Ok(given.iter().map(|number| *number as i64).collect());
    }
    let frames = keys.iter().filter(|keys| keys.frame.is_some()).count();
    if (1..keys.len()).contains(&frames) {
        return refuse(
            "some entries have a \"frame\" and some only a \"time\", of which some are fractions; give \"frame\" in all of them",
        );
    }
    let mut distinct = given.clone();
    distinct.sort_by(f64::total_cmp);
    distinct.dedup();
    Ok(given.iter().map(|time| distinct.partition_point(|other| other < time) as i64).collect())
}

/// Whether a time is the number of a frame.
fn is_number(time: f64) -> bool {
    time.fract() == 0.0 && time.abs() < 1e15
}

/// Whether the frames of a manifest are numbered by the order of times that are fractions.
pub(crate) fn are_ranked(manifest: &Manifest) -> bool {
    let given = |entry: &PictureEntry| entry.keys.frame.or(entry.keys.time);
    !manifest.frames.iter().filter_map(given).all(is_number)
}

fn numbers_by_appearance(cameras: &[String]) -> Vec<i64> {
    let mut seen: BTreeMap<&str, i64> = BTreeMap::new();
    let next = |camera| {
        let next = seen.entry(camera).or_insert(0);
        *next += 1;
        *next - 1
    };
    cameras.iter().map(String::as_str).map(next).collect()
}

/// How frames are paired where neither the manifest nor names say it; `None` where they do, or nothing is to be paired.
///
/// # Errors
/// `Invalid` for cameras whose file names share some numbers and not all: counted by order, pictures of different frames would be taken
/// for one.
pub(crate) fn pairing(entries: &[PictureEntry], cameras: &[String], path: &Path) -> Result<Option<String>> {
    let distinct: BTreeSet<&String> = cameras.iter().collect();
    if distinct.len() < 2 || distinct.len() == cameras.len() {
        return Ok(None);
    }
    let by = match NumbersInNames::find(entries, cameras) {
        None => "their place in the list, as no number in the names of files",
        Some(numbers) if numbers.are_same() => return Ok(None),
        Some(numbers) if numbers.are_disjoint() => {
            "the order of the numbers in the names of each camera's files, as none of them"
        }
        Some(numbers) => {
            let (camera, number) = numbers.missing().unwrap_or_default();
            let what = format!(
                "camera '{camera}' has no picture with number {number} in its name, as others have; give every entry the number of its frame as \"frame\", or take out the pictures that not every camera has"
            );
            return Err(Error::invalid(path.display(), what));
        }
    };
    Ok(Some(format!(
        "{}: the frames of different cameras are paired by {by} is the same in all cameras; where that is wrong, give every entry the number of its frame as \"frame\"",
        path.display()
    )))
}

/// Refuses views whose times are fractions; where those of their capture are, so that a time of 1 may mean frame 1 or the last one,
/// all that give a time and no number of a frame.
pub(crate) fn refuse_times(manifest: &Manifest, path: &Path, is_ranked: bool) -> Result<()> {
    for (index, entry) in manifest.frames.iter().enumerate() {
        let (own, file) = (&entry.keys, &manifest.keys);
        let given = [(own.frame, true), (own.time, false), (file.frame, true), (file.time, false)];
        let given = given.into_iter().find_map(|(time, is_frame)| Some((time?, is_frame)));
        let Some((time, is_frame)) = given else { continue };
        if !is_number(time) || (is_ranked && !is_frame) {
            let what = format!(
                "time {time} names no frame, for where times are fractions, frames are numbered by their order; write that number as \"frame\" in place of the time"
            );
            return Err(Error::invalid(
                format!("{}, frames[{index}] ({})", path.display(), entry.file_path),
                what,
            ));
        }
    }
    Ok(())
}
