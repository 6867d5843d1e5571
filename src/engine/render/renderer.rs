//! Renders on the CPU or the GPU, chosen by the user or by measurement, with the CPU as the fallback.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Instant;

use super::coarser_samples::CoarserSamples;
use super::cpu::CpuRenderer;
use super::gpu::{AdapterChoice, GpuOptions, GpuRenderer, HolePattern, ScreenTexture, SharedDevice};
use super::magnified::{COARSEST, by_levels, coarsest_level};
use super::orthographic::OrthographicView;
use super::painter::Painter;
use super::recorded_rates::RecordedRates;
use super::supersample::{
    EDGE_FACTOR, averaged, finer, supersamples_edges, supersampling_factor, with_averaged_edges,
};
use super::vantage::{Picture, RenderStats, Vantage};
use crate::capture::any_orthographic;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::samples::SampleSet;
use crate::settings::{Antialias, Backend, Kernel, RenderSettings};

/// The state of the graphics adapter.
#[derive(Debug, Default)]
enum Adapter {
    /// Not opened yet.
    #[default]
    Unknown,
    /// There is no graphics card, but perhaps a software adapter.
    NoCard,
    /// There is no adapter, or it was lost: the reason.
    Missing(String),
    Open(Box<GpuRenderer>),
}

/// Paints on the backend of [`RenderSettings::backend`], or on the CPU if that fails.
#[derive(Debug, Default)]
pub struct Renderer {
    /// One for each level of a close-up, so that each keeps its background.
    cpu: Vec<CpuRenderer>,
    coarser: CoarserSamples,
    adapter: Adapter,
    /// The backend that `auto` found to be faster, per kernel.
    faster: HashMap<Kernel, Backend>,
    notice: Option<String>,
    painter: Option<Painter>,
    /// The window's device.
    shared: Option<SharedDevice>,
}

/// A picture for a window.
#[derive(Clone, Debug)]
pub enum WindowPicture {
    /// On the window's own device, holes hatched.
    OnAdapter(ScreenTexture),
    /// In memory, still to be colored and sent.
    InMemory(Arc<Picture>),
}

/// What one picture is rendered from.
#[derive(Clone, Copy)]
struct Request<'a> {
    samples: &'a Arc<SampleSet>,
    vantage: &'a Vantage,
    settings: &'a RenderSettings,
    job: &'a Job,
    /// Level of a close-up; 0 is the picture itself.
    level: usize,
    /// Pixels that are painted along each side of one of the picture, and averaged.
    factor: usize,
}

/// The level of the finer picture that edges are averaged from, after those of a close-up.
const FINER: usize = COARSEST + 1;

/// A picture, and what rendering it took.
type PictureAndStats = (Arc<Picture>, RenderStats);

impl Renderer {
    /// A renderer with nothing cached, which opens an adapter when one is first needed.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// As [`Renderer::new`], but opens the GPU at once if `backend` is the GPU.
    ///
    /// # Errors
    /// `Gpu` if there is no adapter.
    pub fn strict(backend: Backend) -> Result<Self> {
        let adapter = match backend {
            Backend::Gpu => Adapter::Open(Box::new(GpuRenderer::new(AdapterChoice::Any)?)),
            Backend::Auto | Backend::Cpu => Adapter::Unknown,
        };
        Ok(Self { adapter, ..Self::default() })
    }

    /// As [`Renderer::new`], but paints on the device that a window draws with, where it can.
    #[must_use]
    pub fn sharing(shared: Option<SharedDevice>) -> Self {
        Self { shared, ..Self::default() }
    }

    /// What painted the last picture; `None` before the first.
    #[must_use]
    pub fn painter(&self) -> Option<&Painter> {
        self.painter.as_ref()
    }

    /// Why the chosen GPU does not paint; `None` otherwise.
    #[must_use]
    pub fn notice(&self) -> Option<&str> {
        self.notice.as_deref()
    }

    /// Drops what is cached, so that the next picture is painted in full.
    pub fn forget_background(&mut self) {
        self.cpu.clear();
        if let Adapter::Open(gpu) = &mut self.adapter {
            gpu.forget_background();
        }
    }

    /// Uploads the samples of the coming frames ahead, if the GPU paints. A failure is only logged: it returns when the frame is
    /// painted.
    pub fn prefetch(&mut self, samples: &SampleSet, frames: std::ops::Range<usize>) {
        if let (Adapter::Open(gpu), Some(Painter { backend: Backend::Gpu, .. })) =
            (&mut self.adapter, &self.painter)
            && let Err(error) = gpu.prefetch(samples, frames)
        {
            log::warn!("{error}");
        }
    }

