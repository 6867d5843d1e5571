//! A reading: what the numbers of a capture's poses and depth mean.

use glam::{DAffine3, DVec3};
use serde::{Deserialize, Serialize};

use crate::capture::depth_claim::DepthMeasure;
use crate::capture::pose_convention::PoseConvention;

/// One way to read poses and depth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reading {
    /// What the matrices mean.
    pub pose: PoseConvention,
    /// What depth measures.
    pub measure: DepthMeasure,
    /// World units per unit of the depth file.
    pub unit: f64,
}

impl Reading {
    /// Planar z of a pixel of the number `value`, whose ray to planar z 1 is `ray` and has the length `ray_length`.
    pub(super) fn planar_z(
        &self,
        value: f64,
        (ray, ray_length): (DVec3, f64),
        world_from_camera: &DAffine3,
        near_clip: f64,
    ) -> f64 {
        let scaled = value * self.unit;
        match self.measure {
            DepthMeasure::PlanarZ => scaled,
            DepthMeasure::RayDistance => scaled / ray_length,
            DepthMeasure::RayDistanceFromNearClip => scaled / ray_length + near_clip,
            DepthMeasure::InversePlanarZ => scaled.recip(),
            DepthMeasure::InverseRayDistance => (scaled * ray_length).recip(),
            DepthMeasure::WorldZ => {
                let eye = world_from_camera.translation.z;
                (scaled - eye) / world_from_camera.transform_vector3(ray).z
            }
        }
    }
}
