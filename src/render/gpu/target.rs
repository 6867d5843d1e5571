//! The buffers of a picture: two layers, the resolved picture, and a buffer that the CPU can read.

use super::context::Context;
use super::layout::{KEY_WORDS, PICTURE_WORDS, SUM_WORDS};
use super::pipelines::{Pipelines, bind};
use crate::error::Result;
use crate::grid::Grid;
use crate::render::vantage::Picture;
use wgpu::BufferUsages as Usage;

/// The keys and sums of a layer.
#[derive(Debug)]
pub(super) struct PaintedImages {
    pub(super) keys: wgpu::Buffer,
    pub(super) sums: wgpu::Buffer,
    pub(super) group: wgpu::BindGroup,
}

impl PaintedImages {
    fn new(context: &Context, pipelines: &Pipelines, pixels: u64, blends: bool) -> Result<Self> {
        let usage = Usage::STORAGE | Usage::COPY_DST | Usage::COPY_SRC;
        let keys = context.buffer("keys", 4 * KEY_WORDS * pixels, usage)?;
        let sums = context.buffer("sums", if blends { 4 * SUM_WORDS * pixels } else { 0 }, usage)?;
        let group = bind(
            &context.device,
            &pipelines.layer_layout,
            [&keys, &sums].map(wgpu::Buffer::as_entire_binding),
        );
        Ok(Self { keys, sums, group })
    }
}

/// The buffers of a picture.
#[derive(Debug)]
pub(super) struct GpuTarget {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) blends: bool,
    /// Background and foreground.
    pub(super) layers: [PaintedImages; 2],
    pub(super) picture: wgpu::Buffer,
    pub(super) resolve_group: wgpu::BindGroup,
    readback: wgpu::Buffer,
}

impl GpuTarget {
    /// Buffers for a picture of this size, with sums where the kernel blends.
    pub(super) fn new(
        context: &Context,
        pipelines: &Pipelines,
        (width, height): (usize, usize),
        blends: bool,
    ) -> Result<Self> {
        let pixels = (width * height) as u64;
        let layer = || PaintedImages::new(context, pipelines, pixels, blends);
        let layers = [layer()?, layer()?];
        let bytes = 4 * PICTURE_WORDS * pixels;
        let picture = context.buffer("picture", bytes, Usage::STORAGE | Usage::COPY_SRC)?;
        let readback = context.buffer("readback", bytes, Usage::MAP_READ | Usage::COPY_DST)?;
        let buffers = [&layers[0].keys, &layers[0].sums, &layers[1].keys, &layers[1].sums, &picture];
        let resources = buffers.map(wgpu::Buffer::as_entire_binding);
        let resolve_group = bind(&context.device, &pipelines.resolve_layout, resources);
        Ok(Self { width, height, blends, layers, picture, resolve_group, readback })
    }

    /// Pixels of the picture.
    pub(super) fn pixels(&self) -> usize {
        self.width * self.height
    }

    /// Records a copy of the picture to where the CPU can read it.
    pub(super) fn record_readback(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.copy_buffer_to_buffer(&self.picture, 0, &self.readback, 0, self.readback.size());
    }

    /// Waits for the picture and reads it.
    pub(super) fn read(&self, context: &Context) -> Result<Picture> {
        let pixels = self.pixels();
        read_words(context, &self.readback, |words| {
            let (color, rest) = words[..5 * pixels].split_at(3 * pixels);
            let (depth, image) = rest.split_at(pixels);
            let color: &[[f32; 3]] = bytemuck::cast_slice(color);
            Picture {
                color: Grid::from_vec(self.width, self.height, color.to_vec()),
                inverse_depth: Grid::from_vec(self.width, self.height, bytemuck::cast_slice(depth).to_vec()),
                image: Grid::from_vec(self.width, self.height, image.to_vec()),
            }
        })
    }
}

/// Waits for all work and passes on the words of a buffer that the CPU may map.
pub(super) fn read_words<T>(
    context: &Context,
    buffer: &wgpu::Buffer,
    take: impl FnOnce(&[u32]) -> T,
) -> Result<T> {
    let (sender, receiver) = std::sync::mpsc::sync_channel(1);
    buffer.map_async(wgpu::MapMode::Read, .., move |mapped| {
        // The receiver is gone only where waiting failed, which is an error already.
        let _ = sender.send(mapped);
    });
    context.wait()?;
    let mapped = receiver.try_recv().map_err(|_| context.error("the picture did not come back"))?;
    mapped.map_err(|error| context.error(error))?;
    let view = buffer.get_mapped_range(..).map_err(|error| context.error(error))?;
    let taken = take(bytemuck::cast_slice(&view));
    drop(view);
    buffer.unmap();
    Ok(taken)
}
