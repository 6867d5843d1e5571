//! What is finished, and what of it is known already.

use std::sync::Arc;

use crate::capture::Camera;
use crate::render::gpu::commands::{Commands, over_layer};
use crate::render::gpu::context::Context;
use crate::render::gpu::pipelines::bind;
use crate::render::gpu::scene::SceneBindings;
use crate::render::gpu::target::GpuTarget;
use crate::render::input::FrameSamples;
use crate::render::stage_times::Stage;
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

/// What records how a picture is finished.
pub(super) struct Recording<'a, 'b> {
    pub(super) context: &'a Context,
    pub(super) commands: &'a mut Commands<'b>,
    pub(super) painted: Painted<'a>,
}

impl Recording<'_, '_> {
    /// Records a stage over the samples of a layer, with the layout of these buffers, in the pass of this name.
    pub(super) fn over_layer(
        &mut self,
        (pass, pipeline, layout): (&'static str, &wgpu::ComputePipeline, &wgpu::BindGroupLayout),
        layer: usize,
        buffers: &[&wgpu::Buffer],
    ) {
        let resources = buffers.iter().map(|buffer| buffer.as_entire_binding());
        let group = bind(&self.context.device, layout, resources);
        let mut pass = self.commands.pass(Stage::FreeSpace, pass);
        over_layer(&mut pass, pipeline, self.painted.scene, layer, &group);
    }
}

/// What of the last frame is still known.
#[derive(Clone, Copy)]
pub(super) struct Known {
    pub(super) background: bool,
    pub(super) frame: bool,
}
