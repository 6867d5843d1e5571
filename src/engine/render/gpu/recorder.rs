//! The stages of one picture, in the order in which they run.

use super::commands::Commands;
use super::layout::GROUPS_ACROSS;
use super::pipelines::Pipelines;
use super::scene::SceneBindings;
use super::target::{GpuTarget, TargetLayout};
use crate::render::gather::BLOCK;
use crate::render::stage_times::Stage;

/// Records the stages of one picture.
pub(super) struct Recorder<'a, 'b> {
    pub(super) pipelines: &'a Pipelines,
    pub(super) scene: &'a SceneBindings,
    pub(super) target: &'a GpuTarget,
    pub(super) commands: &'a mut Commands<'b>,
}

impl Recorder<'_, '_> {
    /// Paints a layer: surface, then blend where the kernel blends.
    pub(super) fn paint(&mut self, layer: usize) {
        let buffers = &self.target.layers[layer];
        self.commands.encoder.clear_buffer(&buffers.keys, 0, None);
        let tiles = self.scene.tile_counts[layer];
        let mut pass = self.commands.pass(Stage::Paint, "surface");
        pass.set_pipeline(&self.pipelines.surface);
        pass.set_bind_group(1, &buffers.group, &[]);
        for step in 0..if self.pipelines.one_pass { 1 } else { 2 } {
            pass.set_bind_group(0, &self.scene.group, &[SceneBindings::stage_offset(layer, step)]);
            dispatch(&mut pass, tiles, 1);
        }
        drop(pass);
        if self.target.blends() {
            self.commands.encoder.clear_buffer(&buffers.sums, 0, None);
            let mut pass = self.commands.pass(Stage::Paint, "blend");
            over_layer(&mut pass, &self.pipelines.blend, self.scene, layer, &buffers.group);
        }
    }

    /// Makes the picture from both layers.
    pub(super) fn resolve(&mut self) {
        let stage = [SceneBindings::stage_offset(0, 0)];
        let TargetLayout { width, height, .. } = self.target.layout;
        if let Some(gather_group) = &self.scene.gather_group {
            let blocks = |pixels: usize| pixels.div_ceil(BLOCK) as u32;
            let stages = [
                (Stage::Silhouettes, "silhouette", &self.pipelines.silhouette),
                (Stage::LookUp, "gather", &self.pipelines.gather),
            ];
            for (stage_of, name, pipeline) in stages {
                let mut pass = self.commands.pass(stage_of, name);
                pass.set_pipeline(pipeline);
                pass.set_bind_group(0, &self.scene.group, &stage);
                pass.set_bind_group(1, gather_group, &[]);
                pass.dispatch_workgroups(blocks(width), blocks(height), 1);
            }
        } else {
            let mut pass = self.commands.pass(Stage::LookUp, "resolve");
            pass.set_pipeline(&self.pipelines.resolve);
            pass.set_bind_group(0, &self.scene.group, &stage);
            pass.set_bind_group(1, &self.target.resolve_group, &[]);
            dispatch(&mut pass, (width * height).div_ceil(256) as u32, 1);
        }
    }
}

/// Runs a stage over the samples of a layer; `group` has what else the stage reads and writes.
pub(super) fn over_layer(
    pass: &mut wgpu::ComputePass<'_>,
    pipeline: &wgpu::ComputePipeline,
    scene: &SceneBindings,
    layer: usize,
    group: &wgpu::BindGroup,
) {
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, &scene.group, &[SceneBindings::stage_offset(layer, 0)]);
    pass.set_bind_group(1, group, &[]);
    dispatch(pass, scene.tile_counts[layer], 1);
}

/// Starts workgroups, in rows that one dimension can hold, and `layers` times as many in a third dimension.
pub(super) fn dispatch(pass: &mut wgpu::ComputePass<'_>, groups: u32, layers: u32) {
    if groups > 0 {
        pass.dispatch_workgroups(groups.min(GROUPS_ACROSS), groups.div_ceil(GROUPS_ACROSS), layers);
    }
}
