//! Registration (the paper, §3.2): carries samples into other cameras, and decides whether both saw the same surface point.

mod answers;
mod camera_pairs;
mod noisy_colors;
mod noisy_depths;
mod reproject;
mod same_surface;

pub use answers::Outcome;
pub(crate) use answers::{IN_VIEW, LANES, RequiredTolerances};
pub(crate) use camera_pairs::CameraPairs;
pub(crate) use reproject::{PixelRun, Registration};
pub(crate) use reproject::{ReprojectedRun, lanes_of};
pub(crate) use same_surface::SameSurface;
