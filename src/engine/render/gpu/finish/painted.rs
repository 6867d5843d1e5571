//! What is finished, and what of it is known already.

use std::sync::Arc;

use crate::capture::Camera;
use crate::render::gpu::scene::SceneBindings;
use crate::render::gpu::target::GpuTarget;
use crate::render::input::FrameSamples;
use crate::samples::SampleSet;
use crate::settings::RenderSettings;

/// A painted picture.
#[derive(Clone, Copy)]
pub(crate) struct Painted<'a> {
    pub(crate) samples: &'a Arc<SampleSet>,
    pub(crate) frame: &'a FrameSamples<'a>,
    /// The vantage's camera.
    pub(crate) camera: &'a Camera,
    pub(crate) settings: &'a RenderSettings,
    pub(crate) scene: &'a SceneBindings,
    pub(crate) target: &'a GpuTarget,
}

/// What of the last frame is still known.
#[derive(Clone, Copy)]
pub(super) struct Known {
    pub(super) background: bool,
    pub(super) frame: bool,
}
