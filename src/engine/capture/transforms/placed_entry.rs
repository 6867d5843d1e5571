//! One entry of the manifest with its camera and frame decided.

use glam::DAffine3;

use super::files::PictureFiles;
use super::manifest::Keys;
use super::{header_probe, intrinsics};
use crate::capture::camera::Camera;
use crate::error::Result;

/// One entry of the manifest with its camera and frame decided.
pub(super) struct PlacedEntry {
    /// As the manifest has it.
    pub file_path: String,
    /// File, camera and frame, for messages.
    pub place: String,
    /// Name of its camera.
    pub camera_name: String,
    /// Number of its frame.
    pub number: i64,
    /// Where its pixels are and how they are read.
    pub files: PictureFiles,
    /// Its keys in the manifest: the entry's own before those of the whole.
    pub keys: Keys,
    /// Whether it is not read: a frame without samples stands for it.
    pub is_left_out: bool,
    /// Its pose.
    pub world_from_camera: DAffine3,
}

impl PlacedEntry {
    /// A picture of the same camera at another frame, which is in no file.
    pub(super) fn gap_at(&self, number: i64) -> Self {
        Self {
            file_path: String::new(),
            place: format!("camera '{}', frame {number}", self.camera_name),
            camera_name: self.camera_name.clone(),
            number,
            files: self.files.clone(),
            keys: self.keys.clone(),
            is_left_out: true,
            world_from_camera: self.world_from_camera,
        }
    }

    /// The camera of this entry alone, reading the picture's header where the manifest lacks its size.
    pub(super) fn camera(&self) -> Result<Camera> {
        let picture = &self.files.color;
        self.camera_of_size(
            || header_probe::picture_size(picture, self.files.rows, self.files.depth.as_deref(), &self.place),
            || header_probe::pixel_aspect(picture),
        )
    }

    /// The same with the size and the shape of pixels known otherwise, where the manifest lacks them.
    pub(super) fn camera_of_size(
        &self,
        size: impl FnOnce() -> Result<(usize, usize)>,
        pixel_aspect: impl FnOnce() -> f64,
    ) -> Result<Camera> {
        Ok(Camera {
            name: self.camera_name.clone(),
            intrinsics: intrinsics::intrinsics(&self.keys, size, pixel_aspect, &self.place)?,
            world_from_camera: self.world_from_camera,
        })
    }
}
