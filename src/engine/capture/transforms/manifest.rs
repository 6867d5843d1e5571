//! The keys of the manifest, as JSON has them.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Map, Value};

use super::depth_camera::DepthCameraKeys;
use super::lens::LensKeys;
use super::manifest_file::{other_file, plain, wrong_value};
use super::raw_video::RawVideoKeys;
use super::same_camera::camera_name;
use super::value_keys::ValueKeys;
use crate::capture::pictures::{Distortion, PictureRows};
use crate::capture::pose_convention::{CameraAxes, PoseConvention, PoseDirection};
use crate::error::{Error, Result, one_line};
use crate::whole_file;

/// Largest manifest that is read: some 100,000 entries.
const MAX_BYTES: u64 = 256 << 20;

/// Keys of the whole file or of one entry; an entry's wins.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Keys {
    /// Name of the camera.
    #[serde(deserialize_with = "camera_name")]
    pub camera: Option<String>,
    /// Number of the frame, without `frame`. Fractions (nerfstudio's 0 to 1) are ranked in a capture, and refused in views.
    pub time: Option<f64>,
    /// The same by its other name; always a number of a frame, also where the times of a capture are fractions.
    pub frame: Option<f64>,
    /// Horizontal focal length, pixels.
    pub fl_x: Option<f64>,
    /// Vertical focal length, pixels; where missing, as `fl_x` but for pixels that are not square by the picture's header.
    pub fl_y: Option<f64>,
    /// Principal point, pixels from the left edge; the middle where missing.
    pub cx: Option<f64>,
    /// Principal point, pixels from the top edge; the middle where missing.
    pub cy: Option<f64>,
    /// Columns; from the picture where missing.
    pub w: Option<f64>,
    /// Rows; from the picture where missing.
    pub h: Option<f64>,
    /// Horizontal angle of view, radians, in place of `fl_x`.
    pub camera_angle_x: Option<f64>,
    /// Vertical angle of view, radians, in place of `fl_y`.
    pub camera_angle_y: Option<f64>,
    /// Horizontal angle of view, degrees, instant-ngp's way; in place of `fl_x` and `camera_angle_x`.
    pub x_fov: Option<f64>,
    /// Vertical angle of view, degrees.
    pub y_fov: Option<f64>,
    /// `PINHOLE`, or a model that is one where its distortion is 0.
    pub camera_model: Option<String>,
    /// Further keys of the lens.
    #[serde(flatten)]
    pub lens: LensKeys,
    /// World units of the poses per unit of the scene they were made from.
    pub applied_scale: Option<f64>,
    /// See [`DepthKind`](crate::capture::exr::DepthKind).
    pub depth_kind: Option<String>,
    /// Full name of the depth channel.
    pub depth_channel: Option<String>,
    /// Layer of the normal channels.
    pub normal_channel: Option<String>,
    /// Layer that all channels belong to.
    pub layer: Option<String>,
    /// The depth that means "nothing hit".
    pub depth_miss_value: Option<f64>,
    /// World units per unit of the depth files; 0.001 for PNG and 1 for EXR where missing.
    pub depth_unit_scale_factor: Option<f64>,
    /// Another word for `integer_depth_scale`.
    pub depth_integer_scale: Option<f64>,
    /// Units of the depth files per world unit: the reciprocal of `depth_unit_scale_factor`.
    pub depth_scale: Option<f64>,
    /// The depth that means "not measured".
    pub depth_invalid_value: Option<f64>,
    /// The depth camera, where it has another lens or place than color's.
    pub depth_camera: Option<Box<DepthCameraKeys>>,
    /// instant-ngp's word for `depth_unit_scale_factor`.
    pub integer_depth_scale: Option<f64>,
    /// Distance of the near plane.
    pub near_clip: Option<f64>,
    /// Planar z from which on nothing was hit.
    pub far_clip: Option<f64>,
    /// `world`, `camera`, or null where normals are not to be read.
    #[serde(deserialize_with = "present")]
    pub normal_space: Option<NormalSpaceName>,
    /// Whether color is filtered across silhouettes.
    pub antialiased_color: Option<bool>,
    /// Whether color and depth have no noise: what differs over time moves then, however small it is.
    pub noise_free: Option<bool>,
    /// Pixel centers in the units of `cx`: 0.5 (our convention), or 0.
    pub pixel_center_offset: Option<f64>,
    /// Whether what is transparent is no sample; it is none where missing.
    pub use_alpha: Option<bool>,
    /// What colors mean; anything with `linear` in it is taken as it is, `srgb` is decoded.
    pub color_space: Option<String>,
    /// By how many stops colors are brightened as they are read; 0 where missing.
    pub exposure: Option<f64>,
    /// Which rows of pictures that a tag turns are meant.
    pub picture_orientation: Option<PictureRows>,
    /// Up in world space.
    pub up: Option<[f64; 3]>,
    /// How pictures in raw video are read.
    #[serde(flatten)]
    pub raw_video: RawVideoKeys,
    /// Which way `transform_matrix` maps; camera to world where missing.
    pub transform_direction: Option<PoseDirection>,
    /// Where the axes of the poses' camera space point; OpenGL's where missing.
    pub camera_axes: Option<CameraAxes>,
    /// Channels of scalar values.
    pub values: Option<Vec<ValueKeys>>,
}

