//! The buffers of a picture: two layers, the resolved picture, and a buffer that the CPU can read.

use super::context::Context;
use super::layout::{COVERAGE_WORDS, FRONT_WORDS, KEY_WORDS, PICTURE_WORDS, SUM_WORDS, SURFACE_WORDS};
use super::pipelines::{Pipelines, bind};
use crate::error::Result;
use crate::grid::Grid;
use crate::render::vantage::Picture;
use crate::settings::Kernel;
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

/// What the buffers of a picture are made for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TargetLayout {
    /// Columns of the z-buffer.
    pub(super) width: usize,
    /// Rows of the z-buffer.
    pub(super) height: usize,
    /// Pixels of the z-buffer along each side of a pixel of the picture.
    pub(super) subpixels: usize,
    pub(super) kernel: Kernel,
    /// Whether the picture holds the colors that pixels show in front of their farthest surface.
    pub(super) with_fronts: bool,
}

impl TargetLayout {
    /// Whether the picture tells which shares of pixels are shown.
    pub(super) fn has_coverage(&self) -> bool {
        self.subpixels > 1
    }
}

/// The buffers of a picture.
#[derive(Debug)]
pub(super) struct GpuTarget {
    pub(super) layout: TargetLayout,
    /// Background and foreground.
    pub(super) layers: [PaintedImages; 2],
    pub(super) picture: wgpu::Buffer,
    pub(super) resolve_group: wgpu::BindGroup,
    readback: wgpu::Buffer,
}

impl GpuTarget {
    /// Buffers for a z-buffer and a picture of this layout.
    pub(super) fn new(context: &Context, pipelines: &Pipelines, layout: TargetLayout) -> Result<Self> {
        let TargetLayout { width, height, subpixels, kernel, with_fronts } = layout;
        let pixels = (width * height) as u64;
        let blends = matches!(kernel, Kernel::Block | Kernel::Surfel);
        let layer = || PaintedImages::new(context, pipelines, pixels, blends);
        let layers = [layer()?, layer()?];
        let words = PICTURE_WORDS + COVERAGE_WORDS + if with_fronts { FRONT_WORDS } else { 0 };
        let bytes = 4 * words * pixels / (subpixels * subpixels) as u64;
        // The gather stage finds the surfaces of all pixels of the z-buffer behind the picture.
        let surfaces = if kernel == Kernel::Gather { 4 * SURFACE_WORDS * pixels } else { 0 };
        let picture = context.buffer("picture", bytes + surfaces, Usage::STORAGE | Usage::COPY_SRC)?;
        let read_words = PICTURE_WORDS + if layout.has_coverage() { COVERAGE_WORDS } else { 0 };
        let read_bytes = 4 * read_words * pixels / (subpixels * subpixels) as u64;
        let readback = context.buffer("readback", read_bytes, Usage::MAP_READ | Usage::COPY_DST)?;
        let buffers = [&layers[0].keys, &layers[0].sums, &layers[1].keys, &layers[1].sums, &picture];
        let resources = buffers.map(wgpu::Buffer::as_entire_binding);
        let resolve_group = bind(&context.device, &pipelines.resolve_layout, resources);
        Ok(Self { layout, layers, picture, resolve_group, readback })
    }

    /// Whether the kernel blends the samples of a surface.
    pub(super) fn blends(&self) -> bool {
        matches!(self.layout.kernel, Kernel::Block | Kernel::Surfel)
    }

    /// Columns and rows of the picture.
    pub(super) fn picture_size(&self) -> (usize, usize) {
        let TargetLayout { width, height, subpixels, .. } = self.layout;
        (width / subpixels, height / subpixels)
    }

    /// Records a copy of the picture to where the CPU can read it.
    pub(super) fn record_readback(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.copy_buffer_to_buffer(&self.picture, 0, &self.readback, 0, self.readback.size());
    }

    /// Waits for the picture and reads it; the shares of pixels that are shown only if holes were not `filled`.
    pub(super) fn read(&self, context: &Context, filled: bool) -> Result<Picture> {
        read_picture(context, &self.readback, self.picture_size(), self.layout.has_coverage() && !filled)
    }
}

/// Waits for all work and reads a picture from a buffer that the CPU may map.
pub(super) fn read_picture(
    context: &Context,
    buffer: &wgpu::Buffer,
    (width, height): (usize, usize),
    with_coverage: bool,
) -> Result<Picture> {
    let pixels = width * height;
    read_words(context, buffer, |words| {
        let (color, rest) = words.split_at(3 * pixels);
        let (depth, rest) = rest.split_at(pixels);
        let (image, rest) = rest.split_at(pixels);
        let color: &[[f32; 3]] = bytemuck::cast_slice(color);
        Picture {
            color: Grid::from_vec(width, height, color.to_vec()),
            inverse_depth: Grid::from_vec(width, height, bytemuck::cast_slice(depth).to_vec()),
            image: Grid::from_vec(width, height, image.to_vec()),
            fronts: Vec::new(),
            coverage: if with_coverage { bytemuck::cast_slice(&rest[..pixels]).to_vec() } else { Vec::new() },
        }
    })
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