    /// Paints the samples of the vantage's frame.
    ///
    /// # Errors
    /// As [`CpuRenderer::render`]: a GPU that fails is replaced by the CPU, see [`Renderer::notice`].
    pub fn render(
        &mut self,
        samples: &Arc<SampleSet>,
        vantage: &Vantage,
        settings: &RenderSettings,
        job: &Job,
    ) -> Result<PictureAndStats> {
        if vantage.camera.intrinsics.is_orthographic() {
            let view = OrthographicView::of_camera(samples, vantage)?;
            let (picture, stats) = self.render(&view.samples, &view.vantage, settings, job)?;
            return Ok((Arc::new(view.finish(&picture)), stats));
        }
        let started = Instant::now();
        let milliseconds = || started.elapsed().as_secs_f64() * 1e3;
        let request = Request { samples, vantage, settings, job, level: 0, factor: 1 };
        let rates = RecordedRates::of(samples, vantage);
        if let Some(coarser) = self.coarser.for_picture(samples, &rates, vantage, settings) {
            let (picture, stats) = self.paint(&Request { samples: &coarser, ..request })?;
            return Ok((picture, RenderStats { milliseconds: milliseconds(), ..stats }));
        }
        let factor = supersampling_factor(&rates, vantage, settings);
        if factor > 1 {
            let (picture, stats) = self.paint_averaged(&request, factor)?;
            let stats = RenderStats { holes: picture.holes(), milliseconds: milliseconds(), ..stats };
            return Ok((picture, stats));
        }
        let (picture, mut stats) = self.paint_by_levels(&request, &rates)?;
        if !supersamples_edges(&rates, vantage, settings) {
            return Ok((picture, stats));
        }
        let (averaged, more) = self.paint_averaged(&Request { level: FINER, ..request }, EDGE_FACTOR)?;
        let picture = Arc::new(with_averaged_edges(&picture, &averaged));
        // Both project the same samples.
        stats.stages.add(&more.stages);
        stats.milliseconds = milliseconds();
        Ok((picture, stats))
    }

    /// Paints a picture `factor` times as fine, and averages it.
    fn paint_averaged(&mut self, request: &Request<'_>, factor: usize) -> Result<PictureAndStats> {
        let Request { vantage, settings, .. } = *request;
        let finer = Vantage { camera: finer(&vantage.camera, factor), ..vantage.clone() };
        let settings = &RenderSettings { antialias: Antialias::Off, ..settings.clone() };
        self.paint(&Request { vantage: &finer, settings, factor, ..*request })
    }

    /// Paints a picture, of what it magnifies coarser levels.
    fn paint_by_levels(&mut self, request: &Request<'_>, rates: &RecordedRates) -> Result<PictureAndStats> {
        let coarsest = coarsest_level(rates, request.settings);
        if coarsest == 0 {
            return self.paint(request);
        }
        by_levels(coarsest, request.samples, request.vantage, |level, vantage| {
            self.paint(&Request { vantage, level, ..*request })
        })
    }

    fn paint(&mut self, request: &Request<'_>) -> Result<PictureAndStats> {
        if any_orthographic(&request.samples.cameras) {
            let painted = self.on_cpu_by_choice(request);
            if request.settings.backend == Backend::Gpu {
                self.notice = Some("the CPU renders: the GPU does not paint orthographic cameras".to_owned());
            }
            return painted;
        }
        match request.settings.backend {
            Backend::Cpu => self.on_cpu_by_choice(request),
            Backend::Gpu => {
                self.open(AdapterChoice::Any);
                self.on_gpu_if_possible(request)
            }
            Backend::Auto => self.on_the_faster(request),
        }
    }

