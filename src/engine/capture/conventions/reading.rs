//! A reading: what the numbers of a capture's poses and depth mean.

use glam::{DAffine3, DVec2, DVec3};
use serde::{Deserialize, Serialize};

use crate::capture::camera::Intrinsics;
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

    /// The ray through an image position.
    pub(super) fn through(lens: &Intrinsics, pixel: DVec2) -> Self {
        Self::new(lens.ray_in_camera(pixel))
    }

    /// The ray that goes through a point at planar z 1.
    pub(super) fn new(to_unit_z: DVec3) -> Self {
        Self { to_unit_z, length: to_unit_z.length() }
    }
}

/// How lenses are read otherwise than claimed: all cameras' alike.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LensReading {
    /// Focal lengths, as multiples of those claimed.
    pub focal: f64,
    /// Principal points beside those claimed, as shares of the width and the height of the picture.
    pub center: [f64; 2],
}

impl Default for LensReading {
    fn default() -> Self {
        Self { focal: 1.0, center: [0.0; 2] }
    }
}

impl LensReading {
    /// A claimed lens, read this way.
    #[must_use]
    pub fn of(&self, claimed: &Intrinsics) -> Intrinsics {
        Intrinsics {
            fx: claimed.fx * self.focal,
            fy: claimed.fy * self.focal,
            cx: claimed.cx + self.center[0] * f64::from(claimed.width),
            cy: claimed.cy + self.center[1] * f64::from(claimed.height),
            ..*claimed
        }
    }

    /// What differs from the claimed lens, a phrase each; none where it is as claimed.
    #[must_use]
    pub fn words(&self) -> Vec<String> {
        let mut words = Vec::new();
        if self.focal != 1.0 {
            words.push(format!("focal lengths are {:.3} times those claimed", self.focal));
        }
        if self.center != [0.0; 2] {
            let [x, y] = self.center.map(|shift| 100.0 * shift);
            words.push(format!(
                "principal points are {x:+.0} % of the width and {y:+.0} % of the height from those claimed"
            ));
        }
        words
    }

    fn is_claimed(&self) -> bool {
        *self == Self::default()
    }
}

/// One way to read poses, depth and lenses.
#[serde_with::skip_serializing_none]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reading {
    /// What the matrices mean.
    pub pose: PoseConvention,
    /// What depth measures.
    pub measure: DepthMeasure,
    /// World units per unit of the depth file.
    pub unit: f64,
    /// The planes of a depth buffer, of nothing else.
    pub planes: Option<DepthPlanes>,
    /// What the lenses are beside those claimed.
    #[serde(default, skip_serializing_if = "LensReading::is_claimed")]
    pub lens: LensReading,
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
            DepthMeasure::EvenBetweenPlanes => self.planes.map_or(f64::NAN, |planes| {
                planes.far.map_or(f64::NAN, |far| planes.near + scaled * (far - planes.near))
            }),
        }
    }

    /// Planar z of a number from 0 at the far plane to 1 at the near one; NaN outside.
    fn between_planes(&self, nearness: f64) -> f64 {
        let planes = self.planes.filter(|_| nearness > 0.0 && nearness < 1.0);
        planes.map_or(f64::NAN, |planes| planes.inverse_depth(nearness).recip())
    }
}