/// The keys of `own`, and where one is missing that of `file`.
macro_rules! own_or_file {
    ($own:expr, $file:expr; $($key:ident),+) => {
        Self { $($key: $own.$key.or($file.$key)),+ }
    };
}

impl Keys {
    /// What `transform_matrix` means.
    pub(super) fn pose_convention(&self) -> PoseConvention {
        let nerfstudio = PoseConvention::default();
        PoseConvention {
            direction: self.transform_direction.unwrap_or(nerfstudio.direction),
            axes: self.camera_axes.unwrap_or(nerfstudio.axes),
        }
    }

    fn name_unit_of_depth(&mut self) {
        let whole = self.integer_depth_scale.take().or(self.depth_integer_scale.take());
        let divisor = self.depth_scale.take().map(|scale| 1.0 / scale);
        self.depth_unit_scale_factor = self.depth_unit_scale_factor.or(whole).or(divisor);
    }

    /// What the lens does to the picture; `None` where it is a pinhole.
    ///
    /// # Errors
    /// `Unsupported` for a lens that is not undone.
    pub(crate) fn distortion(&self, place: &str) -> Result<Option<Distortion>> {
        self.lens.distortion(self.camera_model.as_deref(), place)
    }

    /// These keys, and the file's for those that are missing. Some things have several keys (the lens focal lengths and angles, the
    /// frame a number and a time): if one of these is here, none of the file's counts.
    pub(crate) fn or(mut self, file: &Self) -> Self {
        let mut file = file.clone();
        let own = [self.fl_x, self.fl_y, self.camera_angle_x, self.camera_angle_y, self.x_fov, self.y_fov];
        if own.iter().any(Option::is_some) {
            (file.x_fov, file.y_fov) = (None, None);
            (file.fl_x, file.fl_y, file.camera_angle_x, file.camera_angle_y) = (None, None, None, None);
        }
        if self.frame.or(self.time).is_some() {
            (file.frame, file.time) = (None, None);
        }
        self.name_unit_of_depth();
        file.name_unit_of_depth();
        let both = own_or_file!(self, file;
            camera, time, frame, fl_x, fl_y, cx, cy, w, h, camera_angle_x, camera_angle_y, x_fov, y_fov, camera_model, lens,
            applied_scale, depth_kind, depth_channel, normal_channel, layer, depth_miss_value,
            depth_unit_scale_factor, integer_depth_scale, depth_integer_scale, depth_scale, depth_invalid_value,
            depth_camera, near_clip, far_clip, normal_space, antialiased_color, noise_free, pixel_center_offset, use_alpha, color_space, exposure, up,
            picture_orientation, raw_video, transform_direction, camera_axes, values);
        Self { time: both.time.filter(|_| both.frame.is_none()), ..both }
    }
}

