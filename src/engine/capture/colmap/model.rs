//! COLMAP's cameras and images.

use glam::{DAffine3, DMat3, DQuat, DVec3};

use super::lens_model::LensModel;

/// A camera: the lens of one or more images.
#[derive(Clone, Debug, PartialEq)]
pub struct ColmapCamera {
    /// What images name it by.
    pub id: u64,
    /// What its parameters mean.
    pub model: LensModel,
    /// Columns.
    pub width: u64,
    /// Rows.
    pub height: u64,
    /// As many as the model has.
    pub parameters: Vec<f64>,
}

/// An image: where it was taken, and by which camera.
#[derive(Clone, Debug, PartialEq)]
pub struct ColmapImage {
    /// What points name it by.
    pub id: u64,
    /// Its file below the folder of images.
    pub name: String,
    /// Its camera.
    pub camera: u64,
    /// Rotation of the pose, world to camera: w, x, y, z.
    pub quaternion: [f64; 4],
    /// Translation of the pose, world to camera.
    pub translation: [f64; 3],
}

impl ColmapImage {
    /// World from camera space: x right, y down, z forward. `None` where the quaternion is of no length, or a number is not finite.
    #[must_use]
    pub fn world_from_camera(&self) -> Option<DAffine3> {
        let [w, x, y, z] = self.quaternion;
        let quaternion = DQuat::from_xyzw(x, y, z, w);
        let translation = DVec3::from(self.translation);
        // COLMAP normalizes what it reads.
        let is_pose = quaternion.length() > 1e-6 && quaternion.is_finite() && translation.is_finite();
        let rotation = DMat3::from_quat(quaternion.normalize());
        is_pose.then(|| DAffine3::from_mat3_translation(rotation, translation).inverse())
    }
}
