//! JSON as programs and editors really write it, made into JSON.

use std::borrow::Cow;

use serde::de::DeserializeOwned;
use serde_json::Value;

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
