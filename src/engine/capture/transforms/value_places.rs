//! Which channels of scalar values a manifest lists, and in which files they are.

use std::path::PathBuf;

use super::manifest::{Keys, PictureEntry};
use super::value_keys::ValueKeys;
use crate::capture::values::MAX_VALUE_CHANNELS;
use crate::error::{Error, Result};
use crate::plural::counted;

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
