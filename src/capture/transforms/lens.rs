//! Keys of a manifest that describe a lens other than a pinhole, by the names that several programs give them.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// Coefficients of radial and tangential distortion.
const COEFFICIENTS: [&str; 10] = ["k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2", "p3", "p4"];

/// nerfstudio's list of all coefficients, those of instant-ngp's f-theta lens, and its words for lenses that are no pinholes.
const OTHER_LENSES: [&str; 10] = [
    "distortion_params",
    "ftheta_p0",
    "ftheta_p1",
    "ftheta_p2",
    "ftheta_p3",
    "ftheta_p4",
    "is_fisheye",
    "latlong",
    "equirectangular",
    "orthographic",
];

/// Blender's word for perspective, orthographic and panoramic cameras.
const CAMERA_TYPE: &str = "camera_type";

/// Parts of the names of camera types that are no pinholes.
const NO_PINHOLES: [&str; 5] = ["ortho", "fisheye", "pano", "equirect", "spher"];

/// The keys of lenses that are given. They are read so that a bent picture is refused, and never written.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "Map<String, Value>")]
pub(crate) struct LensKeys(Map<String, Value>);

impl From<Map<String, Value>> for LensKeys {
    /// Leaves out all other keys, and those whose value is null.
    fn from(mut keys: Map<String, Value>) -> Self {
        let is_known =
            |key: &str| COEFFICIENTS.contains(&key) || OTHER_LENSES.contains(&key) || key == CAMERA_TYPE;
        keys.retain(|key, value| is_known(key.as_str()) && !value.is_null());
        Self(keys)
    }
}

impl LensKeys {
    /// These keys, and where they are missing the file's.
    pub(super) fn or(self, mut file: Self) -> Self {
        file.0.extend(self.0);
        file
    }

    /// Whether nothing of this speaks against a pinhole.
    pub(super) fn is_pinhole(&self) -> bool {
        let is_bent = |(key, value): (&String, &Value)| {
            if key != CAMERA_TYPE {
                return is_anything(value);
            }
            let camera_type = value.as_str().unwrap_or_default().to_ascii_lowercase();
            NO_PINHOLES.iter().any(|other| camera_type.contains(other))
        };
        !self.0.iter().any(is_bent)
    }
}

/// Texts that mean "no".
const NOS: [&str; 6] = ["", "0", "no", "off", "none", "false"];

/// Whether there is a number other than 0, a true, or a text other than a "no", somewhere in a value.
fn is_anything(value: &Value) -> bool {
    match value {
        Value::Bool(is_so) => *is_so,
        Value::Number(number) => number.as_f64() != Some(0.0),
        Value::Array(values) => values.iter().any(is_anything),
        Value::Object(values) => values.values().any(is_anything),
        Value::String(text) => !NOS.iter().any(|no| text.trim().eq_ignore_ascii_case(no)),
        Value::Null => false,
    }
}
