//! Scalar values from their files: `NumPy` arrays, and channels of OpenEXR.

use std::collections::BTreeSet;
use std::path::Path;

use rayon::prelude::*;

use super::cameras::CameraFiles;
use super::files::PictureFiles;
use super::placed_entry::PlacedEntry;
use super::value_keys::ValueKeys;
use super::value_places::{ValueFile, listed};
use crate::capture::camera::{Camera, wrong_size};
use crate::capture::exr::{ChannelPlane, ExrFile};
use crate::capture::pictures::{self, PictureFormat, format_of, parse_npy};
use crate::capture::values::{DEFAULT_TOLERANCE, MISSING_VALUE, ValueChannel, Values};
use crate::error::{Error, Result};
use crate::whole_file;

/// Whole numbers up to this one are exact in single precision.
const LARGEST_WHOLE: f32 = 16_777_216.0;

/// The values of a picture, as a pinhole shows them; `place` names file, camera and frame in errors.
///
/// # Errors
/// `Io`, `Invalid`, `Unsupported` for a file that is damaged, of another size, or without the channel.
pub(super) fn read(files: &PictureFiles, camera: &Camera, place: &str) -> Result<Values> {
    let mut planes = Vec::with_capacity(files.values.len());
    for value in &files.values {
        let mut plane = plane(value, &files.color, camera, place)?;
        if let Some(distortion) = &files.distortion {
            plane = pictures::sources(&camera.intrinsics, distortion).nearest(&plane, MISSING_VALUE);
        }
        planes.push(plane);
    }
    Ok(Values::from_planes(&planes))
}

fn plane(value: &ValueFile, color: &Path, camera: &Camera, place: &str) -> Result<Vec<f32>> {
    let path = value.path.as_deref().unwrap_or(color);
    let place = &match &value.path {
        Some(path) => format!("{place}, value '{}' in {}", value.name, path.display()),
        None => format!("{place}, value '{}'", value.name),
    };
    let size = camera.intrinsics.size();
    match format_of(path, place)? {
        PictureFormat::Exr => exr_plane(path, &value.channel, size, place),
        PictureFormat::Npy => {
            let array = parse_npy(&whole_file::read_all(path)?, place)?;
            if array.size != size {
                return Err(wrong_size(place, array.size, size));
            }
            if !array.is_exact {
                let what = format!("it has whole numbers from {LARGEST_WHOLE} on; save it as float32");
                return Err(Error::unsupported(place, what));
            }
            Ok(array.values)
        }
        _ => Err(Error::unsupported(
            place,
            "values are read from .npy and from channels of OpenEXR; name its file in value_file_paths",
        )),
    }
}

fn exr_plane(path: &Path, channel: &str, size: (usize, usize), place: &str) -> Result<Vec<f32>> {
    const SHOWN: usize = 16;
    let file = ExrFile::open(path, place)?;
    let Some(index) = file.channels().iter().position(|found| found.name == channel) else {
        let names: Vec<&str> = file.channels().iter().map(|it| it.name.as_str()).take(SHOWN).collect();
        let what = format!(
            "there is no channel '{channel}' among {}; name one as its \"channel\", or its file in value_file_paths",
            names.join(", ")
        );
        return Err(Error::invalid(place, what));
    };
    let mut planes = file.decode(&[index], file.window(Some(size))?)?;
    let plane = planes.pop().map(ChannelPlane::into_single).unwrap_or_default();
    if file.channels()[index].is_whole && plane.iter().any(|value| *value >= LARGEST_WHOLE) {
        let what = format!("channel '{channel}' has whole numbers above {LARGEST_WHOLE}; save it as float");
        return Err(Error::unsupported(place, what));
    }
    Ok(plane)
}

/// Pictures that measure the ranges that a manifest lacks, at least: a field may be at rest, or not there yet, in the first of them.
const MEASURED: usize = 8;

/// The channels of values of a recording. Where there are any, pictures are read that are spread over cameras and frames, which measures
/// the ranges that the manifest lacks.
///
/// # Errors
/// As [`listed`] and [`read`]; `Invalid` where a range is not given and no picture has a value.
pub(super) fn channels(recording: &CameraFiles, place: &str) -> Result<Vec<ValueChannel>> {
    let keys = recording.entries.iter().flatten().map(|entry| &entry.keys);
    let listed = listed(keys, place)?;
    if listed.is_empty() {
        return Ok(Vec::new());
    }
    let read = |(camera, entry): &ReadPicture| read(&entry.files, camera, &entry.place);
    let (spread, rest) = spread(recording);
    let mut measured: Vec<Values> = spread.par_iter().map(read).collect::<Result<_>>()?;
    let lacks_values = |measured: &[Values]| {
        let has = |index| measured.iter().any(|values| values.channel(index).any(f32::is_finite));
        listed.iter().enumerate().any(|(index, keys)| keys.range.is_none() && !has(index))
    };
    for picture in &rest {
        if !lacks_values(&measured) {
            break;
        }
        measured.push(read(picture)?);
    }
    listed.iter().enumerate().map(|(index, keys)| channel(keys, index, &measured, place)).collect()
}

/// A picture that is read, and its camera.
type ReadPicture<'a> = (&'a Camera, &'a PlacedEntry);

/// One picture of each camera and at least [`MEASURED`] where there are as many, spread over the frames, and all others.
fn spread(recording: &CameraFiles) -> (Vec<ReadPicture<'_>>, Vec<ReadPicture<'_>>) {
    let of_camera = |(camera, frames)| {
        let frames: &Vec<PlacedEntry> = frames;
        frames.iter().filter(|entry| !entry.is_left_out).map(move |entry| (camera, entry)).collect()
    };
    let mut pictures: Vec<Vec<ReadPicture<'_>>> =
        recording.cameras.iter().zip(&recording.entries).map(of_camera).collect();
    let cameras = pictures.len();
    let count = pictures.iter().map(Vec::len).sum::<usize>().min(MEASURED).max(cameras);
    let mut taken = vec![BTreeSet::new(); cameras];
    for nth in 0..count {
        let last = pictures[nth % cameras].len().saturating_sub(1);
        taken[nth % cameras].insert(nth * last / (count - 1).max(1));
    }
    let (mut spread, mut rest) = (Vec::new(), Vec::new());
    for (pictures, taken) in pictures.iter_mut().zip(&taken) {
        for (index, picture) in pictures.drain(..).enumerate() {
            if taken.contains(&index) { spread.push(picture) } else { rest.push(picture) }
        }
    }
    (spread, rest)
}

fn channel(keys: &ValueKeys, index: usize, pictures: &[Values], place: &str) -> Result<ValueChannel> {
    let ValueKeys { name, unit, range, tolerance, exact, .. } = keys;
    let measured = || {
        let values =
            pictures.iter().flat_map(|values| values.channel(index)).filter(|value| value.is_finite());
        let [low, high] = values
            .fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)]);
        let what = || {
            let what =
                format!("the value '{name}' is missing in all pictures; give its \"range\" in the manifest");
            Error::invalid(place, what)
        };
        if low <= high { Ok([low, high]) } else { Err(what()) }
    };
    let range = range.map_or_else(measured, Ok)?;
    let share = ((f64::from(range[1]) - f64::from(range[0])) * f64::from(DEFAULT_TOLERANCE)) as f32;
    let tolerance = tolerance.unwrap_or(share);
    let is_exact = exact.unwrap_or(true);
    Ok(ValueChannel { name: name.clone(), unit: unit.clone(), range, tolerance, is_exact })
}
