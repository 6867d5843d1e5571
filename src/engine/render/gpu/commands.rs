//! The commands of one picture, and how long the adapter took over each stage.

use wgpu::BufferUsages as Usage;

use super::context::Context;
use super::layout::GROUPS_ACROSS;
use super::pipelines::Pipelines;
use super::scene::SceneBindings;
use super::target::{GpuTarget, TargetLayout, read_words};
use crate::error::Result;
use crate::render::gather::BLOCK;
use crate::render::stage_times::{Stage, StageTimes};

/// Passes that are timed at most; further ones are not.
const MOST_PASSES: u32 = 32;

/// Where the adapter writes down when passes begin and end.
#[derive(Debug)]
pub(super) struct Stopwatch {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readback: wgpu::Buffer,
}

impl Stopwatch {
    /// `None` where the adapter does not tell times.
    pub(super) fn new(context: &Context) -> Result<Option<Self>> {
        if !context.device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return Ok(None);
        }
        let queries = context.device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("stages"),
            ty: wgpu::QueryType::Timestamp,
            count: 2 * MOST_PASSES,
        });
        let bytes = u64::from(16 * MOST_PASSES);
        let resolved = context.buffer("times", bytes, Usage::QUERY_RESOLVE | Usage::COPY_SRC)?;
        let readback = context.buffer("times readback", bytes, Usage::MAP_READ | Usage::COPY_DST)?;
        Ok(Some(Self { queries, resolved, readback }))
    }
}

/// Commands that are recorded for one picture.
pub(super) struct Commands<'a> {
    pub(super) encoder: wgpu::CommandEncoder,
    stopwatch: Option<&'a Stopwatch>,
    /// The stages of the passes that are timed.
    timed: Vec<Stage>,
}

/// The passes of submitted commands that were timed.
#[derive(Debug, Default)]
pub(super) struct TimedPasses(Vec<Stage>);

impl<'a> Commands<'a> {
    pub(super) fn new(context: &Context, stopwatch: Option<&'a Stopwatch>) -> Self {
        let encoder = context.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        Self { encoder, stopwatch, timed: Vec::new() }
    }

    /// Begins a pass, by its name, of a stage.
    pub(super) fn pass(&mut self, stage: Stage, name: &'static str) -> wgpu::ComputePass<'_> {
        let nth = self.timed.len() as u32;
        let stopwatch = self.stopwatch.filter(|_| nth < MOST_PASSES);
        if stopwatch.is_some() {
            self.timed.push(stage);
        }
        let timestamp_writes = stopwatch.map(|stopwatch| wgpu::ComputePassTimestampWrites {
            query_set: &stopwatch.queries,
            beginning_of_pass_write_index: Some(2 * nth),
            end_of_pass_write_index: Some(2 * nth + 1),
        });
        self.encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some(name), timestamp_writes })
    }

    /// Hands all commands to the adapter.
    pub(super) fn submit(mut self, context: &Context) -> TimedPasses {
        if let Some(stopwatch) = self.stopwatch.filter(|_| !self.timed.is_empty()) {
            let Stopwatch { queries, resolved, readback } = stopwatch;
            self.encoder.resolve_query_set(queries, 0..2 * self.timed.len() as u32, resolved, 0);
            self.encoder.copy_buffer_to_buffer(resolved, 0, readback, 0, readback.size());
        }
        context.queue.submit([self.encoder.finish()]);
        TimedPasses(self.timed)
    }
}

impl TimedPasses {
    /// Waits for the passes and tells how long each stage took; zeros where the adapter does not tell.
    pub(super) fn read(self, context: &Context, stopwatch: Option<&Stopwatch>) -> Result<StageTimes> {
        let Some(stopwatch) = stopwatch.filter(|_| !self.0.is_empty()) else {
            return Ok(StageTimes::default());
        };
        let per_tick = f64::from(context.queue.get_timestamp_period()) / 1e6;
        read_words(context, &stopwatch.readback, |words| {
            let ticks = |nth: usize| u64::from(words[2 * nth]) | u64::from(words[2 * nth + 1]) << 32;
            let mut times = StageTimes::default();
            for (nth, stage) in self.0.into_iter().enumerate() {
                let milliseconds = ticks(2 * nth + 1).saturating_sub(ticks(2 * nth)) as f64 * per_tick;
                *times.of(stage) += milliseconds;
            }
            times
        })
    }
}

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
