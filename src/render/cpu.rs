//! The CPU renderer: the reference, and the one that runs everywhere.
//!
//! Source: Interactive Dynamic Environments Using Image-Based Modeling and Rendering, §3.3: "We render the background images
//! once and paint the foreground over top for each consecutive time step. Only when the user moves vantage points do we
//! re-render the background."

use std::sync::Arc;
use std::time::Instant;

use super::blend::blend;
use super::compose::{Layer, compose};
use super::cull::{Reach, bands, bounds};
use super::frame_samples::FrameSamples;
use super::project::{Projector, focal};
use super::surface::{Stage, surface};
use super::vantage::{Picture, RenderStats, Vantage};
use crate::capture::Camera;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::preprocess::SampleSet;
use crate::settings::{Kernel, RenderSettings};

/// Largest picture that is rendered, pixels: 16K by 8K.
pub const MAX_PIXELS: usize = 1 << 27;

/// Renders vantages, and keeps the background while the vantage is still.
#[derive(Debug, Default)]
pub struct CpuRenderer {
    background: Option<CachedBackground>,
}

#[derive(Debug)]
struct CachedBackground {
    samples: Arc<SampleSet>,
    images: Vec<usize>,
    camera: Camera,
    settings: RenderSettings,
    layer: Arc<Layer>,
}

impl CpuRenderer {
    /// A renderer with nothing cached.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Paints the samples of the vantage's frame.
    ///
    /// # Errors
    /// `Cancelled`; `Invalid` where the frame does not exist, or the picture has no pixel or absurdly many.
    pub fn render(
        &mut self,
        samples: &Arc<SampleSet>,
        vantage: &Vantage,
        settings: &RenderSettings,
        job: &Job,
    ) -> Result<(Picture, RenderStats)> {
        let started = Instant::now();
        check(samples, vantage)?;
        let frame = FrameSamples::at(samples, vantage.frame)?;
        let reused = self.cached(samples, &frame.images[..frame.lasting_images], vantage, settings);
        let background_reused = reused.is_some();
        let projectors: Vec<Projector> =
            samples.cameras.iter().map(|camera| Projector::new(camera, &vantage.camera)).collect();
        let per_footprint: Vec<f32> = samples.cameras.iter().map(|camera| 1.0 / focal(camera)).collect();
        let surface_ratio = 1.0 / (1.0 + settings.depth_tolerance / focal(&vantage.camera));
        let stage = Stage {
            frame: &frame,
            projectors: &projectors,
            per_footprint: &per_footprint,
            width: vantage.camera.intrinsics.width as usize,
            kernel: settings.kernel,
            job,
        };
        let background = if let Some(layer) = reused {
            layer
        } else {
            let layer = Arc::new(paint(&stage, frame.lasting(), &vantage.camera, surface_ratio)?);
            self.background = Some(CachedBackground {
                samples: samples.clone(),
                images: frame.images[..frame.lasting_images].to_vec(),
                camera: vantage.camera.clone(),
                settings: settings.clone(),
                layer: layer.clone(),
            });
            layer
        };
        let foreground = paint(&stage, frame.passing(), &vantage.camera, surface_ratio)?;
        let mut picture = compose([&background, &foreground], stage.width, surface_ratio, &frame);
        if settings.kernel == crate::settings::Kernel::Gather {
            let keys: Vec<u64> =
                background.keys.iter().zip(&foreground.keys).map(|(a, b)| *a.max(b)).collect();
            let colors =
                super::gather::Gather::new(&frame, 0..frame.tiles.len(), &vantage.camera).gather(&keys, stage.width);
            picture.color = crate::grid::Grid::from_vec(stage.width, keys.len() / stage.width, colors);
        }
        let painted_samples = foreground.samples + if background_reused { 0 } else { background.samples };
        let stats = RenderStats {
            samples: painted_samples,
            holes: picture.holes(),
            milliseconds: started.elapsed().as_secs_f64() * 1e3,
            background_reused,
        };
        Ok((picture, stats))
    }

    fn cached(
        &self,
        samples: &Arc<SampleSet>,
        images: &[usize],
        vantage: &Vantage,
        settings: &RenderSettings,
    ) -> Option<Arc<Layer>> {
        let cached = self.background.as_ref()?;
        let same = Arc::ptr_eq(&cached.samples, samples)
            && cached.images == images
            && cached.camera == vantage.camera
            && cached.settings == *settings;
        same.then(|| cached.layer.clone())
    }
}

/// Paints some tiles of the frame.
fn paint(stage: &Stage<'_>, tiles: std::ops::Range<usize>, target: &Camera, surface_ratio: f32) -> Result<Layer> {
    let (width, height) = target.intrinsics.size();
    let samples = stage.frame.sample_count(tiles.clone());
    let reach = match stage.kernel {
        Kernel::Point => Reach { pixels: 0.0, source_pixels: 0.0 },
        Kernel::Block => Reach { pixels: 1.0, source_pixels: 0.0 },
        Kernel::Surfel | Kernel::Gather => Reach { pixels: 2.0, source_pixels: 8.0 },
    };
    let found = bounds(stage.frame, tiles.clone(), stage.projectors, target, reach);
    let threads = rayon::current_num_threads();
    let count = if threads == 1 { 1 } else { 2 * threads };
    let bands = bands(&found, tiles.start, height, count);
    let mut keys = vec![0; width * height];
    surface(stage, &bands, &mut keys)?;
    let sums = if matches!(stage.kernel, Kernel::Block | Kernel::Surfel) {
        blend(stage, &bands, &keys, surface_ratio)?
    } else {
        Vec::new()
    };
    Ok(Layer { keys, sums, samples })
}

/// Whether the vantage can be painted.
pub(super) fn check(samples: &SampleSet, vantage: &Vantage) -> Result<()> {
    let place = format!("vantage '{}'", vantage.camera.name);
    let (width, height) = vantage.camera.intrinsics.size();
    let pixels = width.saturating_mul(height);
    if pixels == 0 || pixels > MAX_PIXELS {
        return Err(Error::invalid(
            place,
            format!(
                "a picture of {width}×{height} pixels cannot be rendered; choose between 1 and {MAX_PIXELS} pixels"
            ),
        ));
    }
    if vantage.frame >= samples.frame_count() {
        return Err(Error::invalid(
            place,
            format!("there is no frame {}; '{}' has {}", vantage.frame, samples.name, samples.frame_count()),
        ));
    }
    Ok(())
}
