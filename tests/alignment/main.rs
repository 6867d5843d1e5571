//! What a rig got wrong is found and mended, and what is right keeps every bit.

#[path = "../common/draws.rs"]
mod draws;
#[path = "../common/scene.rs"]
mod scene;

mod camera_residuals;
mod color_lens;
mod conventions;
mod rigs;
