//! What the numbers of depth files measure, and how they were read.

use glam::{DAffine3, DVec3};
use serde::{Deserialize, Serialize};

/// What a number of depth measures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DepthMeasure {
    /// Distance along the optical axis.
    #[default]
    PlanarZ,
    /// Distance from the camera along the pixel's ray.
    RayDistance,
    /// Distance from the near plane along the pixel's ray.
    RayDistanceFromNearClip,
    /// Reciprocal of the distance along the optical axis.
    InversePlanarZ,
    /// Reciprocal of the distance from the camera along the pixel's ray.
    InverseRayDistance,
    /// The z coordinate of the surface point in world space.
    WorldZ,
    /// A depth buffer: 0 at the near plane, 1 at the far plane, even in the reciprocal of depth along the optical axis.
    ZBuffer,
    /// The same from 0 at the far plane to 1 at the near plane.
    ReversedZBuffer,
    /// Even in depth along the optical axis, from one plane at 0 to another one at 1, whichever of them is nearer.
    EvenBetweenPlanes,
}

impl DepthMeasure {
    /// As the manifest's `depth_kind` has it, where it has.
    #[must_use]
    pub fn depth_kind(self) -> Option<&'static str> {
        match self {
            Self::PlanarZ => Some("planar_z"),
            Self::RayDistance => Some("ray_distance"),
            Self::RayDistanceFromNearClip => Some("ray_distance_from_near_clip"),
            Self::WorldZ => Some("world_z"),
            Self::ZBuffer => Some("z_buffer"),
            Self::ReversedZBuffer => Some("reversed_z_buffer"),
            Self::InversePlanarZ | Self::InverseRayDistance | Self::EvenBetweenPlanes => None,
        }
    }

    /// In words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::PlanarZ => "depth along the optical axis",
            Self::RayDistance => "distance along the ray from the camera",
            Self::RayDistanceFromNearClip => "distance along the ray from the near plane",
            Self::InversePlanarZ => "disparity, the reciprocal of depth along the optical axis",
            Self::InverseRayDistance => "the reciprocal of distance along the ray",
            Self::WorldZ => "the z coordinate in world space",
            Self::ZBuffer => "a depth buffer, 0 at the near plane and 1 at the far plane",
            Self::ReversedZBuffer => "a reversed depth buffer, 1 at the near plane and 0 at the far plane",
            Self::EvenBetweenPlanes => "even in depth, from one plane at 0 to another at 1",
        }
    }

    /// Whether it is a number between two planes.
    pub(crate) fn is_buffer(self) -> bool {
        matches!(self, Self::ZBuffer | Self::ReversedZBuffer)
    }

    /// Whether two measures differ by less than can be seen at this depth.
    pub(crate) fn is_like(self, other: Self, near_clip: f64, depth: f64) -> bool {
        let along_ray = |measure| matches!(measure, Self::RayDistance | Self::RayDistanceFromNearClip);
        self == other || (along_ray(self) && along_ray(other) && near_clip < 0.01 * depth)
    }
}

/// The planes between which numbers of depth are even in the reciprocal of depth along the optical axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DepthPlanes {
    /// Distance of the near plane, world units.
    pub near: f64,
    /// Distance of the far plane; `None` where it is infinite.
    pub far: Option<f64>,
}

impl DepthPlanes {
    /// 1/z at this share of the way from the far plane, 0, to the near one, 1.
    pub(crate) fn inverse_depth(self, nearness: f64) -> f64 {
        let far = self.far.map_or(0.0, f64::recip);
        far + nearness * (self.near.recip() - far)
    }

    /// The share of the way from the far plane to the near one at which 1/z is this.
    pub(crate) fn nearness(self, inverse_depth: f64) -> f64 {
        let far = self.far.map_or(0.0, f64::recip);
        (inverse_depth - far) / (self.near.recip() - far)
    }
}

/// How depth was read: what turns the planar z of a frame back into the number of its file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthClaim {
    /// What the number is taken for.
    pub measure: DepthMeasure,
    /// World units per unit of the file.
    pub unit: f64,
    /// Distance of the near plane, world units; 0 where it is not known.
    pub near_clip: f64,
    /// The planes that the numbers are between, where they are.
    pub planes: Option<DepthPlanes>,
}

impl Default for DepthClaim {
    fn default() -> Self {
        Self { measure: DepthMeasure::PlanarZ, unit: 1.0, near_clip: 0.0, planes: None }
    }
}

impl DepthClaim {
    /// The number of the file that was read as the planar z `z`, for a ray to planar z 1 in the camera's space.
    pub(crate) fn value(&self, z: f64, ray: DVec3, world_from_camera: &DAffine3) -> f64 {
        let ray_length = ray.length();
        match self.measure {
            DepthMeasure::RayDistance => z * ray_length / self.unit,
            DepthMeasure::RayDistanceFromNearClip => (z - self.near_clip) * ray_length / self.unit,
            DepthMeasure::InversePlanarZ => (z * self.unit).recip(),
            DepthMeasure::InverseRayDistance => (z * ray_length * self.unit).recip(),
            DepthMeasure::PlanarZ => z / self.unit,
            DepthMeasure::WorldZ => world_from_camera.transform_point3(ray * z).z / self.unit,
            DepthMeasure::ZBuffer => (1.0 - self.nearness(z)) / self.unit,
            DepthMeasure::ReversedZBuffer => self.nearness(z) / self.unit,
            DepthMeasure::EvenBetweenPlanes => self.planes.map_or(f64::NAN, |planes| {
                planes.far.map_or(f64::NAN, |far| (z - planes.near) / (far - planes.near))
            }),
        }
    }

    fn nearness(&self, z: f64) -> f64 {
        self.planes.map_or(f64::NAN, |planes| planes.nearness(z.recip()))
    }
}
