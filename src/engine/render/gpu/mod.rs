//! The GPU renderer: the stages of the CPU renderer under the same names, in `shaders/*.wgsl`.
//!
//! ```text
//! SampleSet ─ upload, once an image ─▶ pages ─ surface ─▶ keys ─ blend ─▶ sums    of the background, kept while the vantage is still
//!                                            ─ surface ─▶ keys ─ blend ─▶ sums    of the frame
//!                                                                                  both   ─ resolve or gather ─ finish ─▶ picture ─▶ CPU
//!                                                                                                                         └─ display ─▶ window
//! ```
//!
//! What differs from the CPU renderer: one thread a sample instead of one a band of rows, so keys are raised and colors are
//! summed by atomics, colors in fixed point. Neither result depends on the order of the threads. Shader compilers may contract
//! sums and divide in other ways than the CPU: a sample's position and depth may differ in the last bits, and so may the pixel
//! of a sample on the border of two. `tests/render/gpu_parity.rs` holds the limits.

mod average;
mod commands;
mod context;
mod display;
mod finish;
mod layout;
mod memory;
mod pipelines;
mod scene;
mod shaders;
mod target;
mod upload;

pub use context::{AdapterChoice, SharedDevice, device_descriptor};
pub use display::{HolePattern, ScreenTexture};

use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use super::finish::wants_fronts;
use super::input::{BackgroundKey, FrameSamples};
use super::supersample::{finer, subpixels};
use super::vantage::{Picture, RenderStats, Vantage};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::samples::SampleSet;
use crate::settings::{Fill, RenderSettings};
use average::AveragePass;
use commands::{Commands, Recorder, Stopwatch, TimedPasses};
use context::Context;
use display::DisplayPass;
use finish::{CardFinisher, Painted};
use layout::{COVERAGE_WORDS, FRONT_WORDS, PICTURE_WORDS, SURFACE_WORDS};
use memory::SampleMemory;
use pipelines::Pipelines;
use scene::{SceneBindings, SceneInput};
use target::{GpuTarget, TargetLayout, read_picture};

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
    pub(super) context: Context,
    pipelines: Pipelines,
    memory: SampleMemory,
    target: Option<GpuTarget>,
    /// What the background layer of `target` was painted from.
    background: Option<BackgroundKey>,
    display: Option<DisplayPass>,
    average: Option<AveragePass>,
    finisher: CardFinisher,
    /// Tells how long stages take, where the adapter can.
    stopwatch: Option<Stopwatch>,
}

impl GpuRenderer {
    /// Opens the best adapter of a choice.
    ///
    /// # Errors
    /// `Gpu` if there is no adapter.
    pub fn new(adapter: AdapterChoice) -> Result<Self> {
        Self::with_options(&GpuOptions { adapter, ..GpuOptions::default() })
    }

    /// Opens an adapter.
    ///
    /// # Errors
    /// `Gpu` if there is no adapter.
    pub fn with_options(options: &GpuOptions) -> Result<Self> {
        Self::on(Context::new(options.adapter)?, options)
    }

    /// Shares the device of a window, for [`GpuRenderer::show`].
    ///
    /// # Errors
    /// `Gpu` where `options` exclude its adapter, or it was not opened with [`device_descriptor`].
    pub fn sharing(shared: &SharedDevice, options: &GpuOptions) -> Result<Self> {
        Self::on(Context::share(shared, options.adapter)?, options)
    }

    fn on(context: Context, options: &GpuOptions) -> Result<Self> {
        let one_pass = options.wide_atomics && context.has_wide_atomics;
        let (pipelines, finisher, stopwatch) = context.guarded(|| {
            let pipelines = Pipelines::new(&context, one_pass);
            let finisher = CardFinisher::new(&context, &pipelines);
            Ok((pipelines, finisher, Stopwatch::new(&context)?))
        })?;
        let memory = SampleMemory::new(&context, options.sample_bytes);
        Ok(Self {
            context,
            pipelines,
            memory,
            target: None,
            background: None,
            display: None,
            average: None,
            finisher,
            stopwatch,
        })
    }

    /// The adapter's name.
    #[must_use]
    pub fn adapter_name(&self) -> &str {
        &self.context.adapter.name
    }

    /// Whether keys are raised by one 64-bit maximum instead of two 32-bit ones.
    #[must_use]
    pub fn has_wide_atomics(&self) -> bool {
        self.pipelines.one_pass
    }

