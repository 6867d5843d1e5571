//! The compiled stages and the shape of what they bind.
//!
//! ```text
//! group 0, the same for all   0 stage (one of several, by offset)   1 projectors   2 pieces   3 to 6 pages
//! group 1, surface and blend  0 keys   1 sums
//! group 1, resolve            0 and 1 background's keys and sums   2 and 3 the foreground's   4 picture
//! group 1, silhouette, gather 0 background's keys   1 the foreground's   2 picture   3 views   4 lookup
//! group 1, carry              0 views   1 projectors into their cells   2 nearest surfaces in the cells
//! group 1, free depths        0 views   1 nearest surfaces in the cells   2 free depths
//! group 1, sum sky            0 rays of cameras   1 sums
//! group 0, other sky stages   0 level (one of several, by offset)   1 sums   2 grids   3 environment
//! group 1, finish             0 numbers (one set of several, by offset)   1 picture   2 counts   3 planes   4 squares
//!                             5 views   6 environment   7 free depths   8 masks   9 pyramid
//! ```

use super::context::Context;
use super::shaders::{self, Shader};

/// The compiled stages.
#[derive(Debug)]
pub(super) struct Pipelines {
    pub(super) scene_layout: wgpu::BindGroupLayout,
    pub(super) layer_layout: wgpu::BindGroupLayout,
    pub(super) resolve_layout: wgpu::BindGroupLayout,
    pub(super) gather_layout: wgpu::BindGroupLayout,
    pub(super) surface: wgpu::ComputePipeline,
    pub(super) blend: wgpu::ComputePipeline,
    pub(super) resolve: wgpu::ComputePipeline,
    pub(super) silhouette: wgpu::ComputePipeline,
    pub(super) gather: wgpu::ComputePipeline,
    /// Whether `surface` raises keys with one 64-bit maximum; else it has to run twice.
    pub(super) one_pass: bool,
}

const fn buffer(ty: wgpu::BufferBindingType, has_dynamic_offset: bool) -> wgpu::BindingType {
    wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: None }
}

/// Numbers, one set of several in a buffer, by offset.
pub(super) const UNIFORM_AT: wgpu::BindingType = buffer(wgpu::BufferBindingType::Uniform, true);
pub(super) const UNIFORM: wgpu::BindingType = buffer(wgpu::BufferBindingType::Uniform, false);
pub(super) const READ: wgpu::BindingType =
    buffer(wgpu::BufferBindingType::Storage { read_only: true }, false);
pub(super) const WRITE: wgpu::BindingType =
    buffer(wgpu::BufferBindingType::Storage { read_only: false }, false);

/// The layout of a group of bindings, numbered from 0.
pub(super) fn layout(
    device: &wgpu::Device,
    label: &str,
    bindings: &[wgpu::BindingType],
) -> wgpu::BindGroupLayout {
    let entry = |(binding, ty): (usize, &wgpu::BindingType)| wgpu::BindGroupLayoutEntry {
        binding: binding as u32,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: *ty,
        count: None,
    };
    let entries: Vec<_> = bindings.iter().enumerate().map(entry).collect();
    device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}

/// Compiles a shader that binds `groups`.
pub(super) fn pipeline(
    device: &wgpu::Device,
    shader: &Shader,
    groups: &[Option<&wgpu::BindGroupLayout>],
) -> wgpu::ComputePipeline {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(shader.entry),
        source: wgpu::ShaderSource::Wgsl(shader.source().into()),
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(shader.entry),
        bind_group_layouts: groups,
        immediate_size: 0,
    });
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(shader.entry),
        layout: Some(&layout),
        module: &module,
        entry_point: Some(shader.entry),
        // Threads write all they read of what a workgroup shares.
        compilation_options: wgpu::PipelineCompilationOptions {
            zero_initialize_workgroup_memory: false,
            ..Default::default()
        },
        cache: None,
    })
}

impl Pipelines {
    /// Compiles the stages; `one_pass` needs 64-bit atomics.
    pub(super) fn new(context: &Context, one_pass: bool) -> Self {
        let device = &context.device;
        let scene_layout = layout(device, "scene", &[UNIFORM_AT, READ, READ, READ, READ, READ, READ]);
        let layer_layout = layout(device, "layer", &[WRITE, WRITE]);
        let resolve_layout = layout(device, "resolve", &[READ, READ, READ, READ, WRITE]);
        let gather_layout = layout(device, "gather", &[READ, READ, WRITE, READ, READ]);
        let surface = if one_pass { shaders::SURFACE_64 } else { shaders::SURFACE_32 };
        let over_layer = [Some(&scene_layout), Some(&layer_layout)];
        let over_views = [Some(&scene_layout), Some(&gather_layout)];
        Self {
            surface: pipeline(device, &surface, &over_layer),
            blend: pipeline(device, &shaders::BLEND, &over_layer),
            resolve: pipeline(device, &shaders::RESOLVE, &[Some(&scene_layout), Some(&resolve_layout)]),
            silhouette: pipeline(device, &shaders::SILHOUETTE, &over_views),
            gather: pipeline(device, &shaders::GATHER, &over_views),
            scene_layout,
            layer_layout,
            resolve_layout,
            gather_layout,
            one_pass,
        }
    }
}

/// What is bound as [`UNIFORM_AT`]: the first entry of type `T`.
pub(super) fn first_of<T>(buffer: &wgpu::Buffer) -> wgpu::BindingResource<'_> {
    let size = std::num::NonZeroU64::new(size_of::<T>() as u64);
    wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: 0, size })
}

/// A bind group of these resources, numbered from 0.
pub(super) fn bind<'a>(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    resources: impl IntoIterator<Item = wgpu::BindingResource<'a>>,
) -> wgpu::BindGroup {
    let entry = |(binding, resource): (usize, _)| wgpu::BindGroupEntry { binding: binding as u32, resource };
    let entries: Vec<_> = resources.into_iter().enumerate().map(entry).collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}
