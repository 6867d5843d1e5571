//! What a manifest says of a lens that is no pinhole, in whichever words its writer has.

use serde::Deserialize;
use serde_json::Value;

/// Keys of lenses. They are read so that a bent picture is refused, and never written.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub(super) struct LensKeys {
    /// Radial distortion.
    pub k1: Option<f64>,
    /// Radial distortion.
    pub k2: Option<f64>,
    /// Radial distortion.
    pub k3: Option<f64>,
    /// Radial distortion.
    pub k4: Option<f64>,
    /// Radial distortion of the rational models.
    pub k5: Option<f64>,
    /// Radial distortion of the rational models.
    pub k6: Option<f64>,
    /// Tangential distortion.
    pub p1: Option<f64>,
    /// Tangential distortion.
    pub p2: Option<f64>,
    /// Tangential distortion of the rational models.
    pub p3: Option<f64>,
    /// Tangential distortion of the rational models.
    pub p4: Option<f64>,
    /// All coefficients in one list, as nerfstudio has them.
    pub distortion_params: Option<Value>,
    /// instant-ngp's word for a fisheye.
    pub is_fisheye: Option<Value>,
    /// instant-ngp's word for a panorama.
    pub latlong: Option<Value>,
    /// instant-ngp's other word for a panorama.
    pub equirectangular: Option<Value>,
    /// instant-ngp's word for a camera without perspective.
    pub orthographic: Option<Value>,
    /// Coefficient of instant-ngp's f-theta lens.
    pub ftheta_p0: Option<Value>,
    /// Coefficient of instant-ngp's f-theta lens.
    pub ftheta_p1: Option<Value>,
    /// Coefficient of instant-ngp's f-theta lens.
    pub ftheta_p2: Option<Value>,
    /// Coefficient of instant-ngp's f-theta lens.
    pub ftheta_p3: Option<Value>,
    /// Coefficient of instant-ngp's f-theta lens.
    pub ftheta_p4: Option<Value>,
    /// Blender's word for perspective, orthographic and panoramic cameras.
    pub camera_type: Option<Value>,
}

/// Parts of the names of camera types that are none.
const NO_PINHOLES: [&str; 5] = ["ortho", "fisheye", "pano", "equirect", "spher"];

impl LensKeys {
    /// These keys, and where they are missing the file's.
    #[must_use]
    pub(super) fn or(self, file: Self) -> Self {
        Self {
            k1: self.k1.or(file.k1),
            k2: self.k2.or(file.k2),
            k3: self.k3.or(file.k3),
            k4: self.k4.or(file.k4),
            k5: self.k5.or(file.k5),
            k6: self.k6.or(file.k6),
            p1: self.p1.or(file.p1),
            p2: self.p2.or(file.p2),
            p3: self.p3.or(file.p3),
            p4: self.p4.or(file.p4),
            distortion_params: self.distortion_params.or(file.distortion_params),
            is_fisheye: self.is_fisheye.or(file.is_fisheye),
            latlong: self.latlong.or(file.latlong),
            equirectangular: self.equirectangular.or(file.equirectangular),
            orthographic: self.orthographic.or(file.orthographic),
            ftheta_p0: self.ftheta_p0.or(file.ftheta_p0),
            ftheta_p1: self.ftheta_p1.or(file.ftheta_p1),
            ftheta_p2: self.ftheta_p2.or(file.ftheta_p2),
            ftheta_p3: self.ftheta_p3.or(file.ftheta_p3),
            ftheta_p4: self.ftheta_p4.or(file.ftheta_p4),
            camera_type: self.camera_type.or(file.camera_type),
        }
    }

    /// Whether nothing of this speaks against a pinhole.
    #[must_use]
    pub(super) fn is_pinhole(&self) -> bool {
        let coefficients =
            [self.k1, self.k2, self.k3, self.k4, self.k5, self.k6, self.p1, self.p2, self.p3, self.p4];
        let is_bent = coefficients.into_iter().flatten().any(|coefficient| coefficient != 0.0);
        let says_so = |value: &Option<Value>| value.as_ref().is_some_and(is_anything);
        let camera_type = self.camera_type.as_ref().and_then(Value::as_str).unwrap_or_default();
        let camera_type = camera_type.to_ascii_lowercase();
        let is_other_type = NO_PINHOLES.iter().any(|other| camera_type.contains(other));
        let others = [
            &self.distortion_params,
            &self.is_fisheye,
            &self.latlong,
            &self.equirectangular,
            &self.orthographic,
            &self.ftheta_p0,
            &self.ftheta_p1,
            &self.ftheta_p2,
            &self.ftheta_p3,
            &self.ftheta_p4,
        ];
        !is_bent && !is_other_type && !others.into_iter().any(says_so)
    }
}

/// Texts that say no.
const NOS: [&str; 6] = ["", "0", "no", "off", "none", "false"];

/// Whether there is a number other than 0, a true, or a text that does not say no, somewhere in a value.
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
