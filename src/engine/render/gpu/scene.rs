//! What the stages of one picture read: samples, cameras and numbers.

use std::iter::once;
use std::sync::Arc;

use bytemuck::Pod;

use super::context::Context;
use super::layout::{GpuPiece, GpuProjector, GpuStage, GpuView, MAX_CAMERAS};
use super::memory::{MAX_PAGES, SampleMemory};
use super::pipelines::{Pipelines, bind, first_of};
use super::target::GpuTarget;
use crate::capture::Camera;
use crate::error::{Error, Result};
use crate::render::gather::full_coverage;
use crate::render::geometry::{growth_along, rays_in_world};
use crate::render::input::FrameSamples;
use crate::render::input::focal;
use crate::samples::{SampleImage, TILE};
use crate::settings::{Kernel, RenderSettings};

/// Distance between the stages in their buffer, bytes: the alignment that every adapter takes.
const STAGE_STRIDE: usize = 256;

/// What every stage of a picture binds.
pub(super) struct SceneBindings {
    /// What all stages bind.
    pub(super) group: wgpu::BindGroup,
    /// What the gather stage binds besides, where the kernel gathers.
    pub(super) gather_group: Option<wgpu::BindGroup>,
    /// Tiles of background and foreground.
    pub(super) tile_counts: [u32; 2],
}

/// What is painted.
#[derive(Clone, Copy)]
pub(super) struct SceneInput<'a> {
    pub(super) frame: &'a FrameSamples<'a>,
    /// The vantage's camera, with as many pixels as the z-buffer.
    pub(super) camera: &'a Camera,
    /// Pixels of the z-buffer along each side of a pixel of the picture.
    pub(super) subpixels: usize,
    /// Whether the picture holds the colors that pixels show in front of their farthest surface.
    pub(super) with_fronts: bool,
    pub(super) settings: &'a RenderSettings,
}

impl SceneBindings {
    /// Uploads what the stages read, and binds it.
    pub(super) fn new(
        context: &Context,
        pipelines: &Pipelines,
        memory: &mut SampleMemory,
        target: &GpuTarget,
        input: SceneInput<'_>,
    ) -> Result<Self> {
        let SceneInput { frame, camera, settings, .. } = input;
        let cameras = &frame.set.cameras;
        if settings.kernel == Kernel::Gather && cameras.len() > MAX_CAMERAS {
            let (count, most) = (cameras.len(), MAX_CAMERAS);
            let what = format!("{most} cameras can be gathered from, not {count}; use the CPU instead");
            return Err(Error::Gpu { what });
        }
        let images: Vec<&Arc<SampleImage>> =
            frame.images.iter().map(|index| &frame.set.images[*index]).collect();
        let pieces = pieces(frame, &memory.load(context, &images)?);
        let projectors: Vec<_> = cameras.iter().map(|source| GpuProjector::new(source, camera)).collect();
        let (views, cells) = views(cameras, camera, settings.depth_tolerance);
        let gather_group = if settings.kernel == Kernel::Gather {
            let lookup = lookup(frame, &pieces, &views, cells);
            let views = list(context, "views", &views)?;
            let lookup = list(context, "lookup", &lookup)?;
            let [background, foreground] = &target.layers;
            let buffers = [&background.keys, &foreground.keys, &target.picture, &views, &lookup];
            Some(bind(
                &context.device,
                &pipelines.gather_layout,
                buffers.map(wgpu::Buffer::as_entire_binding),
            ))
        } else {
            None
        };
        let stages = stages(input, pieces.len(), cells);
        let stages = uniform_at(context, "stages", &stages)?;
        let projectors = list(context, "projectors", &projectors)?;
        let pieces = list(context, "pieces", &pieces)?;
        let missing = context.buffer("no page", 4, wgpu::BufferUsages::STORAGE)?;
        let mut buffers = vec![&projectors, &pieces];
        buffers.extend(memory.pages().chain(std::iter::repeat(&missing)).take(MAX_PAGES));
        let resources = once(first_of::<GpuStage>(&stages))
            .chain(buffers.into_iter().map(wgpu::Buffer::as_entire_binding));
        let group = bind(&context.device, &pipelines.scene_layout, resources);
        let tile_counts =
            [frame.background_tiles(), frame.foreground_tiles()].map(|tiles| tiles.len() as u32);
        Ok(Self { group, gather_group, tile_counts })
    }

    /// Where the stage of a layer begins, for the first or the second pass over its samples.
    pub(super) fn stage_offset(layer: usize, step: usize) -> u32 {
        numbers_at(2 * layer + step)
    }
}

