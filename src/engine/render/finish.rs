//! What follows on a painted picture, whatever painted it: holes that hide a surface are found, and holes are filled.

use std::sync::Arc;
use std::time::Instant;

use super::environment::{Environment, SkySums};
use super::fill::fill_from;
use super::free_space::{MarkPlanes, RayTest, SeenDepths, cameras_to_ask, mark_holes};
use super::geometry::focal;
use super::input::{FrameImages, FrameSamples};
use super::vantage::{FrontColor, Picture, Vantage};
use crate::error::Result;
use crate::samples::SampleSet;
use crate::settings::{Fill, Kernel, RenderSettings};

/// Finishes pictures, and keeps what cameras saw at the last frame.
#[derive(Debug, Default)]
pub(super) struct Finisher {
    background: Option<SeenFrame>,
    frame: Option<SeenFrame>,
    planes: MarkPlanes,
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
    settings.free_space && settings.kernel.interpolates()
}

/// Whether pictures of some images of samples have to tell what pixels show in front of their farthest surface: where lines of
/// sight are tested, which is where there are samples at infinity.
pub(super) fn wants_fronts(samples: &SampleSet, images: &[usize], settings: &RenderSettings) -> bool {
    let has_sky = |image: &usize| samples.images[*image].depth.tiles().iter().any(|tile| tile.farthest == 0);
    settings.kernel == Kernel::Gather && tests_free_space(settings) && images.iter().any(has_sky)
}

/// Whether painted pictures are changed with these settings.
pub(super) fn changes_pictures(settings: &RenderSettings) -> bool {
    tests_free_space(settings) || settings.fill != Fill::None
}

impl Finisher {
    /// Finds the holes of a picture that hide a surface, and fills all holes, as the settings demand; `fronts` as in
    /// [`Picture::fronts`]. Returns the milliseconds that filling took.
    ///
    /// # Errors
    /// `Unsupported` where a frame has more samples than can be numbered.
    pub(super) fn finish(
        &mut self,
        picture: &mut Picture,
        fronts: &[FrontColor],
        samples: &Arc<SampleSet>,
        vantage: &Vantage,
        settings: &RenderSettings,
    ) -> Result<f64> {
        let camera = &vantage.camera;
        let (mut environment, mut blended) = (None, Vec::new());
        if tests_free_space(settings) {
            self.see(samples, vantage)?;
            environment = self.frame.as_ref().and_then(|seen| Some((seen, seen.environment.as_ref()?)));
            if let Some((seen, _)) = environment {
                let test = RayTest::new(&seen.depths, &samples.cameras, camera);
                let tolerance = 1.0 + (settings.depth_tolerance + 1.0) / focal(camera);
                blended = mark_holes(picture, fronts, &test, tolerance, &mut self.planes);
            }
        }
        let filling = Instant::now();
        fill_from(picture, camera, settings, environment.map(|(_, environment)| environment), &blended);
        Ok(filling.elapsed().as_secs_f64() * 1e3)
    }

    /// Finds what cameras saw at the frame of a vantage; depths only where there is a sky, and only of the cameras to ask.
    fn see(&mut self, samples: &Arc<SampleSet>, vantage: &Vantage) -> Result<()> {
        let images = FrameImages::at(samples, vantage.frame);
        let (background, all) = (images.background().to_vec(), images.all().to_vec());
        let wanted = cameras_to_ask(&samples.cameras, &vantage.camera);
        let known = self.frame.take().filter(|seen| seen.is_of(samples, &all));
        let known = match known {
            Some(seen) if seen.environment.is_none() || seen.depths.has(&wanted) => {
                self.frame = Some(seen);
                return Ok(());
            }
            known => known,
        };
        let frame = FrameSamples::of(samples, vantage.frame, images, None)?;
        let (back, front) = (frame.background_tiles(), frame.foreground_tiles());
        let known_before = self.background.take().filter(|seen| seen.is_of(samples, &background));
        let before = self.background.insert(known_before.unwrap_or_else(|| SeenFrame {
            samples: samples.clone(),
            images: background,
            depths: SeenDepths::default(),
            sky: SkySums::new(&frame, back.clone(), None),
            environment: None,
        }));
        let mut seen = known.unwrap_or_else(|| {
            let sky = SkySums::new(&frame, front.clone(), Some(&before.sky));
            let environment = Environment::new(&sky);
            SeenFrame {
                samples: samples.clone(),
                images: all,
                depths: SeenDepths::default(),
                sky,
                environment,
            }
        });
        if seen.environment.is_some() {
            before.depths.complete(&frame, &back, None, &wanted);
            seen.depths.keep(&wanted);
            seen.depths.complete(&frame, &front, Some(&before.depths), &wanted);
        }
        self.frame = Some(seen);
        Ok(())
    }
}

impl SeenFrame {
    fn is_of(&self, samples: &Arc<SampleSet>, images: &[usize]) -> bool {
        Arc::ptr_eq(&self.samples, samples) && self.images == images
    }
}
