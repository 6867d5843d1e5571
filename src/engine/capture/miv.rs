//! MPEG immersive video: sequences as TMIV and RVS read them, a JSON file of cameras beside raw video of texture and depth.
//!
//! Source: TMIV's `SequenceConfig` and `ViewParamsList`, RVS's `Parameters`. World and camera have x forward, y left, z up; poses are
//! camera to world, turned by yaw about z, pitch about y and roll about x: `R = Rz(yaw) · Ry(pitch) · Rx(roll)`. Pixel centers lie at
//! +0.5. Depth is planar (x) for perspective cameras: `1/z = 1/far + level/largest · (1/near − 1/far)`.

use glam::{DAffine3, DMat3, DVec3};
use serde::Deserialize;
use serde_json::Value;

use crate::capture::camera::{Intrinsics, Projection};
use crate::error::{Error, Result};

/// The keys of a sequence that decide what its pictures mean; others are passed over.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct SequenceFile {
    #[serde(rename = "Content_name")]
    pub content_name: String,
    /// Added to every position: programs that read single precision keep the shape of a scene that stands far from the origin.
    #[serde(rename = "Overlook_world_offset")]
    pub world_offset: Option<[f64; 3]>,
    #[serde(rename = "Frames_number")]
    pub frames_number: u64,
    #[serde(rename = "sourceCameraNames")]
    pub source_camera_names: Option<Vec<String>>,
    #[serde(rename = "frameRanges")]
    pub frame_ranges: Vec<FrameRange>,
    pub cameras: Vec<SequenceCamera>,
}

/// Frames of the raw video that belong to the sequence.
#[derive(Clone, Copy, Debug, Deserialize)]
pub(crate) struct FrameRange {
    #[serde(rename = "maxNumberOfFrames")]
    pub max_number_of_frames: u64,
    #[serde(rename = "startFrame")]
    pub start_frame: u64,
}

/// One camera of a sequence.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct SequenceCamera {
    #[serde(rename = "Name")]
    pub name: String,
    #[serde(rename = "Position")]
    pub position: [f64; 3],
    /// Yaw, pitch and roll, degrees.
    #[serde(rename = "Rotation")]
    pub rotation: [f64; 3],
    #[serde(rename = "Resolution")]
    pub resolution: [u32; 2],
    #[serde(rename = "Projection")]
    pub projection: String,
    #[serde(rename = "Focal")]
    pub focal: Option<[f64; 2]>,
    #[serde(rename = "Principle_point")]
    pub principle_point: Option<[f64; 2]>,
    /// Near and far; far may be the text `inf`.
    #[serde(rename = "Depth_range")]
    pub depth_range: Vec<Value>,
    #[serde(rename = "BitDepthColor")]
    pub bit_depth_color: u32,
    #[serde(rename = "BitDepthDepth")]
    pub bit_depth_depth: u32,
    #[serde(rename = "ColorSpace")]
    pub color_space: String,
    #[serde(rename = "DepthColorSpace")]
    pub depth_color_space: String,
    /// RVS takes true where it is missing, TMIV false.
    #[serde(rename = "HasInvalidDepth")]
    pub has_invalid_depth: Option<bool>,
}

/// RVS takes a far plane from here on for infinity.
const INFINITE_FROM: f64 = 1000.0;

impl SequenceCamera {
    /// Near and far plane, far infinite where it is.
    ///
    /// # Errors
    /// `Invalid` where they are no range.
    pub(crate) fn near_and_far(&self, place: &str) -> Result<(f64, f64)> {
        let number = |value: &Value| match value {
            Value::String(text) if text.trim().trim_start_matches('+').eq_ignore_ascii_case("inf") => {
                Some(f64::INFINITY)
            }
            other => other.as_f64(),
        };
        let range: Option<Vec<f64>> = self.depth_range.iter().map(number).collect();
        match range.as_deref() {
            Some([near, far]) if *near > 0.0 && near < far => {
                Ok((*near, if *far >= INFINITE_FROM { f64::INFINITY } else { *far }))
            }
            _ => {
                let what = format!(
                    "Depth_range of camera '{}' is {}; it is [near, far], with 0 < near < far",
                    self.name,
                    Value::Array(self.depth_range.clone())
                );
                Err(Error::invalid(place, what))
            }
        }
    }
}

