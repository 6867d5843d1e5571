//! The GPU renderer: the stages of the CPU renderer under the same names, in `shaders/*.wgsl`.
//!
//! ```text
//! SampleSet ─ upload, once an image ─▶ pages ─ surface ─▶ keys ─ blend ─▶ sums    of the background, kept while the vantage is still
//!                                            ─ surface ─▶ keys ─ blend ─▶ sums    of the frame   ── compose ─▶ picture ─▶ CPU
//! ```
//!
//! What differs from the CPU renderer: one thread a sample instead of one a band of rows, so keys are raised and colors are
//! summed by atomics, colors in fixed point. Neither result depends on the order of the threads. Shader compilers may contract
//! sums and divide by other means than the CPU does: a sample's position and depth may differ in the last bits, and where it
//! stood on the border of a pixel, so may the pixel. `tests/gpu_parity.rs` says how much of that is let pass.

mod clock;
mod context;
mod layout;
mod memory;
mod pipelines;
mod shaders;
mod target;
mod upload;

use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

pub use context::AdapterChoice;

use super::cpu::check;
use super::frame_samples::FrameSamples;
use super::project::focal;
use super::vantage::{Picture, RenderStats, Vantage};
use crate::capture::Camera;
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::{SampleImage, SampleSet};
use crate::settings::{Kernel, RenderSettings};
use clock::StageClock;
use context::Context;
use layout::{GROUPS_ACROSS, GpuPiece, GpuProjector, GpuStage, kernel_number};
use memory::{MAX_PAGES, SampleMemory};
use pipelines::{Pipelines, bind};
use target::Target;

/// Distance between the stages in their buffer: the alignment that every adapter takes.
const STAGE_STRIDE: u64 = 256;

/// How a [`GpuRenderer`] is set up.
#[derive(Clone, Copy, Debug)]
pub struct GpuOptions {
    /// Which adapters may be taken.
    pub adapter: AdapterChoice,
    /// Whether 64-bit atomics are used where the adapter has them; without, the surface stage runs twice.
    pub wide_atomics: bool,
    /// Memory for samples at most, bytes.
    pub sample_bytes: u64,
}

impl Default for GpuOptions {
    fn default() -> Self {
        Self { adapter: AdapterChoice::Any, wide_atomics: true, sample_bytes: 2 << 30 }
    }
}

/// Renders vantages on a graphics adapter, and keeps samples there as well as the background of a still vantage.
#[derive(Debug)]
pub struct GpuRenderer {
    context: Context,
    pipelines: Pipelines,
    memory: SampleMemory,
    target: Option<Target>,
    background: Option<Background>,
    clock: StageClock,
}

/// What the background layer of the target was painted from.
#[derive(Debug)]
struct Background {
    samples: Arc<SampleSet>,
    images: Vec<usize>,
    camera: Camera,
    settings: RenderSettings,
}

impl Background {
    fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.samples, &other.samples)
            && self.images == other.images
            && self.camera == other.camera
            && self.settings == other.settings
    }
}

impl GpuRenderer {
    /// Opens the best adapter of a choice.
    ///
    /// # Errors
    /// `Gpu` where there is none.
    pub fn new(adapter: AdapterChoice) -> Result<Self> {
        Self::with_options(&GpuOptions { adapter, ..GpuOptions::default() })
    }

    /// Opens an adapter.
    ///
    /// # Errors
    /// `Gpu` where there is none.
    pub fn with_options(options: &GpuOptions) -> Result<Self> {
        let context = Context::new(options.adapter)?;
        let one_pass = options.wide_atomics && context.has_wide_atomics;
        let (pipelines, clock) =
            context.guarded(|| Ok((Pipelines::new(&context, one_pass), StageClock::new(&context)?)))?;
        let memory = SampleMemory::new(&context, options.sample_bytes);
        Ok(Self { context, pipelines, memory, target: None, background: None, clock })
    }

    /// The adapter's name.
    #[must_use]
    pub fn adapter_name(&self) -> &str {
        &self.context.adapter.name
    }

    /// Whether the adapter is a program that runs on the processor.
    #[must_use]
    pub fn is_software(&self) -> bool {
        self.context.is_software()
    }

    /// Whether keys are raised by one 64-bit maximum instead of two 32-bit ones.
    #[must_use]
    pub fn has_wide_atomics(&self) -> bool {
        self.pipelines.one_pass
    }