/// The stages of both layers, for both passes.
fn stages(input: SceneInput<'_>, piece_count: usize, cells: usize) -> Vec<GpuStage> {
    let SceneInput { frame, camera, subpixels, with_fronts, settings } = input;
    let (width, height) = camera.intrinsics.size();
    let [first_ray, ray_across, ray_down] = rays_in_world(camera, 0.5).map(|ray| ray.to_array());
    let mut stages = Vec::new();
    for tiles in [frame.background_tiles(), frame.foreground_tiles()] {
        for step in 0..2 {
            stages.push(GpuStage {
                width: width as u32,
                height: height as u32,
                kernel: settings.kernel as u32,
                step,
                first_tile: tiles.start as u32,
                tile_count: tiles.len() as u32,
                piece_count: piece_count as u32,
                surface_ratio: 1.0 / (1.0 + settings.depth_tolerance / focal(camera)),
                first_ray,
                background_tiles: frame.background_tile_count as u32,
                ray_across,
                entries_at: cells as u32,
                ray_down,
                all_tiles: frame.tile_count() as u32,
                pruned: u32::from(frame.is_pruned()),
                subpixels: subpixels as u32,
                with_fronts: u32::from(with_fronts),
                full_coverage: full_coverage(frame.is_pruned(), settings),
            });
        }
    }
    stages
}

/// The cameras for the gather stage, and the number of their cells.
fn views(cameras: &[Camera], target: &Camera, depth_tolerance: f32) -> (Vec<GpuView>, usize) {
    let (center, rays) = (target.position_in_world(), rays_in_world(target, 0.5));
    let mut cells = 0;
    let views = cameras.iter().map(|source| {
        let (width, height) = source.intrinsics.size();
        let across = width.div_ceil(TILE);
        let offset_in_world = (center - source.position_in_world()).as_vec3();
        let view = GpuView {
            source_from_target: GpuProjector::new(target, source),
            offset_in_world: offset_in_world.to_array(),
            tolerance: depth_tolerance / focal(source),
            width: width as i32,
            height: height as i32,
            cells_across: across as u32,
            first_cell: cells as u32,
            growth_along_offset: growth_along(rays, offset_in_world).to_array(),
            padding_0: 0,
        };
        cells += across * height.div_ceil(TILE);
        view
    });
    (views.collect(), cells)
}

/// Cells and entries, as drawn in `lookup.wgsl`.
fn lookup(frame: &FrameSamples<'_>, pieces: &[GpuPiece], views: &[GpuView], cells: usize) -> Vec<u32> {
    let mut lookup = vec![u32::MAX; cells + 2 * frame.tile_count()];
    let mut piece = pieces.len();
    // Backwards, so that lists ascend.
    for number in (0..frame.tile_count()).rev() {
        while piece == pieces.len() || pieces[piece].first_tile as usize > number {
            piece -= 1;
        }
        let tile = frame.tile(number);
        let view = &views[tile.camera as usize];
        let (column, row) = (tile.origin.0 / TILE as u32, tile.origin.1 / TILE as u32);
        let cell = (view.first_cell + row * view.cells_across + column) as usize;
        let entry = cells + 2 * number;
        lookup[entry] = piece as u32;
        lookup[entry + 1] = lookup[cell];
        lookup[cell] = number as u32;
    }
    lookup
}

/// A buffer with these entries; with one of zeros if there are none, because shaders cannot bind an empty buffer.
pub(super) fn list<T: Pod>(context: &Context, label: &str, entries: &[T]) -> Result<wgpu::Buffer> {
    let none = [T::zeroed()];
    let entries = if entries.is_empty() { &none } else { entries };
    context.written(label, bytemuck::cast_slice(entries), wgpu::BufferUsages::STORAGE)
}

/// Where a set of numbers begins in what [`uniform_at`] made, bytes.
pub(super) fn numbers_at(nth: usize) -> u32 {
    (nth * STAGE_STRIDE) as u32
}

/// A buffer with these sets of numbers, each where [`numbers_at`] says.
pub(super) fn uniform_at<T: Pod>(context: &Context, label: &str, entries: &[T]) -> Result<wgpu::Buffer> {
    let mut bytes = Vec::with_capacity(entries.len() * STAGE_STRIDE);
    for entry in entries {
        bytes.extend_from_slice(bytemuck::bytes_of(entry));
        bytes.resize(bytes.len().next_multiple_of(STAGE_STRIDE), 0);
    }
    context.written(label, &bytes, wgpu::BufferUsages::UNIFORM)
}

/// The pieces of a frame's images, in the order of the frame's tiles.
fn pieces(frame: &FrameSamples<'_>, placed: &[Vec<GpuPiece>]) -> Vec<GpuPiece> {
    let mut pieces = Vec::new();
    let mut first_tile = 0;
    for (&index, placed) in frame.images.iter().zip(placed) {
        let image = &frame.set.images[index];
        pieces.extend(placed.iter().map(|piece| GpuPiece {
            first_tile: first_tile + piece.first_tile,
            camera: image.camera,
            image: index as u32,
            ..*piece
        }));
        first_tile += image.tiles.len() as u32;
    }
    pieces
}