/// World from our camera space. `offset` is that of the sequence.
///
/// # Errors
/// `Invalid` for numbers that are not finite.
pub(crate) fn pose(camera: &SequenceCamera, offset: Option<[f64; 3]>, place: &str) -> Result<DAffine3> {
    let [yaw, pitch, roll] = camera.rotation.map(f64::to_radians);
    let eye = DVec3::from(camera.position) + DVec3::from(offset.unwrap_or_default());
    if !(yaw.is_finite() && pitch.is_finite() && roll.is_finite() && eye.is_finite()) {
        let what =
            format!("Position or Rotation of camera '{}' holds a number that is not finite", camera.name);
        return Err(Error::invalid(place, what));
    }
    let turned = DMat3::from_rotation_z(yaw) * DMat3::from_rotation_y(pitch) * DMat3::from_rotation_x(roll);
    // In the camera space of a sequence x is forward, y left and z up.
    let sequence_from_camera = DMat3::from_cols(DVec3::NEG_Y, DVec3::NEG_Z, DVec3::X);
    Ok(DAffine3::from_mat3_translation(turned * sequence_from_camera, eye))
}

/// Size and lens of a perspective camera.
///
/// # Errors
/// `Unsupported` for another projection, `Invalid` where its numbers are missing.
pub(crate) fn projection(camera: &SequenceCamera, place: &str) -> Result<Intrinsics> {
    let name = &camera.name;
    if camera.projection != "Perspective" {
        let what = format!(
            "camera '{name}' is '{}'; perspective cameras are read: render views of it as such, with RVS or TMIV",
            camera.projection
        );
        return Err(Error::unsupported(place, what));
    }
    let (Some([fx, fy]), Some([cx, cy])) = (camera.focal, camera.principle_point) else {
        let what = format!("camera '{name}' has no Focal or no Principle_point");
        return Err(Error::invalid(place, what));
    };
    let [width, height] = camera.resolution;
    Ok(Intrinsics { width, height, fx, fy, cx, cy, projection: Projection::Perspective })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_camera_looks_along_x_with_z_up() {
        let at_rest = pose(&SequenceCamera::default(), None, "").unwrap();
        assert!(at_rest.transform_vector3(DVec3::Z).abs_diff_eq(DVec3::X, 1e-12));
        assert!(at_rest.transform_vector3(DVec3::X).abs_diff_eq(DVec3::NEG_Y, 1e-12));
        assert!(at_rest.transform_vector3(DVec3::Y).abs_diff_eq(DVec3::NEG_Z, 1e-12));
    }

    #[test]
    fn far_planes_may_be_infinite_and_ranges_have_to_be_ranges() {
        let range = |json: &str| {
            let depth_range = serde_json::from_str(json).unwrap();
            SequenceCamera { depth_range, ..SequenceCamera::default() }.near_and_far("a.json")
        };
        assert_eq!(range("[0.3, 1.62]").unwrap(), (0.3, 1.62));
        assert_eq!(range("[0.3, \"inf\"]").unwrap(), (0.3, f64::INFINITY));
        assert_eq!(range("[0.3, 1000]").unwrap(), (0.3, f64::INFINITY));
        for bad in ["[]", "[1]", "[2, 1]", "[0, 1]", "[\"a\", 1]", "[1, null]"] {
            let error = range(bad).unwrap_err().to_string();
            assert!(error.starts_with("a.json: Depth_range") && !error.contains('\n'), "{error}");
        }
    }
}
