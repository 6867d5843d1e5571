//! Registration (the paper, §3.2): carries samples into other cameras, and decides whether both saw the same surface point.

mod matches;
mod noise_tolerance;
mod reproject;
mod same_surface;
mod surrounded;

pub use matches::Outcome;
pub(crate) use matches::{HAS_DEPTH, IN_VIEW, NEARER, ON_SURFACE, RequiredTolerances};
pub(crate) use reproject::{PixelRun, ReprojectedRun, SourceRun, TargetRun, lanes_of};
pub(crate) use same_surface::SameSurface;
