//! What is known: plain data.

pub(crate) mod command;
pub(crate) mod kept_views;
pub(crate) mod look;
pub(crate) mod motion_budget;
pub(crate) mod orbit_camera;
pub(crate) mod picture;
pub(crate) mod pose;
pub(crate) mod seen_picture;
mod view_addresses;
pub(crate) mod view_history;
pub(crate) mod view_look;

pub(crate) use command::{KeptViewCommand, ViewCommand};
pub(crate) use kept_views::{KeptView, next_name};
pub(crate) use look::LiveLook;
pub(crate) use orbit_camera::OrbitCamera;
pub(crate) use picture::{
    CarriedLook, CarryKey, ColorBy, HoleDisplay, LiveKey, LivePicture, PixelSource, ShownCarried,
};
pub(crate) use pose::{ANGLES_OF_VIEW, ViewAngles};
pub(crate) use view_history::ViewHistory;
pub(crate) use view_look::{FLY_SPEEDS, FrameGuide, Guides, ShownCameras, UP_DIRECTIONS, Unit};
