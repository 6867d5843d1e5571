//! What follows on a painted picture, whatever painted it: holes that hide a surface are found, and holes are filled.

use std::sync::Arc;
use std::time::Instant;

use super::environment::{Environment, SkySums};
use super::fill::fill_from;
use super::free_space::{SeenDepths, mark_holes};
use super::input::{FrameImages, FrameSamples};
use super::vantage::{Picture, Vantage};
use crate::error::Result;
use crate::samples::SampleSet;
use crate::settings::{Fill, Kernel, RenderSettings};

/// Finishes pictures, and keeps what cameras saw at the last frame.
#[derive(Debug, Default)]
pub(super) struct Finisher {
    background: Option<SeenFrame>,
    frame: Option<SeenFrame>,
}

/// What cameras saw according to some images of samples.
#[derive(Debug)]
struct SeenFrame {
    samples: Arc<SampleSet>,
    images: Vec<usize>,
    depths: SeenDepths,
    sky: SkySums,
    environment: Option<Environment>,
}

/// Whether lines of sight are tested with these settings.
pub(super) fn tests_free_space(settings: &RenderSettings) -> bool {
    settings.free_space && matches!(settings.kernel, Kernel::Gather | Kernel::Surfel)
}

/// Whether painted pictures are changed with these settings.
pub(super) fn changes_pictures(settings: &RenderSettings) -> bool {
    tests_free_space(settings) || settings.fill != Fill::None
}

impl Finisher {
    /// Finds the holes of a picture that hide a surface, and fills all holes, as the settings demand. Returns the
    /// milliseconds that filling took.
    ///
    /// # Errors
    /// `Unsupported` where a frame has more samples than can be numbered.
    pub(super) fn finish(
        &mut self,
        picture: &mut Picture,
        samples: &Arc<SampleSet>,
        vantage: &Vantage,
        settings: &RenderSettings,
    ) -> Result<f64> {
        let camera = &vantage.camera;
        let (mut environment, mut blended) = (None, Vec::new());
        if tests_free_space(settings) {
            let seen = self.seen_at(samples, vantage.frame)?;
            let (depths, cameras) = (&seen.depths, &samples.cameras);
            blended = mark_holes(picture, depths, cameras, camera, settings.depth_tolerance);
            environment = seen.environment.as_ref();
        }
        let filling = Instant::now();
        fill_from(picture, camera, settings, environment, &blended);
        Ok(filling.elapsed().as_secs_f64() * 1e3)
    }

    /// What cameras saw at a frame.
    fn seen_at(&mut self, samples: &Arc<SampleSet>, frame: usize) -> Result<&SeenFrame> {
        let images = FrameImages::at(samples, frame);
        let (background, all) = (images.background().to_vec(), images.all().to_vec());
        if self.frame.as_ref().is_some_and(|seen| seen.is_of(samples, &all))
            && let Some(seen) = self.frame.take()
        {
            return Ok(self.frame.insert(seen));
        }
        let frame = FrameSamples::of(samples, frame, images, None)?;
        if !self.background.as_ref().is_some_and(|seen| seen.is_of(samples, &background)) {
            let (depths, sky) = rayon::join(
                || SeenDepths::new(&frame, frame.background_tiles(), None),
                || SkySums::new(&frame, frame.background_tiles(), None),
            );
            let samples = samples.clone();
            self.background = Some(SeenFrame { samples, images: background, depths, sky, environment: None });
        }
        let before = self.background.as_ref();
        let (depths, sky) = rayon::join(
            || SeenDepths::new(&frame, frame.foreground_tiles(), before.map(|before| &before.depths)),
            || SkySums::new(&frame, frame.foreground_tiles(), before.map(|before| &before.sky)),
        );
        let (samples, environment) = (samples.clone(), Environment::new(&sky));
        Ok(self.frame.insert(SeenFrame { samples, images: all, depths, sky, environment }))
    }
}

impl SeenFrame {
    fn is_of(&self, samples: &Arc<SampleSet>, images: &[usize]) -> bool {
        Arc::ptr_eq(&self.samples, samples) && self.images == images
    }
}