    /// Paints for a window in motion: on the window's own device without a copy if the GPU paints there, the window tells how `holes`
    /// look, and the picture is no close-up, which is put together in memory; else as [`Renderer::render`]. Never supersampled,
    /// because the next picture follows at once.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn show(
        &mut self,
        samples: &Arc<SampleSet>,
        vantage: &Vantage,
        settings: &RenderSettings,
        holes: Option<&HolePattern>,
        job: &Job,
    ) -> Result<(WindowPicture, RenderStats)> {
        if vantage.camera.intrinsics.is_orthographic() {
            let (picture, stats) = self.render(samples, vantage, settings, job)?;
            return Ok((WindowPicture::InMemory(picture), stats));
        }
        let rates = RecordedRates::of(samples, vantage);
        let on_gpu = match settings.backend {
            _ if any_orthographic(&samples.cameras) => false,
            Backend::Cpu => false,
            Backend::Gpu => true,
            Backend::Auto => self.faster.get(&settings.kernel) == Some(&Backend::Gpu),
        };
        if on_gpu {
            self.open(AdapterChoice::Any);
        }
        let is_shared = matches!(&self.adapter, Adapter::Open(gpu) if gpu.context.is_shared);
        // If the GPU fails, it fails again below, where the CPU takes over.
        if on_gpu
            && is_shared
            && coarsest_level(&rates, settings) == 0
            && let Some(holes) = holes
            && let Some((texture, stats)) =
                self.try_gpu(|gpu| gpu.show(samples, vantage, settings, holes, job))?
        {
            return Ok((WindowPicture::OnAdapter(texture), stats));
        }
        let request = Request { samples, vantage, settings, job, level: 0, factor: 1 };
        let (picture, stats) = self.paint_by_levels(&request, &rates)?;
        Ok((WindowPicture::InMemory(picture), stats))
    }

    fn on_the_faster(&mut self, request: &Request<'_>) -> Result<PictureAndStats> {
        self.open(AdapterChoice::Hardware);
        let hardware = matches!(&self.adapter, Adapter::Open(gpu) if !gpu.context.is_software());
        match self.faster.get(&request.settings.kernel) {
            // If the card was lost since, this sets the notice.
            Some(Backend::Gpu) => self.on_gpu_if_possible(request),
            None if hardware => self.measure(request),
            _ => self.on_cpu_by_choice(request),
        }
    }

    /// Paints in full on both, and remembers which was faster. The GPU paints twice, because its first time includes uploading the
    /// samples.
    fn measure(&mut self, request: &Request<'_>) -> Result<PictureAndStats> {
        self.on_gpu_if_possible(request)?;
        self.forget_background();
        let (picture, gpu) = self.on_gpu_if_possible(request)?;
        if self.painter.as_ref().is_none_or(|painter| painter.backend == Backend::Cpu) {
            return Ok((picture, gpu));
        }
        self.forget_background();
        let on_gpu = self.painter.clone();
        let (cpu_picture, cpu) = self.on_cpu(request)?;
        let backend = if gpu.milliseconds < cpu.milliseconds { Backend::Gpu } else { Backend::Cpu };
        let kernel = request.settings.kernel;
        self.faster.insert(kernel, backend);
        log::info!("{kernel}: {:.1} ms on the GPU, {:.1} ms on the CPU", gpu.milliseconds, cpu.milliseconds);
        if backend == Backend::Cpu {
            return Ok((cpu_picture, cpu));
        }
        self.painter = on_gpu;
        Ok((picture, gpu))
    }

    /// Opens an adapter, unless that was tried before.
    fn open(&mut self, choice: AdapterChoice) {
        match (&self.adapter, choice) {
            (Adapter::Unknown, _) | (Adapter::NoCard, AdapterChoice::Any) => {}
            _ => return,
        }
        let options = GpuOptions { adapter: choice, ..GpuOptions::default() };
        let shared = self.shared.as_ref().and_then(|shared| GpuRenderer::sharing(shared, &options).ok());
        let opened = shared.map_or_else(|| GpuRenderer::with_options(&options), Ok);
        self.adapter = match opened {
            Ok(gpu) => Adapter::Open(Box::new(gpu)),
            Err(_) if choice == AdapterChoice::Hardware => Adapter::NoCard,
            Err(error) => Adapter::Missing(error.to_string()),
        };
    }

    fn on_cpu_by_choice(&mut self, request: &Request<'_>) -> Result<PictureAndStats> {
        self.notice = None;
        self.on_cpu(request)
    }

    fn on_cpu(&mut self, request: &Request<'_>) -> Result<PictureAndStats> {
        let Request { samples, vantage, settings, job, level, factor } = *request;
        if self.cpu.len() <= level {
            self.cpu.resize_with(level + 1, CpuRenderer::new);
        }
        let (picture, stats) = self.cpu[level].render(samples, vantage, settings, job)?;
        self.painter = Some(Painter::cpu());
        Ok((if factor == 1 { picture } else { Arc::new(averaged(&picture, factor)) }, stats))
    }

    fn on_gpu_if_possible(&mut self, request: &Request<'_>) -> Result<PictureAndStats> {
        if let Adapter::Missing(why) = &self.adapter {
            self.notice = Some(format!("the CPU renders: {why}"));
        }
        let Request { samples, vantage, settings, job, factor, .. } = *request;
        let painted = self.try_gpu(|gpu| match factor {
            1 => gpu.render(samples, vantage, settings, job),
            _ => gpu.render_averaged(samples, vantage, settings, factor, job),
        })?;
        painted.map_or_else(|| self.on_cpu(request), Ok)
    }

    /// Paints on the adapter; `None`, with a notice, if it fails, and without one if none is open.
    fn try_gpu<T>(&mut self, paint: impl FnOnce(&mut GpuRenderer) -> Result<T>) -> Result<Option<T>> {
        let Adapter::Open(gpu) = &mut self.adapter else { return Ok(None) };
        match paint(gpu) {
            Ok(painted) => {
                self.painter = Some(Painter::gpu(gpu));
                self.notice = None;
                Ok(Some(painted))
            }
            Err(Error::Gpu { what }) => {
                self.notice = Some(format!("the CPU renders: {what}"));
                if gpu.context.is_lost() {
                    self.adapter = Adapter::Missing(what);
                }
                Ok(None)
            }
            Err(error) => Err(error),
        }
    }
}

#[cfg(test)]
mod tests;
