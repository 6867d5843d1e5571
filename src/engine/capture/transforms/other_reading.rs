//! A manifest with some of its keys replaced.

use serde_json::{Map, Value};

use super::manifest::{Keys, Manifest};
use crate::error::{Error, Result, one_line};

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
