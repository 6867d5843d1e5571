//! Scalar values: the manifest's keys, which channels are in which files, and reading them from `NumPy` arrays and channels of OpenEXR.

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::cameras::CameraFiles;
use super::files::PictureFiles;
use super::manifest::{Keys, PictureEntry};
use crate::capture::camera::{Camera, wrong_size};
use crate::capture::exr::{ChannelPlane, ExrFile, value_channel};
use crate::capture::pictures::{self, PictureFormat, format_of, parse_npy};
use crate::capture::values::{DEFAULT_TOLERANCE, MAX_VALUE_CHANNELS, MISSING_VALUE, ValueChannel, Values};
use crate::error::{Error, Result};
use crate::plural::counted;
use crate::whole_file;

/// One channel of values, as the manifest has it.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct ValueKeys {
    /// Unlike those of the other channels.
    pub name: String,
    /// For people.
    #[serde(default)]
    #[serde(skip_serializing_if = "String::is_empty")]
    pub unit: String,
    /// Smallest and largest value; measured on the first pictures where missing.
    pub range: Option<[f32; 2]>,
    /// How far apart values may be to count as the same; a share of the range where missing.
    pub tolerance: Option<f32>,
    /// Whether stores keep the values bit for bit, as they do where missing, or within half the tolerance.
    pub exact: Option<bool>,
    /// Full name of the channel in OpenEXR; the name where missing.
    pub channel: Option<String>,
}

impl ValueKeys {
    /// The keys of a channel in a capture that we write.
    pub(super) fn of_written(channel: &ValueChannel) -> Self {
        let ValueChannel { name, unit, range, tolerance, is_exact } = channel.clone();
        let channel = Some(value_channel(&name));
        let range = (range[0] < range[1]).then_some(range);
        let exact = (!is_exact).then_some(false);
        Self { name, unit, range, tolerance: Some(tolerance), exact, channel }
    }
}

/// Where the values of one channel are for one picture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ValueFile {
    /// Name of the channel of values.
    pub name: String,
    /// Its name in OpenEXR.
    pub channel: String,
    /// A file of its own; `None` where it is in the picture.
    pub path: Option<PathBuf>,
}

/// The files of an entry's values, whose paths `resolve` finds.
///
/// # Errors
/// `Invalid` for a file of a channel that is not listed.
pub(super) fn files(
    entry: &PictureEntry,
    keys: &Keys,
    place: &str,
    resolve: impl Fn(&str) -> PathBuf,
) -> Result<Vec<ValueFile>> {
    let listed = keys.values.as_deref().unwrap_or_default();
    let is_listed = |name: &&String| listed.iter().any(|channel| channel.name == **name);
    if let Some(name) = entry.value_file_paths.keys().find(|name| !is_listed(name)) {
        let names: Vec<&str> = listed.iter().map(|channel| channel.name.as_str()).collect();
        let what = format!(
            "value_file_paths has a file for '{name}', which is not listed; \"values\" has {}: list it there with its name",
            if names.is_empty() { "no channel".to_owned() } else { names.join(", ") }
        );
        return Err(Error::invalid(place, what));
    }
    let of_channel = |keys: &ValueKeys| ValueFile {
        name: keys.name.clone(),
        channel: keys.channel.clone().unwrap_or_else(|| keys.name.clone()),
        path: entry.value_file_paths.get(&keys.name).map(|path| resolve(path)),
    };
    Ok(listed.iter().map(of_channel).collect())
}

/// The channels that all entries list alike, as they list them.
///
/// # Errors
/// `Invalid` where they differ, and for channels that cannot be: one without a name or with that of another, more than four, a range
/// without width, a tolerance that is none.
pub(super) fn listed<'a>(mut keys: impl Iterator<Item = &'a Keys>, place: &str) -> Result<&'a [ValueKeys]> {
    let first = keys.next().and_then(|keys| keys.values.as_deref()).unwrap_or_default();
    if keys.any(|keys| keys.values.as_deref().unwrap_or_default() != first) {
        let what = "\"values\" differs between entries; write it once, beside \"frames\"";
        return Err(Error::invalid(place, what));
    }
    if first.len() > MAX_VALUE_CHANNELS {
        let what = format!(
            "\"values\" lists {}; at most {MAX_VALUE_CHANNELS} are kept: leave some out",
            counted(first.len(), "channel")
        );
        return Err(Error::invalid(place, what));
    }
    for (index, channel) in first.iter().enumerate() {
        if let Some(what) = fault(channel, &first[..index]) {
            return Err(Error::invalid(place, what));
        }
    }
    Ok(first)
}

/// What is wrong with a channel, given those before it.
fn fault(channel: &ValueKeys, before: &[ValueKeys]) -> Option<String> {
    let ValueKeys { name, unit, range, tolerance, .. } = channel;
    if name.is_empty() || name.contains(char::is_control) || unit.contains(char::is_control) {
        return Some(format!(
            "values[{}] has no name, or control characters in it; give it one",
            before.len()
        ));
    }
    if before.iter().any(|other| other.name == *name) {
        return Some(format!("two values are called '{name}'; give each a name of its own"));
    }
    if let Some([low, high]) = range
        && !(low.is_finite() && high.is_finite() && low < high)
    {
        return Some(format!(
            "the range of the value '{name}' is [{low}, {high}]; the first number must be below the second"
        ));
    }
    let tolerance = tolerance.filter(|tolerance| !(tolerance.is_finite() && *tolerance >= 0.0))?;
    Some(format!("the tolerance of the value '{name}' is {tolerance}; it must be 0 or above"))
}

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
                let what = "its type holds numbers that single precision does not; save it as float32";
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

/// The channels of values of a recording. The first picture of each camera is read where there are any, which measures the ranges that
/// the manifest lacks.
///
/// # Errors
/// As [`listed`] and [`read`]; `Invalid` where a range is not given and the first pictures have no value.
pub(super) fn channels(recording: &CameraFiles, place: &str) -> Result<Vec<ValueChannel>> {
    let keys = recording.entries.iter().flatten().map(|entry| &entry.keys);
    let listed = listed(keys, place)?;
    if listed.is_empty() {
        return Ok(Vec::new());
    }
    let firsts: Vec<_> = recording.cameras.iter().zip(recording.first_read()).collect();
    let read = |(camera, entry): &(&Camera, &crate::capture::transforms::source::PlacedEntry)| {
        read(&entry.files, camera, &entry.place)
    };
    let firsts: Vec<Values> = firsts.par_iter().map(read).collect::<Result<_>>()?;
    listed.iter().enumerate().map(|(index, keys)| channel(keys, index, &firsts, place)).collect()
}

fn channel(keys: &ValueKeys, index: usize, firsts: &[Values], place: &str) -> Result<ValueChannel> {
    let ValueKeys { name, unit, range, tolerance, exact, .. } = keys;
    let measured = || {
        let values = firsts.iter().flat_map(|values| values.channel(index)).filter(|value| value.is_finite());
        let [low, high] = values
            .fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)]);
        let what = || {
            let what = format!(
                "the value '{name}' is missing in all first pictures; give its \"range\" in the manifest"
            );
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
