//! A reading: what the numbers of a capture's poses and depth mean.

use glam::{DAffine3, DVec3};
use serde::{Deserialize, Serialize};

use crate::capture::depth_claim::{DepthMeasure, DepthPlanes};
use crate::capture::pose_convention::PoseConvention;

/// The ray through a point of a picture, in camera space.
#[derive(Clone, Copy, Debug)]
pub(super) struct PixelRay {
    /// From the camera to planar z 1.
    pub to_unit_z: DVec3,
    /// Its length.
    pub length: f64,
}

impl PixelRay {
    /// The ray along the camera's axis.
    pub(super) const AXIS: Self = Self { to_unit_z: DVec3::Z, length: 1.0 };

    /// The ray that goes through a point at planar z 1.
    pub(super) fn new(to_unit_z: DVec3) -> Self {
        Self { to_unit_z, length: to_unit_z.length() }
    }
}

/// One way to read poses and depth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reading {
    /// What the matrices mean.
    pub pose: PoseConvention,
    /// What depth measures.
    pub measure: DepthMeasure,
    /// World units per unit of the depth file.
    pub unit: f64,
    /// The planes of a depth buffer, of nothing else.
    #[serde(default)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub planes: Option<DepthPlanes>,
}

impl Reading {
    /// Planar z of a pixel with the number `value` and the ray `ray`.
    pub(super) fn planar_z(
        &self,
        value: f64,
        ray: PixelRay,
        world_from_camera: &DAffine3,
        near_clip: f64,
    ) -> f64 {
        let scaled = value * self.unit;
        match self.measure {
            DepthMeasure::PlanarZ => scaled,
            DepthMeasure::RayDistance => scaled / ray.length,
            DepthMeasure::RayDistanceFromNearClip => scaled / ray.length + near_clip,
            DepthMeasure::InversePlanarZ => scaled.recip(),
            DepthMeasure::InverseRayDistance => (scaled * ray.length).recip(),
            DepthMeasure::WorldZ => {
                let eye = world_from_camera.translation.z;
                (scaled - eye) / world_from_camera.transform_vector3(ray.to_unit_z).z
            }
            DepthMeasure::ZBuffer => self.between_planes(1.0 - scaled),
            DepthMeasure::ReversedZBuffer => self.between_planes(scaled),
        }
    }

    /// Planar z of a number from 0 at the far plane to 1 at the near one; NaN outside.
    fn between_planes(&self, nearness: f64) -> f64 {
        let planes = self.planes.filter(|_| nearness > 0.0 && nearness < 1.0);
        planes.map_or(f64::NAN, |planes| planes.inverse_depth(nearness).recip())
    }
}
