//! Registration (the paper, §3.2): carries samples into other cameras, and decides whether both saw the same surface point.

mod answers;
mod camera_pairs;
mod noisy_colors;
mod noisy_depths;
mod reproject;
mod same_surface;

pub(crate) use answers::{IN_VIEW, Needs};
pub use answers::{LANES, Outcome};
pub use camera_pairs::CameraPairs;
pub(crate) use reproject::{Carried, lanes_of};
pub use reproject::{PixelRun, Registration};
pub use same_surface::SameSurface;
