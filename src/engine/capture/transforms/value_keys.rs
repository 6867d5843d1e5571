//! The manifest's keys of scalar values: which channels there are, and in which files.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::manifest::{Keys, PictureEntry};
use crate::capture::exr::value_channel;
use crate::capture::values::{MAX_VALUE_CHANNELS, ValueChannel};
use crate::error::{Error, Result};
use crate::plural::counted;

/// One channel of values, as the manifest has it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct ValueKeys {
    /// Unlike those of the other channels.
    pub name: String,
    /// For people.
    #[serde(default)]
    #[serde(skip_serializing_if = "String::is_empty")]
    pub unit: String,
    /// Smallest and largest value; measured on the first pictures where missing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range: Option<[f32; 2]>,
    /// How far apart values may be to count as the same; a share of the range where missing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f32>,
    /// Whether stores keep the values bit for bit, as they do where missing, or within half the tolerance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exact: Option<bool>,
    /// Full name of the channel in OpenEXR; the name where missing.
    #[serde(skip_serializing_if = "Option::is_none")]
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
