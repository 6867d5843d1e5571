//! Keys of a manifest that describe a lens other than a pinhole, by the names that several programs give them: lenses that are
//! undone while reading, lenses whose lines of sight are parallel, and lenses that are refused.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::capture::camera::Projection;
use crate::capture::pictures::Distortion;
use crate::error::{Error, Result};

/// Coefficients of lenses that are undone.
const COEFFICIENTS: [&str; 9] = ["k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2", "omega"];

/// nerfstudio's list of coefficients: `k1 k2 k3 k4 p1 p2`.
const LIST: &str = "distortion_params";

/// Whether the lens is a fisheye, instant-ngp's way.
const FISHEYE: &str = "is_fisheye";

/// Other keys of lenses that are no pinholes, and are not undone.
const OTHER_LENSES: [&str; 9] = [
    "p3",
    "p4",
    "ftheta_p0",
    "ftheta_p1",
    "ftheta_p2",
    "ftheta_p3",
    "ftheta_p4",
    "latlong",
    "equirectangular",
];

/// Whether lines of sight are parallel, a word or a number.
const ORTHOGRAPHIC: &str = "orthographic";

/// Blender's width of an orthographic picture, along its longer side, world units.
const ORTHO_SCALE: &str = "ortho_scale";

/// Blender's word for perspective, orthographic and panoramic cameras.
const CAMERA_TYPE: &str = "camera_type";

/// Parts of the names of camera types that are no pinholes.
const NO_PINHOLES: [&str; 4] = ["fisheye", "pano", "equirect", "spher"];

/// The keys of lenses that are given.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "Map<String, Value>")]
pub(crate) struct LensKeys(Map<String, Value>);

impl From<Map<String, Value>> for LensKeys {
    /// Leaves out all other keys, and those whose value is null.
    fn from(mut keys: Map<String, Value>) -> Self {
        let is_known = |key: &str| {
            COEFFICIENTS.contains(&key)
                || OTHER_LENSES.contains(&key)
                || [CAMERA_TYPE, LIST, FISHEYE, ORTHOGRAPHIC, ORTHO_SCALE].contains(&key)
        };
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

    /// Coefficients by name.
    pub(crate) fn of(coefficients: &[(&str, f64)]) -> Self {
        Self(coefficients.iter().map(|(name, value)| ((*name).to_owned(), Value::from(*value))).collect())
    }

    fn number(&self, key: &str) -> f64 {
        self.0.get(key).and_then(Value::as_f64).unwrap_or(0.0)
    }

    /// How points come into the picture, by the model, Blender's type or a key of its own.
    pub(super) fn projection(&self, model: Option<&str>) -> Projection {
        let camera_type = self.0.get(CAMERA_TYPE).and_then(Value::as_str);
        let says_so =
            |word: Option<&str>| word.is_some_and(|word| word.to_ascii_lowercase().starts_with("ortho"));
        let is_so =
            says_so(model) || says_so(camera_type) || self.0.get(ORTHOGRAPHIC).is_some_and(is_anything);
        if is_so { Projection::Orthographic } else { Projection::Perspective }
    }

    /// World units along the longer side of an orthographic picture, where they are given.
    pub(super) fn ortho_scale(&self) -> Option<f64> {
        self.0.get(ORTHO_SCALE).map(|value| value.as_f64().unwrap_or(f64::NAN))
    }

    /// What the lens does to the picture; `None` where it is a pinhole, or orthographic.
    ///
    /// # Errors
    /// `Unsupported` for a lens that is not undone.
    pub(crate) fn distortion(&self, model: Option<&str>, place: &str) -> Result<Option<Distortion>> {
        let model = model.unwrap_or("PINHOLE").to_ascii_uppercase();
        let refuse = |what: &str| {
            let what = format!(
                "{what} is not undone (known: radial and tangential, OPENCV_FISHEYE, FOV); undistort the pictures first"
            );
            Err(Error::unsupported(place, what))
        };
        if let Some(key) = self.0.keys().find(|key| self.speaks_of_another_lens(key)) {
            return refuse(&format!("a lens with '{key}'"));
        }
        if self.projection(Some(&model)) == Projection::Orthographic {
            let bent = self.0.iter().find(|(key, value)| {
                (COEFFICIENTS.contains(&key.as_str()) || [LIST, FISHEYE].contains(&key.as_str()))
                    && is_anything(value)
            });
            return bent.map_or(Ok(None), |(key, _)| refuse(&format!("an orthographic camera with '{key}'")));
        }
        let list: Vec<f64> = match self.0.get(LIST).and_then(Value::as_array) {
            Some(values) => values.iter().map(|value| value.as_f64().unwrap_or(0.0)).collect(),
            None => Vec::new(),
        };
        let listed = |index: usize| list.get(index).copied().unwrap_or(0.0);
        let k = |number: usize| match self.number(COEFFICIENTS[number - 1]) {
            0.0 if number <= 4 => listed(number - 1),
            given => given,
        };
        let p = [("p1", 4), ("p2", 5)].map(|(name, index)| match self.number(name) {
            0.0 => listed(index),
            given => given,
        });
        let is_fisheye = FISHEYES.contains(&model.as_str()) || self.0.get(FISHEYE).is_some_and(is_anything);
        if is_fisheye {
            return Ok(Some(Distortion::fisheye([k(1), k(2), k(3), k(4)])));
        }
        if model == "FOV" {
            return Ok(Distortion::field_of_view(self.number("omega")));
        }
        if !RADIAL_MODELS.contains(&model.as_str()) {
            return refuse(&format!("camera_model '{model}'"));
        }
        if model != "FULL_OPENCV" && (4..=6).any(|number| k(number) != 0.0) {
            return refuse("a lens with k4, k5 or k6, which belong to camera_model 'FULL_OPENCV',");
        }
        Ok(Distortion::radial_tangential([k(1), k(2), k(3), k(4), k(5), k(6)], p))
    }

    fn speaks_of_another_lens(&self, key: &str) -> bool {
        let value = &self.0[key];
        if key == CAMERA_TYPE {
            let camera_type = value.as_str().unwrap_or_default().to_ascii_lowercase();
            return NO_PINHOLES.iter().any(|other| camera_type.contains(other));
        }
        OTHER_LENSES.contains(&key) && is_anything(value)
    }
}

/// Models of lenses without distortion, or with radial and tangential distortion.
const RADIAL_MODELS: [&str; 7] =
    ["PINHOLE", "SIMPLE_PINHOLE", "OPENCV", "PERSPECTIVE", "SIMPLE_RADIAL", "RADIAL", "FULL_OPENCV"];

/// Models whose image position is proportional to the angle from the axis, but for distortion.
const FISHEYES: [&str; 5] =
    ["OPENCV_FISHEYE", "SIMPLE_RADIAL_FISHEYE", "RADIAL_FISHEYE", "SIMPLE_FISHEYE", "FISHEYE"];

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