/// One picture of one camera.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct PictureEntry {
    /// The picture, relative to the manifest.
    pub file_path: String,
    /// The depth, where it is in a file of its own.
    #[serde(default)]
    pub depth_file_path: Option<String>,
    /// instant-ngp's word for `depth_file_path`, which it is read as.
    #[serde(default)]
    pub depth_path: Option<String>,
    /// The normals, where they are in a file of their own.
    #[serde(default)]
    pub normal_file_path: Option<String>,
    /// How sure the sensor is of each pixel of depth: 0, 1, 2 or 0, 127, 255.
    #[serde(default)]
    pub confidence_file_path: Option<String>,
    /// A picture; where its pixels are 0, the frame's are left out.
    #[serde(default)]
    pub mask_path: Option<String>,
    /// Files of scalar values, by the names of their channels.
    #[serde(default)]
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub value_file_paths: BTreeMap<String, String>,
    /// Whether a camera path has a key here.
    #[serde(default)]
    pub path_key: bool,
    /// When the camera of a path is here, in seconds of the film.
    #[serde(default)]
    pub path_time: Option<f64>,
    /// How the camera of a path goes on from here.
    #[serde(default)]
    pub path_easing: Option<String>,
    /// Camera to world, row-major, OpenGL axes; 4 rows or 3.
    #[serde(deserialize_with = "rows")]
    pub transform_matrix: Vec<Vec<f64>>,
    /// Keys of this entry alone.
    #[serde(flatten)]
    pub keys: Keys,
}

impl PictureEntry {
    /// The files that it names.
    pub(crate) fn paths(&self) -> impl Iterator<Item = &String> {
        let sensed = [&self.depth_file_path, &self.depth_path, &self.confidence_file_path];
        let more = sensed.into_iter().chain([&self.normal_file_path, &self.mask_path]);
        std::iter::once(&self.file_path).chain(more.flatten()).chain(self.value_file_paths.values())
    }

    /// The files that it names, to be changed.
    pub(crate) fn paths_mut(&mut self) -> impl Iterator<Item = &mut String> {
        let sensed = [&mut self.depth_file_path, &mut self.depth_path, &mut self.confidence_file_path];
        let more = sensed.into_iter().chain([&mut self.normal_file_path, &mut self.mask_path]);
        std::iter::once(&mut self.file_path).chain(more.flatten()).chain(self.value_file_paths.values_mut())
    }
}

/// A whole manifest. Keys it does not know are passed over, as nerfstudio writes many.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Manifest {
    /// Keys of all entries.
    #[serde(flatten)]
    pub keys: Keys,
    /// The pictures.
    pub frames: Vec<PictureEntry>,
    /// How the camera of a path sets off and arrives over the whole of it.
    #[serde(default)]
    pub path_easing: Option<String>,
}

impl Manifest {
    /// Reads a manifest.
    ///
    /// # Errors
    /// `Io` where it cannot be read, `Invalid` where it is missing, for broken JSON, a missing key, or no entries.
    pub(crate) fn read(path: &Path) -> Result<Self> {
        Self::from_json(&Self::bytes(path)?, &path.display().to_string())
    }

    /// The bytes of a manifest, unless the file cannot be one.
    pub(super) fn bytes(path: &Path) -> Result<Vec<u8>> {
        if !path.exists() {
            return Err(Error::invalid(
                path.display(),
                "there is no such file; a capture is a folder that holds a transforms.json",
            ));
        }
        if let Some(what) = other_file(path)? {
            return Err(Error::invalid(path.display(), what));
        }
        let length = std::fs::metadata(path).map_err(|error| Error::io(path, error))?.len();
        if length > MAX_BYTES {
            let what = format!("{length} bytes are too many for a manifest");
            return Err(Error::invalid(path.display(), what));
        }
        whole_file::read_all(path)
    }

