//! The name of a camera, as JSON has it.

use serde::Deserialize;

/// Reads a camera's name; some writers number their cameras.
pub(super) fn camera_name<'de, D: serde::Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<String>, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum CameraName {
        Text(String),
        Number(i64),
    }
    Ok(Option::<CameraName>::deserialize(deserializer)?.map(|name| match name {
        CameraName::Text(text) => text,
        CameraName::Number(number) => number.to_string(),
    }))
}
