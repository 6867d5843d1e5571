//! Ways of others to show recorded views at new viewpoints, to be measured beside ours.
//!
//! ```text
//! what all cameras saw at a frame ─ build ─▶ RivalModel ─ render ─▶ Picture
//! ```
//!
//! One method a file, each as its source describes it and no better; the top of the file lists the differences. All get the frames as
//! they were recorded, with nothing pruned. Holes stay open, so that the caller fills those of all methods alike.

mod layered_depth_image;
mod model;
mod sky;
mod splat;
mod triangle_mesh;
mod tsdf;

pub use model::{RecordedView, RivalModel};

use serde::{Deserialize, Serialize};

use overlook_engine::capture::in_perspective;
use overlook_engine::error::{Error, Result};

/// A method of others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Rival {
    /// A triangle mesh for each camera, blended by distance and by the stretch of triangles.
    TriangleMesh,
    /// The pixels of the camera that is nearest, carried to the viewpoint.
    NearestCamera,
    /// A volume of truncated signed distances, ray-cast. Its voxels are as wide as this many pixels at the median depth.
    Tsdf(u8),
    /// One picture with several samples along each ray.
    LayeredDepthImage,
}

impl Rival {
    /// Every method; the volume at three sizes of voxels.
    pub const ALL: [Self; 6] = [
        Self::TriangleMesh,
        Self::Tsdf(2),
        Self::Tsdf(4),
        Self::Tsdf(8),
        Self::NearestCamera,
        Self::LayeredDepthImage,
    ];

    /// The method, without its size.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::TriangleMesh => "triangle mesh per camera",
            Self::NearestCamera => "nearest camera",
            Self::Tsdf(_) => "TSDF volume",
            Self::LayeredDepthImage => "layered depth image",
        }
    }

    /// Where the method comes from.
    #[must_use]
    pub fn source(self) -> &'static str {
        match self {
            Self::TriangleMesh => {
                "S. Fachada, D. Bonatto, A. Schenkel, G. Lafruit: Depth Image Based View Synthesis with Multiple Reference Views for \
                 Virtual Reality, 3DTV-CON 2018 (MPEG's RVS)"
            }
            Self::NearestCamera => "L. McMillan, G. Bishop: Plenoptic Modeling, SIGGRAPH 1995",
            Self::Tsdf(_) => {
                "B. Curless, M. Levoy: A Volumetric Method for Building Complex Models from Range Images, SIGGRAPH 1996"
            }
            Self::LayeredDepthImage => {
                "J. Shade, S. Gortler, L. He, R. Szeliski: Layered Depth Images, SIGGRAPH 1998"
            }
        }
    }

    /// Builds the model of one frame.
    ///
    /// # Errors
    /// `Unsupported` where a camera is orthographic; `Invalid` without any camera, or if the method needs a finite depth and no camera saw one.
    pub fn build(self, views: &[RecordedView]) -> Result<Box<dyn RivalModel>> {
        if views.is_empty() {
            return Err(Error::invalid(self.name(), "there is no camera to make a model of"));
        }
        for view in views {
            let what = "this method knows cameras in perspective alone; leave it out";
            in_perspective(std::slice::from_ref(&view.camera), self.name(), what)?;
        }
        Ok(match self {
            Self::TriangleMesh => Box::new(triangle_mesh::TriangleMeshes::new(views)),
            Self::NearestCamera => Box::new(splat::NearestCamera::new(views)),
            Self::Tsdf(footprints) => Box::new(tsdf::Tsdf::of_footprints(views, f64::from(footprints))?),
            Self::LayeredDepthImage => Box::new(layered_depth_image::LayeredDepthImage::new(views)),
        })
    }
}

impl std::fmt::Display for Rival {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Tsdf(footprints) => write!(f, "{}, voxels of {footprints} px", self.name()),
            _ => f.write_str(self.name()),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DVec3;

    use super::*;
    use overlook_engine::capture::{Camera, Frame, Intrinsics, Values};
    use overlook_engine::grid::Grid;

    /// A camera at `x` that looks along +z, at a slope of gray stripes that is 3 away in the middle.
    pub(super) fn slope(x: f64) -> RecordedView {
        let intrinsics = Intrinsics::centered(48, 32, 40.0);
        let mut camera = Camera::look_at("c", intrinsics, DVec3::ZERO, DVec3::Z, DVec3::NEG_Y);
        camera.world_from_camera.translation.x = x;
        // z = 3 + 0.5 X, where X = x + z ray.
        let depth = |column: usize| {
            let ray = (column as f64 + 0.5 - 24.0) / 40.0;
            ((3.0 + 0.5 * x) / (1.0 - 0.5 * ray), ray)
        };
        let gray = |column: usize| {
            let (depth, ray) = depth(column);
            let value = 0.4 + 0.3 * (2.0 * (x + depth * ray)).sin();
            [half::f16::from_f64(value); 3]
        };
        let frame = Frame {
            color: Grid::from_fn(48, 32, |column, _| gray(column)),
            inverse_depth: Grid::from_fn(48, 32, |column, _| (1.0 / depth(column).0) as f32),
            normal_in_world: None,
            depth_step_relative: 0.0,
            values: Values::default(),
        };
        RecordedView { camera, frame: Arc::new(frame) }
    }

    #[test]
    fn every_rival_gives_the_same_picture_twice_and_refuses_to_be_made_of_nothing() {
        let views = [slope(-0.3), slope(0.3)];
        for rival in Rival::ALL {
            let [one, other] = [(); 2].map(|()| rival.build(&views).unwrap());
            assert_eq!(one.render(&slope(0.1).camera), other.render(&slope(0.1).camera), "{rival}");
            assert_eq!(one.bytes(), other.bytes());
            assert!(rival.build(&[]).is_err());
        }
    }
}
