//! Alignment: the errors of a rig are found and corrected, correct values keep every bit, and conventions are recognized.

#[path = "../common/draws.rs"]
mod draws;
#[path = "../common/scene.rs"]
mod scene;

mod camera_residuals;
mod color_lens;
mod conventions;
mod conventions_by_pictures;
mod do_no_harm;
mod exact_scenes;
mod rigs;