    /// Bytes of samples uploaded so far.
    #[must_use]
    pub fn uploaded_bytes(&self) -> u64 {
        self.memory.uploaded
    }

    /// Drops the background, so that the next picture is painted in full.
    pub fn forget_background(&mut self) {
        self.background = None;
    }

    /// Uploads the images of some frames ahead, as far as there is space.
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
        context.guarded(|| memory.prefetch(context, &images)).inspect_err(|_| self.memory.forget())
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
    ) -> Result<(Arc<Picture>, RenderStats)> {
        let started = Instant::now();
        let (picture, stats) =
            self.paint(samples, vantage, settings, job, |context, target, mut commands| {
                target.record_readback(&mut commands.encoder);
                let timed = commands.submit(context);
                Ok((target.read(context, settings.fill != Fill::None)?, timed))
            })?;
        let (holes, milliseconds) = (picture.holes(), started.elapsed().as_secs_f64() * 1e3);
        Ok((Arc::new(picture), RenderStats { holes, milliseconds, ..stats }))
    }

    /// Paints as [`GpuRenderer::render`] from the camera of a vantage with `factor` times as many columns and rows, and averages
    /// squares of `factor` pixels. Holes are not counted.
    ///
    /// # Errors
    /// As [`GpuRenderer::render`].
    pub(super) fn render_averaged(
        &mut self,
        samples: &Arc<SampleSet>,
        finer: &Vantage,
        settings: &RenderSettings,
        factor: usize,
        job: &Job,
    ) -> Result<(Arc<Picture>, RenderStats)> {
        let started = Instant::now();
        let average = match self.average.take() {
            Some(average) => average,
            None => self.context.guarded(|| Ok(AveragePass::new(&self.context)))?,
        };
        let painted = self.paint(samples, finer, settings, job, |context, target, mut commands| {
            let averaged = average.record(context, target, &mut commands, factor)?;
            let timed = commands.submit(context);
            Ok((read_picture(context, &averaged.readback, averaged.size, false)?, timed))
        });
        self.average = Some(average);
        let (picture, stats) = painted?;
        let milliseconds = started.elapsed().as_secs_f64() * 1e3;
        Ok((Arc::new(picture), RenderStats { milliseconds, ..stats }))
    }

    /// Paints as [`GpuRenderer::render`], but leaves the picture on the adapter: sRGB-encoded, with holes hatched that are not filled.
    ///
    /// # Errors
    /// As [`GpuRenderer::render`].
    pub fn show(
        &mut self,
        samples: &Arc<SampleSet>,
        vantage: &Vantage,
        settings: &RenderSettings,
        holes: &HolePattern,
        job: &Job,
    ) -> Result<(ScreenTexture, RenderStats)> {
        let started = Instant::now();
        let mut display = match self.display.take() {
            Some(display) => display,
            None => self.context.guarded(|| Ok(DisplayPass::new(&self.context)))?,
        };
        let shown = self.paint(samples, vantage, settings, job, |context, target, commands| {
            let (texture, holes, timed) = display.show(context, target, commands, holes)?;
            Ok(((texture, holes), timed))
        });
        self.display = Some(display).filter(|_| !matches!(shown, Err(Error::Gpu { .. })));
        let ((texture, holes), stats) = shown?;
        let milliseconds = started.elapsed().as_secs_f64() * 1e3;
        Ok((texture, RenderStats { holes, milliseconds, ..stats }))
    }

    /// Records all stages up to the finished picture; `finish` submits them and returns the result.
    fn paint<T>(
        &mut self,
        samples: &Arc<SampleSet>,
        vantage: &Vantage,
        settings: &RenderSettings,
        job: &Job,
        finish: impl FnOnce(&Context, &GpuTarget, Commands<'_>) -> Result<(T, TimedPasses)>,
    ) -> Result<(T, RenderStats)> {
        vantage.check(samples)?;
        job.check()?;
        let frame = FrameSamples::at(samples, vantage.frame)?;
        let key = BackgroundKey {
            samples: samples.clone(),
            images: frame.images[..frame.background_images].to_vec(),
            camera: vantage.camera.clone(),
            settings: settings.clone(),
            subpixels: subpixels_on(&self.context, samples, vantage, settings),
            with_fronts: wants_fronts(samples, &frame.images, settings),
        };
        let (subpixels, with_fronts) = (key.subpixels, key.with_fronts);
        let reused = self.background.take().as_ref().is_some_and(|background| background.matches(&key));
        let Self { context, pipelines, memory, target, finisher, stopwatch, .. } = self;
        let (context, stopwatch) = (&*context, stopwatch.as_ref());
        let result = context.guarded(|| {
            let camera = &finer(&vantage.camera, subpixels);
            let (width, height) = camera.intrinsics.size();
            let layout = TargetLayout { width, height, subpixels, kernel: settings.kernel, with_fronts };
            let target = target_for(target, context, pipelines, layout)?;
            let input = SceneInput { frame: &frame, camera, subpixels, with_fronts, settings };
            let scene = SceneBindings::new(context, pipelines, memory, target, input)?;
            job.check()?;
            let mut commands = Commands::new(context, stopwatch);
            let mut recorder = Recorder { pipelines, scene: &scene, target, commands: &mut commands };
            if !reused {
                recorder.paint(0);
            }
            recorder.paint(1);
            recorder.resolve();
            let camera = &vantage.camera;
            let painted = Painted { samples, frame: &frame, camera, settings, scene: &scene, target };
            finisher.record(context, &mut commands, painted)?;
            let (result, timed) = finish(context, target, commands)?;
            Ok((result, timed.read(context, stopwatch)?))
        });
        let (result, stages) = result.inspect_err(|error| {
            self.finisher.forget();
            // Buffers that memory ran out for are unusable from then on.
            if matches!(error, Error::Gpu { .. }) {
                self.target = None;
                self.memory.forget();
                self.finisher.drop_buffers();
            }
        })?;
        self.background = Some(key);
        let tiles = if reused { frame.foreground_tiles() } else { 0..frame.tile_count() };
        let samples = frame.sample_count(tiles);
        Ok((result, RenderStats { samples, background_reused: reused, stages, ..RenderStats::default() }))
    }
}

