//! The CPU renderer: the reference, and the one that runs everywhere.
//!
//! Source: Interactive Dynamic Environments Using Image-Based Modeling and Rendering, §3.3: "We render the background images
//! once and paint the foreground over top for each consecutive time step. Only when the user moves vantage points do we
//! re-render the background."

use std::sync::Arc;
use std::time::Instant;

use super::compose::{Palette, compose};
use super::fill::fill;
use super::splat::{Layer, Source, splat};
use super::vantage::{Picture, RenderStats, Vantage};
use crate::capture::Camera;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::preprocess::SampleSet;
use crate::settings::RenderSettings;

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

/// Images at one frame, by index in the set, with the ordinal of each one's first sample.
struct Painted<'a> {
    set: &'a SampleSet,
    images: Vec<usize>,
    first_ordinals: Vec<u32>,
}

impl Palette for Painted<'_> {
    fn look_up(&self, ordinal: u32) -> (u32, [f32; 3]) {
        let position = self.first_ordinals.partition_point(|&first| first <= ordinal) - 1;
        let image = self.images[position];
        let index = (ordinal - self.first_ordinals[position]) as usize;
        (image as u32, self.set.images[image].color[index].map(half::f16::to_f32))
    }
}

impl<'a> Painted<'a> {
    /// The images at `frame`, those that outlast it first; how many of those there are.
    fn at(set: &'a SampleSet, frame: usize) -> (Self, usize) {
        let at_frame = || {
            set.images
                .iter()
                .enumerate()
                .filter(move |(_, image)| image.span.contains(frame))
                .map(|(index, _)| index)
        };
        let lasting = |index: &usize| set.images[*index].span.len() > 1;
        let mut images: Vec<usize> = at_frame().filter(lasting).collect();
        let background = images.len();
        images.extend(at_frame().filter(|index| !lasting(index)));
        let mut next = 0_u32;
        let first_ordinals = images
            .iter()
            .map(|&index| {
                let first = next;
                next = next.saturating_add(set.images[index].len() as u32);
                first
            })
            .collect();
        (Self { set, images, first_ordinals }, background)
    }

    fn sources(&self, range: std::ops::Range<usize>) -> Vec<Source<'a>> {
        range
            .map(|position| Source {
                image: &self.set.images[self.images[position]],
                first_ordinal: self.first_ordinals[position],
            })
            .collect()
    }
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
    /// `Cancelled`; `Invalid` where the frame does not exist, the picture has no pixel or absurdly many, or
    /// [`Vantage::validate`] refuses.
    pub fn render(
        &mut self,
        samples: &Arc<SampleSet>,
        vantage: &Vantage,
        settings: &RenderSettings,
        job: &Job,
    ) -> Result<(Picture, RenderStats)> {
        let started = Instant::now();
        check(samples, vantage)?;
        let (painted, lasting) = Painted::at(samples, vantage.frame);
        let reused = self.cached(samples, &painted.images[..lasting], vantage, settings);
        let background_reused = reused.is_some();
        let background = if let Some(layer) = reused {
            layer
        } else {
            let sources = painted.sources(0..lasting);
            let layer = Arc::new(splat(samples, &sources, &vantage.camera, settings, job)?);
            self.background = Some(CachedBackground {
                samples: samples.clone(),
                images: painted.images[..lasting].to_vec(),
                camera: vantage.camera.clone(),
                settings: settings.clone(),
                layer: layer.clone(),
            });
            layer
        };
        let sources = painted.sources(lasting..painted.images.len());
        let foreground = splat(samples, &sources, &vantage.camera, settings, job)?;
        let mut picture = compose([&background, &foreground], &vantage.camera, settings, &painted);
        let filling = Instant::now();
        fill(&mut picture, &vantage.camera, settings);
        let fill_ms = filling.elapsed().as_secs_f64() * 1e3;
        let painted_samples = foreground.samples + if background_reused { 0 } else { background.samples };
        let stats = RenderStats {
            samples: painted_samples,
            holes: picture.holes(),
            milliseconds: started.elapsed().as_secs_f64() * 1e3,
            fill_ms,
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

fn check(samples: &SampleSet, vantage: &Vantage) -> Result<()> {
    vantage.validate()?;
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
