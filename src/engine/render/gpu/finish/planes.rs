//! What the stages that finish a picture work on.

use super::painted::Painted;
use crate::error::Result;
use crate::render::geometry::rays_in_world;
use crate::render::gpu::context::Context;
use crate::render::gpu::layout::{GpuCellView, GpuFinish};
use crate::render::gpu::pipelines::{bind, first_of};
use crate::render::gpu::scene::{list, numbers_at, uniform_at};
use crate::render::input::focal;
use bytemuck::Zeroable;
use wgpu::BufferUsages as Usage;

/// Counts that the stages share, as in `finish.wgsl`.
const COUNTS: u64 = 6;

/// Columns and rows of a square of surroundings, as in `surroundings.wgsl`.
const SQUARE: usize = 16;

/// Pixels in a word of a mask.
const MASK_BITS: usize = 32;

/// Words of a cell of the pyramid, as in `pyramid.wgsl`.
const CELL_WORDS: u64 = 5;

/// Words behind the masks for each pixel, as in `fillings.wgsl`: the share of the sky, and sums.
const FILLING_WORDS: u64 = 7;

/// Steps for which there are numbers even in the smallest picture.
pub(super) const LEAST_STEPS: usize = 3;

/// Sets of sources that are kept side by side, each with masks and a pyramid of its own: everything that is painted, and surfaces alone.
pub(super) const SETS: u64 = 2;

/// What the planes are made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FinishLayout {
    /// Columns and rows of the picture.
    pub(super) width: usize,
    pub(super) height: usize,
    /// Whether lines of sight are tested, and whether holes are filled.
    pub(super) tests_lines: bool,
    pub(super) fills: bool,
    /// Whether the picture tells which shares of pixels are shown.
    pub(super) has_coverage: bool,
}

impl FinishLayout {
    /// Words of the planes for each pixel, as in `finish.wgsl`.
    fn plane_words(&self) -> u64 {
        if self.has_coverage { 6 } else { 3 }
    }

    /// Words of the masks of a set of sources: see `hole_rays.wgsl`.
    pub(super) fn mask_words(&self) -> u64 {
        let Self { width, height, .. } = *self;
        let bands = height.div_ceil(MASK_BITS);
        (height * width.div_ceil(MASK_BITS) + bands * width + 2 * bands * (width + height - 1)) as u64
    }

    /// Words of the masks of all sets, and of what fills holes behind them.
    fn mask_buffer_words(&self) -> u64 {
        SETS * self.mask_words() + FILLING_WORDS * (self.width * self.height) as u64
    }

    /// Columns and rows of the levels of the pyramid, the finest first.
    pub(super) fn levels(&self) -> Vec<(usize, usize)> {
        let half = |size: (usize, usize)| (size.0.div_ceil(2), size.1.div_ceil(2));
        let mut levels = vec![half((self.width, self.height))];
        while let Some(&last) = levels.last()
            && last != (1, 1)
        {
            levels.push(half(last));
        }
        levels
    }
}

/// The buffers.
#[derive(Debug)]
pub(super) struct FinishPlanes {
    pub(super) layout: FinishLayout,
    pub(super) counts: wgpu::Buffer,
    planes: wgpu::Buffer,
    squares: wgpu::Buffer,
    masks: wgpu::Buffer,
    pyramid: wgpu::Buffer,
    /// Stands for what is not read.
    nothing: wgpu::Buffer,
}

impl FinishPlanes {
    pub(super) fn new(context: &Context, layout: FinishLayout) -> Result<Self> {
        let FinishLayout { width, height, tests_lines, fills, has_coverage } = layout;
        let if_wanted = |wanted: bool, bytes: u64| if wanted { bytes } else { 0 };
        let squares = (width.div_ceil(SQUARE) * height.div_ceil(SQUARE)) as u64;
        let cells: u64 = layout.levels().iter().map(|level| (level.0 * level.1) as u64).sum();
        let buffer = |label: &str, bytes: u64| context.buffer(label, bytes.max(16), Usage::STORAGE);
        Ok(Self {
            layout,
            counts: context.buffer("counts", 4 * COUNTS, Usage::STORAGE | Usage::COPY_DST)?,
            planes: buffer(
                "marks",
                if_wanted(tests_lines || has_coverage, 4 * layout.plane_words() * (width * height) as u64),
            )?,
            squares: buffer("surroundings", if_wanted(tests_lines, 16 * squares))?,
            masks: buffer("masks", if_wanted(fills, 4 * layout.mask_buffer_words()))?,
            pyramid: buffer("pyramid", if_wanted(fills, 4 * SETS * CELL_WORDS * cells))?,
            nothing: buffer("nothing", size_of::<GpuCellView>() as u64)?,
        })
    }

    /// Binds everything, with free depths and environment where lines of sight are tested.
    pub(super) fn bind(
        &self,
        context: &Context,
        bindings: &wgpu::BindGroupLayout,
        painted: Painted<'_>,
        views: &[GpuCellView],
        known: Option<(Option<&wgpu::Buffer>, Option<&wgpu::Buffer>)>,
    ) -> Result<wgpu::BindGroup> {
        let numbers = uniform_at(context, "finish", &self.numbers(painted, views.len()))?;
        let views = list(context, "asked cameras", views)?;
        let (free, environment) = known.unwrap_or((None, None));
        let buffers = [
            &painted.target.picture,
            &self.counts,
            &self.planes,
            &self.squares,
            &views,
            environment.unwrap_or(&self.nothing),
            free.unwrap_or(&self.nothing),
            &self.masks,
            &self.pyramid,
        ];
        let numbers = std::iter::once(first_of::<GpuFinish>(&numbers));
        let resources = numbers.chain(buffers.into_iter().map(wgpu::Buffer::as_entire_binding));
        Ok(bind(&context.device, bindings, resources))
    }

    /// The numbers of all steps.
    fn numbers(&self, painted: Painted<'_>, view_count: usize) -> Vec<GpuFinish> {
        let Painted { camera, settings, target, .. } = painted;
        let [first_ray, ray_across, ray_down] = rays_in_world(camera, 0.5).map(|ray| ray.to_array());
        let of_step = |step: usize| GpuFinish {
            width: self.layout.width as u32,
            height: self.layout.height as u32,
            step: step as u32,
            view_count: view_count as u32,
            first_ray,
            footprints: settings.depth_tolerance,
            ray_across,
            focal: focal(camera),
            ray_down,
            with_fronts: u32::from(target.layout.with_fronts),
            tests_lines: u32::from(self.layout.tests_lines),
            with_coverage: u32::from(self.layout.has_coverage),
            ..GpuFinish::zeroed()
        };
        (0..self.layout.levels().len().max(LEAST_STEPS)).map(of_step).collect()
    }

    /// Where the numbers of a step begin.
    pub(super) fn at_step(step: usize) -> [u32; 1] {
        [numbers_at(step)]
    }
}