    /// Stages of the last picture, in order, with their milliseconds; empty where the adapter has no clock.
    #[must_use]
    pub fn stage_milliseconds(&self) -> &[(&'static str, f64)] {
        self.clock.milliseconds()
    }

    /// Bytes of samples sent to the adapter so far.
    #[must_use]
    pub fn uploaded_bytes(&self) -> u64 {
        self.memory.uploaded
    }

    /// Drops the background, so that the next picture is painted anew.
    pub fn forget_background(&mut self) {
        self.background = None;
    }

    /// Whether the adapter was lost: every further call fails.
    #[must_use]
    pub fn is_lost(&self) -> bool {
        self.context.is_lost()
    }

    /// Has the adapter go away, as unplugging it would.
    #[cfg(test)]
    pub(super) fn lose(&self) {
        self.context.device.destroy();
    }

    /// Sends the images of some frames ahead, as far as there is room.
    ///
    /// # Errors
    /// `Gpu` where the adapter fails.
    pub fn prefetch(&mut self, samples: &SampleSet, frames: Range<usize>) -> Result<()> {
        let images: Vec<_> = samples
            .images
            .iter()
            .filter(|image| frames.clone().any(|frame| image.span.contains(frame)))
            .collect();
        let (context, memory) = (&self.context, &mut self.memory);
        context.guarded(|| memory.prefetch(context, &images))
    }

    /// Paints the samples of the vantage's frame.
    ///
    /// # Errors
    /// `Cancelled`; `Invalid` as the CPU renderer; `Gpu` where the picture or the samples are more than the adapter takes, or
    /// it fails. Where it was lost, every later call fails too.
    pub fn render(
        &mut self,
        samples: &Arc<SampleSet>,
        vantage: &Vantage,
        settings: &RenderSettings,
        job: &Job,
    ) -> Result<(Picture, RenderStats)> {
        let started = Instant::now();
        check(samples, vantage)?;
        job.check()?;
        let frame = FrameSamples::at(samples, vantage.frame)?;
        let wanted = Background {
            samples: samples.clone(),
            images: frame.images[..frame.lasting_images].to_vec(),
            camera: vantage.camera.clone(),
            settings: settings.clone(),
        };
        let reused = self.background.take().filter(|background| background.is(&wanted)).is_some();
        let picture = self.paint(&frame, &vantage.camera, settings, reused, job)?;
        self.background = Some(wanted);
        let tiles = if reused { frame.passing() } else { 0..frame.tiles.len() };
        let stats = RenderStats {
            samples: frame.sample_count(tiles),
            holes: picture.holes(),
            milliseconds: started.elapsed().as_secs_f64() * 1e3,
            background_reused: reused,
        };
        Ok((picture, stats))
    }

    fn paint(
        &mut self,
        frame: &FrameSamples<'_>,
        camera: &Camera,
        settings: &RenderSettings,
        background_is_painted: bool,
        job: &Job,
    ) -> Result<Picture> {
        let Self { context, pipelines, memory, target, clock, .. } = self;
        let context = &*context;
        context.guarded(|| {
            let target = target_for(target, context, pipelines, camera, settings)?;
            let scene = Scene::new(context, pipelines, memory, (frame, camera, settings))?;
            job.check()?;
            clock.start();
            let mut encoder =
                context.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let mut recorder = Recorder { pipelines, scene: &scene, target, clock, encoder: &mut encoder };
            if !background_is_painted {
                recorder.paint(0, &["background surface", "background blend"]);
            }
            recorder.paint(1, &["surface", "blend"]);
            recorder.compose();
            clock.record_readback(&mut encoder);
            target.record_readback(&mut encoder);
            context.queue.submit([encoder.finish()]);
            let picture = target.read(context)?;
            clock.read(context)?;
            Ok(picture)
        })
    }
}

/// Buffers of the right size: the ones there are, or others.
fn target_for<'a>(
    target: &'a mut Option<Target>,
    context: &Context,
    pipelines: &Pipelines,
    camera: &Camera,
    settings: &RenderSettings,
) -> Result<&'a Target> {
    let size = camera.intrinsics.size();
    let blends = matches!(settings.kernel, Kernel::Block | Kernel::Surfel);
    let fits = |target: &Target| (target.width, target.height) == size && target.blends == blends;
    let found = match target.take().filter(fits) {
        Some(found) => found,
        None => Target::new(context, pipelines, size, blends)?,
    };
    Ok(target.insert(found))
}

/// What every stage of a picture binds.
struct Scene {
    group: wgpu::BindGroup,
    /// Tiles of background and foreground.
    tile_counts: [u32; 2],
}

