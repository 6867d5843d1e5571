//! What follows on a painted picture, whatever painted it: holes that hide a surface are found, and holes are filled.

use std::sync::{Arc, Weak};

use super::environment::{Environment, SkySums};
use super::fill::{FillPlanes, TestedHoles, fill_tested};
use super::free_space::{MarkPlanes, RayTest, SeenDepths, cameras_to_ask, mark_holes};
use super::input::focal;
use super::input::{FrameImages, FrameSamples};
use super::stage_times::{Stage, StageClock};
use super::vantage::{FrontColor, Picture, Vantage};
use crate::error::Result;
use crate::samples::SampleSet;
use crate::settings::{Fill, Kernel, RenderSettings};

/// Memory that what cameras saw at the last frames may take, bytes: a loop that is played again finds it there.
const MOST_BYTES: usize = 96 << 20;

/// Finishes pictures, and keeps what cameras saw at the last frames.
#[derive(Debug, Default)]
pub(super) struct Finisher {
    /// With the samples that it is of, which the next frame may share.
    background: Option<(Arc<SampleSet>, SeenFrame)>,
    /// The last one first.
    frames: Vec<SeenFrame>,
    planes: MarkPlanes,
    fill_planes: FillPlanes,
}

/// What cameras saw according to some images of samples.
#[derive(Debug)]
struct SeenFrame {
    samples: Weak<SampleSet>,
    images: Vec<usize>,
    depths: SeenDepths,
    sky: Arc<SkySums>,
    environment: Option<Arc<Environment>>,
}

/// Whether lines of sight are tested with these settings.
pub(super) fn tests_free_space(settings: &RenderSettings) -> bool {
    settings.free_space && settings.kernel.interpolates()
}

/// Whether pictures of some images of samples have to tell what pixels show in front of their farthest surface: where lines of
/// sight are tested, which is where there are samples at infinity.
pub(super) fn wants_fronts(samples: &SampleSet, images: &[usize], settings: &RenderSettings) -> bool {
    settings.kernel == Kernel::Gather && tests_free_space(settings) && has_sky(samples, images)
}

/// Whether some images hold samples at infinity.
pub(super) fn has_sky(samples: &SampleSet, images: &[usize]) -> bool {
    let has_sky = |image: &usize| samples.images[*image].depth.tiles().iter().any(|tile| tile.farthest == 0);
    images.iter().any(has_sky)
}

/// Whether painted pictures are changed with these settings.
pub(super) fn changes_pictures(settings: &RenderSettings) -> bool {
    tests_free_space(settings) || settings.fill != Fill::None
}

impl Finisher {
    /// Finds the holes of a picture that hide a surface, and fills all holes, as the settings demand; `fronts` as in
    /// [`Picture::fronts`].
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
        clock: &mut StageClock,
    ) -> Result<()> {
        let camera = &vantage.camera;
        let mut planes = std::mem::take(&mut self.planes);
        let mut fill_planes = std::mem::take(&mut self.fill_planes);
        let images = tests_free_space(settings).then(|| FrameImages::at(samples, vantage.frame));
        let images = images.filter(|images| has_sky(samples, images.all()));
        let seen = images.map(|images| self.see(samples, vantage, images)).transpose()?;
        let seen = seen.filter(|seen| seen.environment.is_some());
        let test = seen.map(|seen| RayTest::new(&seen.depths, &samples.cameras, camera));
        let mut blended = Vec::new();
        if let Some(test) = &test {
            let tolerance = 1.0 + (settings.depth_tolerance + 1.0) / focal(camera);
            blended = mark_holes(picture, fronts, test, tolerance, &mut planes);
        }
        clock.end(Stage::FreeSpace);
        let tested = TestedHoles {
            environment: seen.and_then(|seen| seen.environment.as_deref()),
            blended: &blended,
            hidden_share: &planes.hidden_share,
            test: test.as_ref(),
        };
        fill_tested(picture, camera, settings, tested, &mut fill_planes);
        clock.end(Stage::Fill);
        (self.planes, self.fill_planes) = (planes, fill_planes);
        Ok(())
    }

    /// What cameras saw at the frame of a vantage; depths only where there is a sky, and only of the cameras to ask.
    fn see(
        &mut self,
        samples: &Arc<SampleSet>,
        vantage: &Vantage,
        images: FrameImages,
    ) -> Result<&SeenFrame> {
        let wanted = cameras_to_ask(&samples.cameras, &vantage.camera);
        let nth = self.frames.iter().position(|seen| seen.is_of(samples, images.all()));
        let known = nth.map(|nth| self.frames.remove(nth));
        let seen = match known {
            Some(seen) if seen.environment.is_none() || seen.depths.has(&wanted) => seen,
            known => self.see_anew(samples, vantage.frame, images, known, &wanted)?,
        };
        let mut bytes = 0;
        self.frames.retain(|seen| {
            bytes += seen.bytes();
            bytes <= MOST_BYTES && seen.samples.strong_count() > 0
        });
        self.frames.insert(0, seen);
        Ok(&self.frames[0])
    }

    /// What cameras saw at a frame; what is `known` is taken over.
    fn see_anew(
        &mut self,
        samples: &Arc<SampleSet>,
        frame: usize,
        images: FrameImages,
        known: Option<SeenFrame>,
        wanted: &[usize],
    ) -> Result<SeenFrame> {
        let (background, all) = (images.background().to_vec(), images.all().to_vec());
        let frame = FrameSamples::of(samples, frame, images, None)?;
        let (back, front) = (frame.background_tiles(), frame.foreground_tiles());
        let known_before = self.background.take().filter(|(_, seen)| seen.is_of(samples, &background));
        let (_, before) = self.background.insert(known_before.unwrap_or_else(|| {
            let sky = SkySums::new(&frame, back.clone(), None);
            (samples.clone(), SeenFrame::new(samples, background, sky, None))
        }));
        let mut seen = known.unwrap_or_else(|| {
            let sky = SkySums::new(&frame, front.clone(), Some(&before.sky));
            SeenFrame::new(samples, all, sky, Some(before))
        });
        if seen.environment.is_some() {
            before.depths.complete(&frame, &back, None, wanted);
            seen.depths.keep(wanted);
            seen.depths.complete(&frame, &front, Some(&before.depths), wanted);
            seen.depths.finish();
        }
        Ok(seen)
    }
}

impl SeenFrame {
    /// For some images and their sky, which may be that of `before`. Nothing is known of depths yet.
    fn new(samples: &Arc<SampleSet>, images: Vec<usize>, sky: Arc<SkySums>, before: Option<&Self>) -> Self {
        let shared = before.filter(|before| Arc::ptr_eq(&before.sky, &sky));
        let environment = match shared {
            Some(before) => before.environment.clone(),
            None => Environment::new(&sky).map(Arc::new),
        };
        Self { samples: Arc::downgrade(samples), images, depths: SeenDepths::default(), sky, environment }
    }

    fn is_of(&self, samples: &Arc<SampleSet>, images: &[usize]) -> bool {
        self.images == images && self.samples.upgrade().is_some_and(|own| own.shares(samples, images))
    }

    /// Memory that it alone takes, bytes.
    fn bytes(&self) -> usize {
        let is_shared = Arc::strong_count(&self.sky) > 1;
        self.depths.bytes() + if is_shared { 0 } else { 2 * self.sky.bytes() }
    }
}
