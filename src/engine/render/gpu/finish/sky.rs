//! The sky that cameras saw, by direction: the stages of `shaders/sky/`.

use super::painted::{Known, Recording};
use crate::error::Result;
use crate::render::geometry::rays_in_world;
use crate::render::gpu::context::Context;
use crate::render::gpu::layout::{GpuCameraRays, SUM_WORDS};
use crate::render::gpu::pipelines::{Pipelines, READ, UNIFORM_AT, WRITE, bind, first_of, layout, pipeline};
use crate::render::gpu::scene::{list, numbers_at, uniform_at};
use crate::render::gpu::shaders::{FILL_SKY, HALVE_SKY, SUM_SKY};
use crate::render::stage_times::Stage;
use bytemuck::Zeroable;
use wgpu::BufferUsages as Usage;

/// Cells along each side of the finest grid, as `SKY_SIDE` in `sky_grids.wgsl`.
pub(crate) const SKY_SIDE: u64 = 64;

/// Grids: each is half as fine as the one before, and the last has one cell.
const GRIDS: u32 = SKY_SIDE.ilog2() + 1;

/// Threads of a workgroup along each side, as in `halve_sky.wgsl` and `fill_sky.wgsl`.
const GROUP: u32 = 4;

/// The compiled stages, and what they found.
#[derive(Debug)]
pub(super) struct Sky {
    sum_layout: wgpu::BindGroupLayout,
    grid_layout: wgpu::BindGroupLayout,
    sum: wgpu::ComputePipeline,
    halve: wgpu::ComputePipeline,
    fill: wgpu::ComputePipeline,
    grids: Option<SkyGrids>,
}

/// The buffers.
#[derive(Debug)]
struct SkyGrids {
    /// Sums in the finest grid, in fixed point: of the background, and of the frame.
    background: wgpu::Buffer,
    frame: wgpu::Buffer,
    sums: wgpu::Buffer,
    environment: wgpu::Buffer,
    /// The number of each grid, at its offset.
    levels: wgpu::Buffer,
}

impl SkyGrids {
    fn new(context: &Context) -> Result<Self> {
        let cells: u64 = (0..GRIDS).map(|nth| (SKY_SIDE >> nth).pow(3)).sum();
        let sum_usage = Usage::STORAGE | Usage::COPY_DST | Usage::COPY_SRC;
        let sums_of = |label| context.buffer(label, 4 * SUM_WORDS * SKY_SIDE.pow(3), sum_usage);
        let levels: Vec<[u32; 4]> = (0..GRIDS).map(|level| [level, 0, 0, 0]).collect();
        Ok(Self {
            background: sums_of("sky of the background")?,
            frame: sums_of("sky of the frame")?,
            sums: context.buffer("sums of the sky", 16 * cells, Usage::STORAGE)?,
            // Behind all grids is told how often the sky was seen.
            environment: context.buffer("sky", 16 * (cells + 1), Usage::STORAGE)?,
            levels: uniform_at(context, "grids of the sky", &levels)?,
        })
    }
}

impl Sky {
    /// Compiles the stages.
    pub(super) fn new(context: &Context, pipelines: &Pipelines) -> Self {
        let device = &context.device;
        let sum_layout = layout(device, "sum sky", &[READ, WRITE]);
        let grid_layout = layout(device, "grids of the sky", &[UNIFORM_AT, READ, WRITE, WRITE]);
        let over_samples = [Some(&pipelines.scene_layout), Some(&sum_layout)];
        Self {
            sum: pipeline(device, &SUM_SKY, &over_samples),
            halve: pipeline(device, &HALVE_SKY, &[Some(&grid_layout)]),
            fill: pipeline(device, &FILL_SKY, &[Some(&grid_layout)]),
            sum_layout,
            grid_layout,
            grids: None,
        }
    }

    /// The colors of all directions, once they were recorded.
    pub(super) fn environment(&self) -> Option<&wgpu::Buffer> {
        self.grids.as_ref().map(|grids| &grids.environment)
    }

    pub(super) fn drop_buffers(&mut self) {
        self.grids = None;
    }

    /// Records what finds the sky, as far as it is not known.
    pub(super) fn record(&mut self, recording: &mut Recording<'_, '_>, known: Known) -> Result<()> {
        let known = if self.grids.is_some() { known } else { Known { background: false, frame: false } };
        if known.frame {
            return Ok(());
        }
        let grids = match self.grids.take() {
            Some(grids) => grids,
            None => SkyGrids::new(recording.context)?,
        };
        let rays: Vec<GpuCameraRays> = recording.painted.frame.set.cameras.iter().map(rays_of).collect();
        let rays = list(recording.context, "rays of cameras", &rays)?;
        let sum = ("sky", &self.sum, &self.sum_layout);
        if !known.background {
            recording.commands.encoder.clear_buffer(&grids.background, 0, None);
            recording.over_layer(sum, 0, &[&rays, &grids.background]);
        }
        let (encoder, bytes) = (&mut recording.commands.encoder, grids.background.size());
        encoder.copy_buffer_to_buffer(&grids.background, 0, &grids.frame, 0, bytes);
        recording.over_layer(sum, 1, &[&rays, &grids.frame]);
        self.color_grids(recording, &grids);
        self.grids = Some(grids);
        Ok(())
    }

    /// Makes all grids, from the finest to the coarsest, and colors them, from the coarsest to the finest.
    fn color_grids(&self, recording: &mut Recording<'_, '_>, grids: &SkyGrids) {
        let resources = [
            first_of::<[u32; 4]>(&grids.levels),
            grids.frame.as_entire_binding(),
            grids.sums.as_entire_binding(),
            grids.environment.as_entire_binding(),
        ];
        let group = bind(&recording.context.device, &self.grid_layout, resources);
        let mut pass = recording.commands.pass(Stage::FreeSpace, "sky");
        let mut run = |pipeline: &wgpu::ComputePipeline, level: u32| {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &group, &[numbers_at(level as usize)]);
            let groups = (SKY_SIDE as u32 >> level).div_ceil(GROUP);
            pass.dispatch_workgroups(groups, groups, groups);
        };
        (0..GRIDS).for_each(|level| run(&self.halve, level));
        (0..GRIDS).rev().for_each(|level| run(&self.fill, level));
    }
}

fn rays_of(camera: &crate::capture::Camera) -> GpuCameraRays {
    let [first, across, down] = rays_in_world(camera, 0.5).map(|ray| ray.to_array());
    GpuCameraRays { first, across, down, ..GpuCameraRays::zeroed() }
}
