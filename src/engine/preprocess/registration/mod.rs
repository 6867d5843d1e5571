//! Registration (the paper, §3.2): carries samples into other cameras, and decides whether both saw the same surface point.

mod around;
mod camera_pairs;
mod matches;
mod noise_tolerance;
mod reproject;
mod same_surface;
mod sight;
mod tolerances;

pub use camera_pairs::CameraPairs;
pub use matches::Outcome;
pub(crate) use matches::{HAS_DEPTH, IN_VIEW, NEARER, ON_SURFACE, RequiredTolerances};
pub(crate) use reproject::{PixelRun, Registration, ReprojectedRun, SourceRun, TargetRun, lanes_of};
pub(crate) use same_surface::SameSurface;
pub(crate) use sight::Sight;
