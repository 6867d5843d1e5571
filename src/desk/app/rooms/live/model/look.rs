//! How the live view looks.

use glam::DVec3;

use super::orbit_camera::OrbitCamera;
use super::picture::{ColorBy, HoleDisplay};
use super::view_look::{Guides, Ruler, ShownCameras, Unit};
use crate::app::model::scene::OpenScene;

/// Size of the live view before it was first laid out, in pixels: other views want its picture while it lies behind them.
pub(crate) const FIRST_SIZE: [u32; 2] = [960, 720];

/// How the live view looks.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LiveLook {
    /// The virtual camera; `None` while nothing is open.
    pub orbit: Option<OrbitCamera>,
    pub color_by: ColorBy,
    /// As chosen; see [`State::holes_shown`].
    pub holes: HoleDisplay,
    pub show_cameras: bool,
    pub size: [u32; 2],
    pub guides: Guides,
    /// The cameras whose samples are shown.
    pub cameras: ShownCameras,
    pub ruler: Ruler,
    pub unit: Unit,
    /// The chosen direction of up in world space; `None` takes the one of the capture.
    pub up: Option<DVec3>,
    /// The frame of the window in which somebody asked where up is chosen.
    pub up_wanted_at: Option<u64>,
    /// How fast keys fly, in the speed of a first run.
    pub fly_speed: f64,
    /// Whether the GPU may paint on the device that draws the window.
    pub shares_device: bool,
    /// Whether a button of the mouse is held.
    pub is_held: bool,
}

impl LiveLook {
    /// How it looks at another scene: what belongs to the one before is forgotten.
    pub(crate) fn at_scene(&self, scene: &OpenScene) -> Self {
        Self {
            orbit: OrbitCamera::home(scene, scene.up_in_world),
            cameras: ShownCameras::default(),
            ruler: Ruler::default(),
            unit: Unit::default(),
            up: None,
            ..self.clone()
        }
    }
}

impl Default for LiveLook {
    fn default() -> Self {
        Self {
            orbit: None,
            color_by: ColorBy::Picture,
            holes: HoleDisplay::Filled,
            show_cameras: true,
            size: FIRST_SIZE,
            guides: Guides::default(),
            cameras: ShownCameras::default(),
            ruler: Ruler::default(),
            unit: Unit::default(),
            up: None,
            up_wanted_at: None,
            fly_speed: 1.0,
            shares_device: false,
            is_held: false,
        }
    }
}