    /// The manifest as JSON that [`Manifest::from_json`] reads.
    ///
    /// # Errors
    /// `Invalid` for numbers that JSON cannot hold.
    pub(crate) fn to_json(&self, place: &str) -> Result<Vec<u8>> {
        serde_json::to_vec_pretty(self).map_err(|error| Error::invalid(place, error.to_string()))
    }

    /// Reads a manifest from JSON; `place` is named in errors.
    pub(crate) fn from_json(bytes: &[u8], place: &str) -> Result<Self> {
        let bytes = &plain(bytes);
        let mut manifest: Self = serde_json::from_slice(bytes).map_err(|error| {
            let what = wrong_value::<PictureEntry, Keys>(bytes).unwrap_or_else(|| error.to_string());
            let what = one_line(&what);
            let what = if error.is_data() {
                format!("{what}; correct the manifest, whose keys are those of nerfstudio's transforms.json")
            } else {
                format!("it holds no JSON ({what}); choose a manifest, such as nerfstudio's transforms.json")
            };
            Error::invalid(place, what)
        })?;
        for entry in &mut manifest.frames {
            entry.depth_file_path = entry.depth_file_path.take().or(entry.depth_path.take());
        }
        if manifest.frames.is_empty() {
            return Err(Error::invalid(
                place,
                "\"frames\" is empty; list one entry for every picture of every camera",
            ));
        }
        Ok(manifest)
    }
}

/// The value of `normal_space`. Null is not the same as a missing key: the file's value counts for a missing one.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub(crate) enum NormalSpaceName {
    /// A name, `world` or `camera`.
    Text(String),
    /// No normals are to be read.
    Null,
}

pub(super) fn present<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<NormalSpaceName>, D::Error> {
    NormalSpaceName::deserialize(deserializer).map(Some)
}

/// A number of a pose. What is none (null, or the words that stand for Python's NaN and Infinity) is NaN: such a pose is left out, and the
/// other pictures stay.
#[derive(Deserialize)]
#[serde(untagged, expecting = "it must hold numbers; export the camera again")]
enum PoseNumber {
    Number(f64),
    Word(NoNumber),
    Null(()),
}

#[derive(Deserialize)]
enum NoNumber {
    NaN,
    Infinity,
    #[serde(rename = "-Infinity")]
    MinusInfinity,
}

impl PoseNumber {
    fn value(&self) -> f64 {
        match self {
            Self::Number(value) => *value,
            Self::Word(NoNumber::NaN | NoNumber::Infinity | NoNumber::MinusInfinity) | Self::Null(()) => {
                f64::NAN
            }
        }
    }
}

/// Rows as they are; of a list of 12 or 16 numbers the rows one after the other, four numbers each; none where there is no matrix.
pub(super) fn rows<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Vec<f64>>, D::Error> {
    let value = Value::deserialize(deserializer)?;
    let named = |error: serde_json::Error| serde::de::Error::custom(format!("\"transform_matrix\": {error}"));
    let numbers = |values: Vec<PoseNumber>| values.iter().map(PoseNumber::value).collect::<Vec<f64>>();
    if value.is_null() {
        return Ok(Vec::new());
    }
    let is_flat = value.as_array().and_then(|list| list.first()).is_some_and(|first| !first.is_array());
    if !is_flat {
        let rows = Vec::<Vec<PoseNumber>>::deserialize(value).map_err(named)?;
        return Ok(rows.into_iter().map(numbers).collect());
    }
    let numbers = numbers(Vec::deserialize(value).map_err(named)?);
    if !matches!(numbers.len(), 12 | 16) {
        let what =
            "\"transform_matrix\": it must have 4 rows of 4 numbers, or all 16 in one list, row by row";
        return Err(serde::de::Error::custom(what));
    }
    Ok(numbers.chunks(4).map(<[f64]>::to_vec).collect())
}

