//! The display stage: a picture that a window shows without its pixels ever leaving the adapter.
//!
//! What differs from reading the picture back and coloring it on the CPU: the window must draw with the same device, see
//! [`SharedDevice`]; and only colors are shown, because other views read the samples of the picture.
//!
//! [`SharedDevice`]: super::context::SharedDevice

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use wgpu::BufferUsages as Usage;

use super::commands::{Commands, TimedPasses};
use super::context::Context;
use super::pipelines::{READ, UNIFORM, WRITE, bind, layout, pipeline};
use super::shaders;
use super::target::{GpuTarget, read_words};
use crate::error::Result;
use crate::render::stage_times::Stage;

/// How holes are displayed that are not filled: stripes of two colors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HolePattern {
    /// 8-bit sRGB of the stripes, the first at the corner.
    pub colors: [[u8; 3]; 2],
    /// Width of a stripe along rows and columns, pixels; at least 1.
    pub stripe: u32,
}

/// A picture on the adapter: sRGB-encoded, opaque, four bytes a pixel. It is written again only after all clones are gone.
pub type ScreenTexture = Arc<wgpu::Texture>;

/// `Display` in `display.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GpuDisplay {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) stripe: u32,
    pub(crate) padding: u32,
    pub(crate) hole: [f32; 4],
    pub(crate) hole_stripe: [f32; 4],
}

/// Threads of a workgroup along each side, as in `display.wgsl`.
const GROUP: usize = 16;

/// The format of the textures: sRGB-encoded, four bytes a pixel.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// The compiled stage, and the textures that it wrote.
#[derive(Debug)]
pub(crate) struct DisplayPass {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
    /// Textures that are no longer shown are written again.
    textures: Vec<ScreenTexture>,
}

impl DisplayPass {
    /// Compiles the stage.
    pub(crate) fn new(context: &Context) -> Self {
        let device = &context.device;
        let texture = wgpu::BindingType::StorageTexture {
            access: wgpu::StorageTextureAccess::WriteOnly,
            format: FORMAT,
            view_dimension: wgpu::TextureViewDimension::D2,
        };
        let layout = layout(device, "display", &[UNIFORM, READ, WRITE, texture]);
        let pipeline = pipeline(device, &shaders::DISPLAY, &[Some(&layout)]);
        Self { layout, pipeline, textures: Vec::new() }
    }

    /// Records the display of `target`'s picture, submits all commands and returns the texture, the number of holes, and
    /// the passes that were timed.
    pub(crate) fn show(
        &mut self,
        context: &Context,
        target: &GpuTarget,
        mut commands: Commands<'_>,
        pattern: &HolePattern,
    ) -> Result<(ScreenTexture, u64, TimedPasses)> {
        let (width, height) = target.picture_size();
        let texture = self.free_texture(context, width, height);
        let color = |[r, g, b]: [u8; 3]| [r, g, b, u8::MAX].map(|channel| f32::from(channel) / 255.0);
        let numbers = GpuDisplay {
            width: width as u32,
            height: height as u32,
            stripe: pattern.stripe.max(1),
            padding: 0,
            hole: color(pattern.colors[0]),
            hole_stripe: color(pattern.colors[1]),
        };
        let numbers = context.written("display", bytemuck::bytes_of(&numbers), Usage::UNIFORM)?;
        let holes = context.buffer("holes", 4, Usage::STORAGE | Usage::COPY_SRC)?;
        let readback = context.buffer("holes readback", 4, Usage::MAP_READ | Usage::COPY_DST)?;
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let resources = [
            numbers.as_entire_binding(),
            target.picture.as_entire_binding(),
            holes.as_entire_binding(),
            wgpu::BindingResource::TextureView(&view),
        ];
        let group = bind(&context.device, &self.layout, resources);
        let mut pass = commands.pass(Stage::Copy, "display");
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &group, &[]);
        let groups = |pixels: usize| pixels.div_ceil(GROUP) as u32;
        pass.dispatch_workgroups(groups(width), groups(height), 1);
        drop(pass);
        commands.encoder.copy_buffer_to_buffer(&holes, 0, &readback, 0, 4);
        let timed = commands.submit(context);
        let holes = read_words(context, &readback, |words| u64::from(words[0]))?;
        Ok((texture, holes, timed))
    }

    /// A texture of this size that is not shown.
    fn free_texture(&mut self, context: &Context, width: usize, height: usize) -> ScreenTexture {
        let (width, height) = (width as u32, height as u32);
        let fits = |texture: &ScreenTexture| (texture.width(), texture.height()) == (width, height);
        self.textures.retain(|texture| fits(texture) || Arc::strong_count(texture) > 1);
        let free = |texture: &&ScreenTexture| fits(texture) && Arc::strong_count(texture) == 1;
        if let Some(texture) = self.textures.iter().find(free) {
            return texture.clone();
        }
        let texture = Arc::new(context.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("display"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::STORAGE_BINDING
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        }));
        self.textures.push(texture.clone());
        texture
    }
}
