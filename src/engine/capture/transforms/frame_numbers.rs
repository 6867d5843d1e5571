//! Which frame a picture is: by its `frame` or `time`, by the number in its file's name, or by its place in the list.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::files::without_extension;
use super::manifest::{Keys, Manifest, PictureEntry};
use crate::error::{Error, Result};

/// The number of every entry's frame: its `frame`, or its `time` where these are whole, their rank where they are fractions (as
/// nerfstudio's 0 to 1); without any, the order of the numbers that file names end in, or else of appearance within the camera.
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
        return Ok(numbers_by_name(entries, cameras).unwrap_or_else(|| numbers_by_appearance(cameras)));
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

/// The numbers in the names of each camera's files, by the camera's name.
type ByCamera<'a> = Vec<(&'a str, BTreeSet<u64>)>;

/// The numbers that the names of each camera's files end in, cameras in order of appearance; `None` where a name has none, a
/// camera has one twice, or no camera has several pictures.
fn numbers_in_names<'a>(entries: &[PictureEntry], cameras: &'a [String]) -> Option<(Vec<u64>, ByCamera<'a>)> {
    let numbers: Vec<u64> =
        entries.iter().map(|entry| number_in_name(&entry.file_path)).collect::<Option<_>>()?;
    let mut index_of: BTreeMap<&str, usize> = BTreeMap::new();
    let mut sets: ByCamera = Vec::new();
    for (camera, number) in cameras.iter().zip(&numbers) {
        let index = *index_of.entry(camera).or_insert(sets.len());
        if index == sets.len() {
            sets.push((camera, BTreeSet::new()));
        }
        if !sets[index].1.insert(*number) {
            return None;
        }
    }
    sets.iter().any(|(_, numbers)| numbers.len() > 1).then_some((numbers, sets))
}

fn number_in_name(file_path: &str) -> Option<u64> {
    let name = without_extension(file_path);
    let start = name
        .rfind(|letter: char| !letter.is_ascii_digit())
        .map_or(0, |at| at + name[at..].chars().next().map_or(0, char::len_utf8));
    name[start..].parse().ok()
}

/// The order of the numbers that file names end in, where all cameras have the same.
fn numbers_by_name(entries: &[PictureEntry], cameras: &[String]) -> Option<Vec<i64>> {
    let (numbers, sets) = numbers_in_names(entries, cameras)?;
    let (_, first) = sets.first()?;
    let are_same = sets.iter().all(|(_, numbers)| numbers == first);
    are_same.then(|| numbers.iter().map(|number| first.range(..number).count() as i64).collect())
}

/// Refuses cameras whose file names share some numbers and not all, where nothing else numbers the frames: counted by order,
/// pictures of different frames would be taken for one frame.
pub(crate) fn refuse_gaps(entries: &[PictureEntry], cameras: &[String], path: &Path) -> Result<()> {
    let Some((_, sets)) = numbers_in_names(entries, cameras) else { return Ok(()) };
    let all: BTreeSet<u64> = sets.iter().flat_map(|(_, numbers)| numbers).copied().collect();
    let are_disjoint = sets.iter().map(|(_, numbers)| numbers.len()).sum::<usize>() == all.len();
    let missing = |(camera, numbers): &(&str, BTreeSet<u64>)| {
        Some(((*camera).to_owned(), *all.difference(numbers).next()?))
    };
    match sets.iter().find_map(missing) {
        Some((camera, number)) if !are_disjoint => Err(Error::invalid(
            path.display(),
            format!(
                "camera '{camera}' has no picture with number {number} in its name, as others have; give every entry the number of its frame as \"frame\", or take out the pictures that not every camera has"
            ),
        )),
        _ => Ok(()),
    }
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