impl Scene {
    fn new(
        context: &Context,
        pipelines: &Pipelines,
        memory: &mut SampleMemory,
        (frame, camera, settings): (&FrameSamples<'_>, &Camera, &RenderSettings),
    ) -> Result<Self> {
        let images: Vec<&Arc<SampleImage>> =
            frame.images.iter().map(|index| &frame.set.images[*index]).collect();
        let pieces = pieces(frame, &memory.load(context, &images)?);
        let projectors: Vec<_> =
            frame.set.cameras.iter().map(|source| GpuProjector::new(source, camera)).collect();
        let surface_ratio = 1.0 / (1.0 + settings.depth_tolerance / focal(camera));
        let (width, height) = camera.intrinsics.size();
        let layers = [frame.lasting(), frame.passing()];
        let mut stages = Vec::new();
        for (index, tiles) in layers.iter().flat_map(|tiles| [(0, tiles), (1, tiles)]) {
            let stage = GpuStage {
                width: width as u32,
                height: height as u32,
                kernel: kernel_number(settings.kernel),
                step: index,
                first_tile: tiles.start as u32,
                tile_count: tiles.len() as u32,
                piece_count: pieces.len() as u32,
                surface_ratio,
            };
            stages.extend_from_slice(bytemuck::bytes_of(&stage));
            stages.resize(stages.len().next_multiple_of(STAGE_STRIDE as usize), 0);
        }
        let stage = written(context, "stage", &stages, wgpu::BufferUsages::UNIFORM)?;
        let storage = wgpu::BufferUsages::STORAGE;
        let projectors = written(context, "projectors", bytemuck::cast_slice(&projectors), storage)?;
        let pieces = written(context, "pieces", bytemuck::cast_slice(&pieces), storage)?;
        let missing = context.buffer("no page", 4, storage)?;
        let mut buffers = vec![&projectors, &pieces];
        buffers.extend(memory.pages().chain(std::iter::repeat(&missing)).take(MAX_PAGES));
        let group = bind(&context.device, &pipelines.scene_layout, Some(&stage), &buffers);
        Ok(Self { group, tile_counts: layers.map(|tiles| tiles.len() as u32) })
    }

    /// Where the stage of a layer begins, for the first or the second pass over its samples.
    fn stage_offset(layer: usize, step: usize) -> u32 {
        (2 * layer + step) as u32 * STAGE_STRIDE as u32
    }
}

/// A buffer with these bytes.
fn written(context: &Context, label: &str, bytes: &[u8], usage: wgpu::BufferUsages) -> Result<wgpu::Buffer> {
    let buffer = context.buffer(label, bytes.len() as u64, usage | wgpu::BufferUsages::COPY_DST)?;
    context.queue.write_buffer(&buffer, 0, bytes);
    Ok(buffer)
}

/// The pieces of a frame's images, in the order of the frame's tiles.
fn pieces(frame: &FrameSamples<'_>, placed: &[Vec<upload::PlacedPiece>]) -> Vec<GpuPiece> {
    let mut pieces = Vec::new();
    let mut first_tile = 0;
    for (&index, placed) in frame.images.iter().zip(placed) {
        let image = &frame.set.images[index];
        pieces.extend(placed.iter().map(|piece| GpuPiece {
            first_tile: first_tile + piece.first_tile,
            camera: image.camera,
            image: index as u32,
            page: piece.page,
            tiles_at: piece.at,
            low_at: piece.low_at,
            high_at: piece.high_at,
            color_at: piece.color_at,
        }));
        first_tile += image.tiles.len() as u32;
    }
    pieces
}

/// Writes the stages of one picture down, in the order in which they run.
struct Recorder<'a> {
    pipelines: &'a Pipelines,
    scene: &'a Scene,
    target: &'a Target,
    clock: &'a mut StageClock,
    encoder: &'a mut wgpu::CommandEncoder,
}

impl Recorder<'_> {
    /// Paints a layer: surface, then blend where the kernel blends.
    fn paint(&mut self, layer: usize, names: &[&'static str; 2]) {
        let buffers = &self.target.layers[layer];
        self.encoder.clear_buffer(&buffers.keys, 0, None);
        let tiles = self.scene.tile_counts[layer];
        let mut pass = self.clock.pass(self.encoder, names[0]);
        pass.set_pipeline(&self.pipelines.surface);
        pass.set_bind_group(1, &buffers.group, &[]);
        for step in 0..if self.pipelines.one_pass { 1 } else { 2 } {
            pass.set_bind_group(0, &self.scene.group, &[Scene::stage_offset(layer, step)]);
            dispatch(&mut pass, tiles);
        }
        drop(pass);
        if self.target.blends {
            self.encoder.clear_buffer(&buffers.sums, 0, None);
            let mut pass = self.clock.pass(self.encoder, names[1]);
            pass.set_pipeline(&self.pipelines.blend);
            pass.set_bind_group(0, &self.scene.group, &[Scene::stage_offset(layer, 0)]);
            pass.set_bind_group(1, &buffers.group, &[]);
            dispatch(&mut pass, tiles);
        }
    }

    fn compose(&mut self) {
        let mut pass = self.clock.pass(self.encoder, "compose");
        pass.set_pipeline(&self.pipelines.compose);
        pass.set_bind_group(0, &self.scene.group, &[Scene::stage_offset(0, 0)]);
        pass.set_bind_group(1, &self.target.compose_group, &[]);
        dispatch(&mut pass, self.target.pixels().div_ceil(256) as u32);
    }
}

/// Starts so many workgroups, in rows that one dimension can hold.
fn dispatch(pass: &mut wgpu::ComputePass<'_>, groups: u32) {
    if groups > 0 {
        pass.dispatch_workgroups(groups.min(GROUPS_ACROSS), groups.div_ceil(GROUPS_ACROSS), 1);
    }
}
