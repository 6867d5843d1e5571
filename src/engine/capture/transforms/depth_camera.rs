//! A depth camera that is not the color camera: its lens and its place.

use glam::DAffine3;
use serde::{Deserialize, Serialize};

use super::lens::LensKeys;
use super::pose;
use crate::capture::camera::{Camera, Intrinsics};
use crate::capture::pictures::{DepthGrid, Distortion};
use crate::capture::pose_convention::PoseConvention;
use crate::error::{Error, Result};

/// The keys of a depth camera, which mean what they mean for color.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct DepthCameraKeys {
    pub fl_x: Option<f64>,
    pub fl_y: Option<f64>,
    pub cx: Option<f64>,
    pub cy: Option<f64>,
    pub pixel_center_offset: Option<f64>,
    pub camera_model: Option<String>,
    /// Camera to world; the color camera's where missing.
    pub transform_matrix: Option<Vec<Vec<f64>>>,
    #[serde(flatten)]
    pub lens: LensKeys,
}

/// A depth camera.
#[derive(Clone, Debug)]
pub(crate) struct DepthCamera {
    focal_px: (f64, f64),
    /// With pixel centers at +0.5; the middle where missing.
    center_px: (Option<f64>, Option<f64>),
    distortion: Option<Distortion>,
    world_from_camera: Option<DAffine3>,
}

impl DepthCamera {
    /// Takes the values of its keys; its pose has the color camera's convention.
    ///
    /// # Errors
    /// `Invalid` for an impossible focal length and for a pose that is not rigid, `Unsupported` for an unknown lens.
    pub(crate) fn new(keys: &DepthCameraKeys, convention: PoseConvention, place: &str) -> Result<Self> {
        let place = &format!("{place}, depth_camera");
        let Some(fx) = keys.fl_x.or(keys.fl_y) else {
            return Err(Error::invalid(
                place,
                "there is no fl_x; give its focal length in pixels of the depth picture",
            ));
        };
        let fy = keys.fl_y.unwrap_or(fx);
        if ![fx, fy].iter().all(|focal| focal.is_finite() && *focal > 0.0) {
            return Err(Error::invalid(place, format!("fl_x {fx} and fl_y {fy} are no focal lengths")));
        }
        let shift = 0.5 - keys.pixel_center_offset.unwrap_or(0.5);
        let center_px = (keys.cx.map(|cx| cx + shift), keys.cy.map(|cy| cy + shift));
        if [center_px.0, center_px.1].iter().flatten().any(|center| !center.is_finite()) {
            return Err(Error::invalid(place, "cx or cy is no number"));
        }
        let pose =
            keys.transform_matrix.as_ref().map(|rows| pose::world_from_camera(rows, convention, place));
        Ok(Self {
            focal_px: (fx, fy),
            center_px,
            distortion: keys.lens.distortion(keys.camera_model.as_deref(), place)?,
            world_from_camera: pose.transpose()?,
        })
    }

    /// What it is for a picture of this size beside this color camera.
    pub(crate) fn grid(&self, size: (usize, usize), color: &Camera) -> DepthGrid {
        let (width, height) = size;
        let color_from_depth =
            self.world_from_camera.map_or(DAffine3::IDENTITY, |world| color.camera_from_world() * world);
        DepthGrid {
            intrinsics: Intrinsics {
                fy: self.focal_px.1,
                cx: self.center_px.0.unwrap_or(0.5 * width as f64),
                cy: self.center_px.1.unwrap_or(0.5 * height as f64),
                ..Intrinsics::centered(width as u32, height as u32, self.focal_px.0)
            },
            distortion: self.distortion,
            color_from_depth,
        }
    }
}

/// How far the shapes of a color and a depth picture of one lens may differ, relative: rounding to whole pixels.
const SAME_SHAPE: f64 = 0.03;

/// The grid of a depth picture that shares the color camera's lens and place, and has pixels of another size.
///
/// # Errors
/// `Invalid` where it has another shape, so that it cannot be of the same lens.
pub(crate) fn shared_grid(
    size: (usize, usize),
    color: &Camera,
    distortion: Option<Distortion>,
    place: &str,
) -> Result<DepthGrid> {
    let (width, height) = size;
    let own = &color.intrinsics;
    let (sx, sy) = (width as f64 / f64::from(own.width), height as f64 / f64::from(own.height));
    if (sx / sy - 1.0).abs() > SAME_SHAPE {
        let what = format!(
            "the depth is {width}×{height} but its camera's color is {}×{}, which is another shape; give depth_camera with the lens of the depth",
            own.width, own.height
        );
        return Err(Error::invalid(place, what));
    }
    let intrinsics = own.resized(width as u32, height as u32);
    Ok(DepthGrid { intrinsics, distortion, color_from_depth: DAffine3::IDENTITY })
}
