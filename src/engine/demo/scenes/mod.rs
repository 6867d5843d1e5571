//! The built-in scenes.

mod camera_arcs;
pub(crate) mod crystal;
pub(crate) mod four_cameras;
mod materials;
pub(crate) mod nine_cameras;
pub(crate) mod orrery;
mod props;

pub(crate) use camera_arcs::SceneCameras;
