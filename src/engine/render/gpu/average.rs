//! The average stage: of a picture that was painted finer, only the averaged one leaves the adapter.

use bytemuck::{Pod, Zeroable};
use wgpu::BufferUsages as Usage;

use super::commands::Commands;
use super::context::Context;
use super::layout::PICTURE_WORDS;
use super::pipelines::{READ, UNIFORM, WRITE, bind, layout, pipeline};
use super::scene::list;
use super::shaders;
use super::target::GpuTarget;
use crate::error::Result;
use crate::render::stage_times::Stage;
use crate::render::supersample::nearest_to_center;

/// Threads of a workgroup along each side, as in `average.wgsl`.
const GROUP: usize = 16;

/// `Average` in `average.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct GpuAverage {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) factor: u32,
    pub(super) padding: u32,
}

/// The compiled stage.
#[derive(Debug)]
pub(super) struct AveragePass {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
}

/// An averaged picture, and where the CPU can read it.
pub(super) struct AveragedPicture {
    pub(super) readback: wgpu::Buffer,
    /// Columns and rows.
    pub(super) size: (usize, usize),
}

impl AveragePass {
    /// Compiles the stage.
    pub(super) fn new(context: &Context) -> Self {
        let layout = layout(&context.device, "average", &[UNIFORM, READ, READ, WRITE]);
        let pipeline = pipeline(&context.device, &shaders::AVERAGE, &[Some(&layout)]);
        Self { layout, pipeline }
    }

    /// Records the average of `target`'s picture over squares of `factor` pixels, and a copy of it to where the CPU can read it.
    pub(super) fn record(
        &self,
        context: &Context,
        target: &GpuTarget,
        commands: &mut Commands<'_>,
        factor: usize,
    ) -> Result<AveragedPicture> {
        let (width, height) = target.picture_size();
        let size = (width / factor, height / factor);
        let numbers =
            GpuAverage { width: size.0 as u32, height: size.1 as u32, factor: factor as u32, padding: 0 };
        let order: Vec<[u32; 2]> =
            nearest_to_center(factor).into_iter().map(|(x, y)| [x as u32, y as u32]).collect();
        let numbers = context.written("average", bytemuck::bytes_of(&numbers), Usage::UNIFORM)?;
        let order = list(context, "order", &order)?;
        let bytes = 4 * PICTURE_WORDS * (size.0 * size.1) as u64;
        let averaged = context.buffer("averaged picture", bytes, Usage::STORAGE | Usage::COPY_SRC)?;
        let readback = context.buffer("readback", bytes, Usage::MAP_READ | Usage::COPY_DST)?;
        let buffers = [&numbers, &order, &target.picture, &averaged];
        let group = bind(&context.device, &self.layout, buffers.map(wgpu::Buffer::as_entire_binding));
        let mut pass = commands.pass(Stage::Copy, "average");
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &group, &[]);
        let groups = |pixels: usize| pixels.div_ceil(GROUP) as u32;
        pass.dispatch_workgroups(groups(size.0), groups(size.1), 1);
        drop(pass);
        commands.encoder.copy_buffer_to_buffer(&averaged, 0, &readback, 0, bytes);
        Ok(AveragedPicture { readback, size })
    }
}
