//! The file of a manifest: its path, and files that are taken for one by mistake.

use std::borrow::Cow;
use std::io::Read;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::error::Result;
use crate::whole_file;

/// Name of the manifest in a capture's folder.
pub const MANIFEST_NAME: &str = "transforms.json";

/// The manifest of a capture or of views: itself, or the one in the folder.
#[must_use]
pub fn manifest_path(path: &Path) -> PathBuf {
    if path.is_dir() { path.join(MANIFEST_NAME) } else { path.to_path_buf() }
}

/// The manifest of truth vantages beside a capture (a folder, or its manifest); `None` if there is no such file.
#[must_use]
pub fn truth_beside(capture: &Path) -> Option<PathBuf> {
    let folder = if capture.is_dir() { capture } else { capture.parent()? };
    let views = folder.join("novel").join(MANIFEST_NAME);
    views.is_file().then_some(views)
}

/// The advice on a file that is a store or a picture by its first bytes.
pub(crate) fn other_file(path: &Path) -> Result<Option<&'static str>> {
    let mut start = [0; 4];
    let mut file = whole_file::open(path)?;
    if file.read_exact(&mut start).is_err() {
        return Ok(None);
    }
    Ok(match &start {
        b"FORM" => {
            Some("is a store; name the capture that it was made from: a folder, or its transforms.json")
        }
        b"\x76\x2F\x31\x01" | b"\x89PNG" | [0xFF, 0xD8, ..] => {
            Some("is a picture; name the capture that it is of: the folder that holds its transforms.json")
        }
        _ => None,
    })
}

/// The origin of a manifest.
#[derive(Clone, Debug)]
pub(crate) struct ManifestOrigin {
    /// The file that lists the pictures and their poses, for messages.
    pub path: PathBuf,
    /// The folder that the paths in it are relative to.
    pub folder: PathBuf,
}

impl ManifestOrigin {
    /// A manifest whose paths are relative to its own folder.
    pub(crate) fn of_file(path: &Path) -> Self {
        Self { path: path.to_path_buf(), folder: path.parent().unwrap_or(Path::new("")).to_path_buf() }
    }
}

/// UTF-8 without the mark that editors of Windows put before it, also of a text in UTF-16, which its shells write; and texts in place of
/// the numbers that JSON cannot hold (`NaN`, `Infinity`), which Python writes: a key that is never read may have them, and a message
/// about one that is read quotes them.
pub(super) fn plain(bytes: &[u8]) -> Cow<'_, [u8]> {
    let bytes = bytes.strip_prefix(&[0xEF, 0xBB, 0xBF]).unwrap_or(bytes);
    let text = match bytes {
        [0xFF, 0xFE, text @ ..] => Cow::Owned(from_utf16(text, u16::from_le_bytes)),
        [0xFE, 0xFF, text @ ..] => Cow::Owned(from_utf16(text, u16::from_be_bytes)),
        text => Cow::Borrowed(text),
    };
    match quoted_numbers(&text) {
        Some(quoted) => Cow::Owned(quoted),
        None => text,
    }
}

fn from_utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> Vec<u8> {
    let (pairs, _) = bytes.as_chunks::<2>();
    let units: Vec<u16> = pairs.iter().map(|pair| unit(*pair)).collect();
    String::from_utf16_lossy(&units).into_bytes()
}

/// What Python calls the numbers that JSON lacks.
const NO_NUMBERS: [&[u8]; 3] = [b"-Infinity", b"Infinity", b"NaN"];

/// The text with these words in quotes, but for those within texts; `None` where there are none.
fn quoted_numbers(text: &[u8]) -> Option<Vec<u8>> {
    let holds = |word: &[u8]| text.windows(word.len()).any(|part| part == word);
    if !NO_NUMBERS[1..].iter().any(|word| holds(word)) {
        return None;
    }
    let mut quoted = Vec::with_capacity(text.len() + 64);
    let (mut at, mut is_inside, mut is_escaped) = (0, false, false);
    while let Some(&byte) = text.get(at) {
        let word = NO_NUMBERS.iter().find(|word| !is_inside && text[at..].starts_with(word));
        if let Some(word) = word {
            quoted.push(b'"');
            quoted.extend_from_slice(word);
            quoted.push(b'"');
            at += word.len();
            continue;
        }
        is_inside ^= byte == b'"' && !is_escaped;
        is_escaped = is_inside && byte == b'\\' && !is_escaped;
        quoted.push(byte);
        at += 1;
    }
    Some(quoted)
}

/// Which value of a manifest, whose entries and keys are of these types, is of the wrong type, in words: serde alone names neither
/// entry nor key.
pub(super) fn wrong_value<Entry: DeserializeOwned, Keys: DeserializeOwned>(bytes: &[u8]) -> Option<String> {
    let manifest: Value = serde_json::from_slice(bytes).ok()?;
    let entries = manifest.get("frames").and_then(Value::as_array).into_iter().flatten().enumerate();
    let in_entry = |(index, entry): (usize, &Value)| {
        let error = serde_json::from_value::<Entry>(entry.clone()).err()?;
        let what = wrong_key::<Keys>(entry).unwrap_or_else(|| error.to_string());
        Some(format!("frames[{index}]: {what}"))
    };
    wrong_key::<Keys>(&manifest).or_else(|| entries.into_iter().find_map(in_entry))
}

/// The key whose value alone is refused, and why.
fn wrong_key<Keys: DeserializeOwned>(object: &Value) -> Option<String> {
    object.as_object()?.iter().find_map(|(key, value)| {
        let alone = Value::Object([(key.clone(), value.clone())].into_iter().collect());
        serde_json::from_value::<Keys>(alone).err().map(|error| format!("\"{key}\": {error}"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_of_windows_and_numbers_of_python_become_json() {
        let wide = |mark: [u8; 2], bytes: fn(u16) -> [u8; 2]| -> Vec<u8> {
            mark.into_iter().chain("{\"ä\": 1}".encode_utf16().flat_map(bytes)).collect()
        };
        assert_eq!(&*plain(&wide([0xFF, 0xFE], u16::to_le_bytes)), "{\"ä\": 1}".as_bytes());
        assert_eq!(&*plain(&wide([0xFE, 0xFF], u16::to_be_bytes)), "{\"ä\": 1}".as_bytes());
        assert_eq!(&*plain(b"\xEF\xBB\xBF{}"), b"{}");
        let python = br#"{"NaN \" NaN": [NaN, -Infinity, Infinity], "b": "Infinity\\"}"#;
        let json = br#"{"NaN \" NaN": ["NaN", "-Infinity", "Infinity"], "b": "Infinity\\"}"#;
        assert_eq!(&*plain(python), json);
    }
}