impl Manifest {
    /// Lets keys, with their values as JSON, count in place of the manifest's own, for every picture.
    ///
    /// # Errors
    /// `Invalid` for a value that its key cannot have.
    pub(crate) fn with_keys(mut self, keys: &[(String, String)]) -> Result<Self> {
        let wrong = |error: serde_json::Error| Error::invalid("keys", one_line(&error.to_string()));
        let value = |(key, value): &(String, String)| Ok((key.clone(), serde_json::from_str(value)?));
        let values: Map<String, Value> =
            keys.iter().map(value).collect::<Result<_, serde_json::Error>>().map_err(wrong)?;
        let own: Keys = serde_json::from_value(Value::Object(values)).map_err(wrong)?;
        for entry in &mut self.frames {
            entry.keys = own.clone().or(&entry.keys);
        }
        self.keys = own.or(&self.keys);
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_entry_s_own_angle_counts_and_not_the_file_s_focal_length() {
        let file = Keys { fl_x: Some(1000.0), fl_y: Some(900.0), w: Some(640.0), ..Keys::default() };
        let entry = Keys { camera_angle_x: Some(0.5), ..Keys::default() };
        let both = entry.or(&file);
        assert_eq!((both.fl_x, both.fl_y, both.camera_angle_x, both.w), (None, None, Some(0.5), Some(640.0)));
        assert_eq!(Keys::default().or(&file).fl_y, Some(900.0));
    }

    const ENTRY: &str = r#"{"file_path": "a.exr", "transform_matrix": [], "w": 5, "normal_space": null}"#;

    fn parse(text: &str) -> Result<Manifest> {
        Manifest::from_json(text.as_bytes(), "transforms.json")
    }

    #[test]
    fn an_entrys_key_wins_over_the_files_even_when_it_is_null() {
        let text =
            format!(r#"{{"w": 3, "h": 4, "normal_space": "world", "aabb_scale": 2, "frames": [{ENTRY}]}}"#);
        let manifest = parse(&text).unwrap();
        let keys = manifest.frames[0].keys.clone().or(&manifest.keys);
        assert_eq!((keys.w, keys.h), (Some(5.0), Some(4.0)));
        assert_eq!(keys.normal_space, Some(NormalSpaceName::Null));
        assert_eq!(manifest.keys.normal_space, Some(NormalSpaceName::Text("world".into())));
    }

    #[test]
    fn broken_manifests_give_one_line_that_names_the_file() {
        let texts = [
            "",
            "{",
            "[]",
            "{}",
            r#"{"frames": []}"#,
            r#"{"frames": [{"file_path": "a.exr"}]}"#,
            r#"{"fl_x": "wide", "frames": []}"#,
            r#"{"w": 1e999, "frames": []}"#,
        ];
        for text in texts {
            let error = parse(text).unwrap_err().to_string();
            assert!(error.starts_with("transforms.json: ") && !error.contains('\n'), "{error}");
        }
    }

    #[test]
    fn keys_count_in_place_of_the_file_s_and_of_every_picture_s_own() {
        let text = r#"{"integer_depth_scale": 0.5, "fl_x": 9, "frames":
            [{"file_path": "a", "transform_matrix": [], "depth_kind": "planar_z", "w": 3}]}"#;
        let manifest = Manifest::from_json(text.as_bytes(), "a").unwrap();
        let key = |key: &str, value: &str| (key.to_owned(), value.to_owned());
        let keys = [key("depth_kind", "\"ray_distance\""), key("depth_unit_scale_factor", "0.001")];
        let read = manifest.clone().with_keys(&keys).unwrap();
        let entry = read.frames[0].keys.clone().or(&read.keys);
        assert_eq!(entry.depth_kind.as_deref(), Some("ray_distance"));
        assert_eq!((entry.depth_unit_scale_factor, entry.fl_x, entry.w), (Some(0.001), Some(9.0), Some(3.0)));
        let error = manifest.with_keys(&[key("camera_axes", "7")]).unwrap_err().to_string();
        assert!(error.starts_with("keys: ") && !error.contains('\n'), "{error}");
    }
}