/// Buffers of this layout: the existing ones if they have it, else new ones.
fn target_for<'a>(
    target: &'a mut Option<GpuTarget>,
    context: &Context,
    pipelines: &Pipelines,
    layout: TargetLayout,
) -> Result<&'a GpuTarget> {
    let found = match target.take().filter(|target| target.layout == layout) {
        Some(found) => found,
        None => GpuTarget::new(context, pipelines, layout)?,
    };
    Ok(target.insert(found))
}

/// As [`subpixels`], but 1 where the adapter has no buffer large enough for more.
fn subpixels_on(
    context: &Context,
    samples: &SampleSet,
    vantage: &Vantage,
    settings: &RenderSettings,
) -> usize {
    let wanted = subpixels(samples, vantage, settings);
    let pixels = (vantage.camera.intrinsics.pixel_count() * wanted * wanted) as u64;
    let words = PICTURE_WORDS + COVERAGE_WORDS + FRONT_WORDS + SURFACE_WORDS;
    let fits = 4 * words * pixels <= context.max_binding();
    if fits { wanted } else { 1 }
}

/// An adapter for a test; `None`, with a message, if the machine has none, and a failure if `OVERLOOK_REQUIRE_GPU` demands one.
#[cfg(test)]
pub(super) fn opened<T>(adapter: Result<T>) -> Option<T> {
    let say = |error: &Error| {
        crate::simd::skip::skip(Some("OVERLOOK_REQUIRE_GPU"), &format!("nothing was painted: {error}"));
    };
    adapter.inspect_err(say).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::DemoSpec;
    use crate::render::tests::scene;

    #[test]
    fn after_a_failure_the_next_picture_is_painted() {
        let Some(mut gpu) = opened(GpuRenderer::new(AdapterChoice::Any)) else { return };
        let (samples, vantage) = scene(DemoSpec::new("orrery").cameras(2).size((48, 36)), 0);
        let paint =
            |gpu: &mut GpuRenderer| gpu.render(&samples, &vantage, &RenderSettings::default(), &Job::new());
        let (before, _) = paint(&mut gpu).unwrap();
        // When memory runs out, buffers are unusable.
        let unusable: [fn(&GpuRenderer); 2] = [
            |gpu| gpu.target.as_ref().unwrap().picture.destroy(),
            |gpu| gpu.memory.pages().for_each(wgpu::Buffer::destroy),
        ];
        for break_it in unusable {
            break_it(&gpu);
            let error = paint(&mut gpu).unwrap_err();
            assert!(matches!(error, Error::Gpu { .. }) && !gpu.context.is_lost(), "{error}");
            assert!(paint(&mut gpu).unwrap().0 == before);
        }
    }
}
