//! The CPU renderer: the reference, and the one that runs everywhere.
//!
//! Source: Interactive Dynamic Environments Using Image-Based Modeling and Rendering, §3.3: "We render the background images
//! once and paint the foreground over top for each consecutive time step. Only when the user moves vantage points do we
//! re-render the background." What differs: only the blocks of the picture that the foreground leaves or enters are painted.

use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use super::blend::{BLEND_REACH, blend};
use super::blocks::Blocks;
use super::cull::{Bounds, Reach, bands, bounds};
use super::fill::fill;
use super::footprint::MAX_STRETCH;
use super::frame_samples::FrameSamples;
use super::gather::Gather;
use super::project::{Projector, focal, rays_in_world};
use super::resolve::{Layer, Resolve};
use super::silhouette::RING;
use super::surface::{Stage, surface};
use super::vantage::{Picture, RenderStats, Vantage};
use crate::capture::Camera;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::preprocess::SampleSet;
use crate::settings::{Fill, Kernel, RenderSettings};

/// Largest picture that is rendered, pixels: 16K by 8K.
pub const MAX_PIXELS: usize = 1 << 27;

/// Renders vantages, and keeps the background while the vantage is still.
#[derive(Debug, Default)]
pub struct CpuRenderer {
    still: Option<Still>,
}

/// What is kept from one frame to the next.
#[derive(Debug)]
struct Still {
    samples: Arc<SampleSet>,
    /// Indices of the images that outlast the frame.
    images: Vec<usize>,
    camera: Camera,
    settings: RenderSettings,
    background: Layer,
    /// The background alone; made when the first frame follows at the same vantage.
    background_picture: Option<Picture>,
    foreground: Layer,
    /// The blocks that the foreground has touched.
    touched: Blocks,
    /// The last picture, and before it one that whoever asked for it may still hold: while they look at one, the other is
    /// painted over instead of copied.
    pictures: Vec<Painted>,
}

/// A picture, and the blocks in which it may differ from the background's.
#[derive(Debug)]
struct Painted {
    picture: Arc<Picture>,
    touched: Blocks,
}

/// What the stages of one picture are made of.
struct Painting<'a> {
    frame: &'a FrameSamples<'a>,
    target: &'a Camera,
    settings: &'a RenderSettings,
    projectors: Vec<Projector>,
    per_footprint: Vec<f32>,
    surface_ratio: f32,
    job: &'a Job,
}

impl<'a> Painting<'a> {
    fn new(
        frame: &'a FrameSamples<'a>,
        target: &'a Camera,
        settings: &'a RenderSettings,
        job: &'a Job,
    ) -> Self {
        let cameras = &frame.set.cameras;
        Self {
            frame,
            target,
            settings,
            projectors: cameras.iter().map(|camera| Projector::new(camera, target)).collect(),
            per_footprint: cameras.iter().map(|camera| 1.0 / focal(camera)).collect(),
            surface_ratio: 1.0 / (1.0 + settings.depth_tolerance / focal(target)),
            job,
        }
    }

    fn size(&self) -> (usize, usize) {
        self.target.intrinsics.size()
    }

    fn blends(&self) -> bool {
        matches!(self.settings.kernel, Kernel::Block | Kernel::Surfel)
    }

    fn bounds(&self, tiles: Range<usize>) -> Vec<Bounds> {
        let reach = match self.settings.kernel {
            Kernel::Point => Reach { pixels: 0.0, source_pixels: 0.0 },
            Kernel::Block => Reach { pixels: 1.0, source_pixels: 0.0 },
            Kernel::Surfel => BLEND_REACH,
            Kernel::Gather => Reach { pixels: 1.0, source_pixels: MAX_STRETCH },
        };
        bounds(self.frame, tiles, &self.projectors, self.target, reach)
    }

    /// Paints some tiles into a layer, over what is there.
    fn paint(&self, first_tile: usize, bounds: &[Bounds], layer: &mut Layer) -> Result<()> {
        let (width, height) = self.size();
        let stage = Stage {
            frame: self.frame,
            projectors: &self.projectors,
            per_footprint: &self.per_footprint,
            rays_in_world: rays_in_world(self.target, 0.0),
            width,
            kernel: self.settings.kernel,
            job: self.job,
        };
        let threads = rayon::current_num_threads();
        let bands = bands(bounds, first_tile, height, if threads == 1 { 1 } else { 2 * threads });
        surface(&stage, &bands, &mut layer.keys)?;
        if self.blends() {
            blend(&stage, &bands, &layer.keys, self.surface_ratio, &mut layer.sums)?;
        }
        Ok(())
    }

    /// Resolves some blocks of a picture; without a foreground, those of the background alone.
    fn resolve(
        &self,
        background: &Layer,
        foreground: Option<&Layer>,
        background_picture: Option<&Picture>,
        (which, picture): (&Blocks, &mut Picture),
    ) -> Result<()> {
        let gathers = self.settings.kernel == Kernel::Gather;
        let among = |tiles| Gather::new(self.frame, tiles, self.target, self.settings.depth_tolerance);
        // Blocks without foreground are copied where the background's picture is there already.
        let lasting = (gathers && background_picture.is_none()).then(|| among(self.frame.lasting()));
        let all = (gathers && foreground.is_some()).then(|| among(0..self.frame.tiles.len()));
        let either = lasting.as_ref().or(all.as_ref());
        let resolve = Resolve {
            frame: self.frame,
            kernel: self.settings.kernel,
            width: self.size().0,
            surface_ratio: self.surface_ratio,
            background,
            foreground,
            background_picture,
            gather: either.map(|either| [either, all.as_ref().unwrap_or(either)]),
            job: self.job,
        };
        resolve.resolve(which, picture)
    }
}

impl CpuRenderer {
    /// A renderer with nothing cached.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Paints the samples of the vantage's frame. A caller that holds no more than the last picture spares the renderer copies.
    ///
    /// # Errors
    /// `Cancelled`; `Invalid` where the frame does not exist, the picture has no pixel or absurdly many, or
    /// [`Vantage::validate`] refuses; `Unsupported` where a frame has more samples than can be numbered.
    pub fn render(
        &mut self,
        samples: &Arc<SampleSet>,
        vantage: &Vantage,
        settings: &RenderSettings,
        job: &Job,
    ) -> Result<(Arc<Picture>, RenderStats)> {
        let started = Instant::now();
        check(samples, vantage)?;
        let frame = FrameSamples::at(samples, vantage.frame)?;
        let painting = Painting::new(&frame, &vantage.camera, settings, job);
        // Taken out, so that a canceled job leaves nothing half painted behind.
        let still = self.still.take();
        let lasting = &frame.images[..frame.lasting_images];
        let background_reused =
            still.as_ref().is_some_and(|still| still.shows(samples, lasting, &vantage.camera, settings));
        let still = match still {
            Some(still) if background_reused => repaint(&painting, still)?,
            still => paint_anew(&painting, samples, still.map(Buffers::of).unwrap_or_default())?,
        };
        let mut picture = still.pictures[0].picture.clone();
        self.still = Some(still);
        let filling = Instant::now();
        if settings.fill != Fill::None {
            fill(Arc::make_mut(&mut picture), &vantage.camera, settings);
        }
        let fill_ms = filling.elapsed().as_secs_f64() * 1e3;
        let painted = if background_reused { frame.passing() } else { 0..frame.tiles.len() };
        let stats = RenderStats {
            samples: frame.sample_count(painted),
            holes: picture.holes(),
            milliseconds: started.elapsed().as_secs_f64() * 1e3,
            fill_ms,
            background_reused,
        };
        Ok((picture, stats))
    }
}

impl Still {
    fn shows(
        &self,
        samples: &Arc<SampleSet>,
        images: &[usize],
        camera: &Camera,
        settings: &RenderSettings,
    ) -> bool {
        self.images == images
            && (Arc::ptr_eq(&self.samples, samples) || self.samples.shares(samples, images))
            && self.camera == *camera
            && self.settings == *settings
    }

    /// A picture that nobody else holds; of the others, the last one is kept.
    fn free_picture(&mut self, background: &Picture) -> Painted {
        let is_free = |painted: &mut Painted| Arc::get_mut(&mut painted.picture).is_some();
        let free = self.pictures.iter_mut().position(is_free).map(|nth| self.pictures.remove(nth));
        self.pictures.truncate(1);
        free.unwrap_or_else(|| Painted {
            touched: self.touched.emptied(),
            picture: Arc::new(background.clone()),
        })
    }
}

/// What an earlier picture leaves for the next: memory that need not be asked for again.
#[derive(Default)]
struct Buffers {
    background: Layer,
    foreground: Layer,
    picture: Option<Picture>,
}

impl Buffers {
    fn of(still: Still) -> Self {
        let Still { background, foreground, pictures, .. } = still;
        let picture = pictures.into_iter().find_map(|painted| Arc::into_inner(painted.picture));
        Self { background, foreground, picture }
    }
}

/// Background and foreground.
fn paint_anew(painting: &Painting<'_>, samples: &Arc<SampleSet>, buffers: Buffers) -> Result<Still> {
    let (width, height) = painting.size();
    let frame = painting.frame;
    let Buffers { mut background, mut foreground, picture } = buffers;
    let (pixels, sums) = (width * height, if painting.blends() { width * height } else { 0 });
    background.reset(pixels, sums);
    painting.paint(0, &painting.bounds(frame.lasting()), &mut background)?;
    let mut touched = Blocks::none(width, height);
    if !frame.passing().is_empty() {
        foreground.reset(pixels, sums);
        let bounds = painting.bounds(frame.passing());
        touched.mark(&bounds, RING);
        painting.paint(frame.lasting_tiles, &bounds, &mut foreground)?;
    }
    let mut picture = picture
        .filter(|picture| picture.color.size() == (width, height))
        .unwrap_or_else(|| Picture::empty(width, height));
    let front = (!frame.passing().is_empty()).then_some(&foreground);
    painting.resolve(&background, front, None, (&Blocks::all(width, height), &mut picture))?;
    Ok(Still {
        samples: samples.clone(),
        images: frame.images[..frame.lasting_images].to_vec(),
        camera: painting.target.clone(),
        settings: painting.settings.clone(),
        background,
        background_picture: None,
        foreground,
        pictures: vec![Painted { picture: Arc::new(picture), touched: touched.clone() }],
        touched,
    })
}

/// The foreground alone, over the background that is there.
fn repaint(painting: &Painting<'_>, mut still: Still) -> Result<Still> {
    let (width, height) = painting.size();
    let background_picture = if let Some(picture) = still.background_picture.take() {
        picture
    } else {
        let Painted { picture, touched } = &still.pictures[0];
        let mut picture = (**picture).clone();
        painting.resolve(&still.background, None, None, (touched, &mut picture))?;
        picture
    };
    let pixels = width * height;
    still.foreground.keys.resize(pixels, 0);
    still.foreground.sums.resize(if painting.blends() { pixels } else { 0 }, [0.0; 4]);
    still.touched.clear(width, &mut still.foreground.keys, 0);
    if painting.blends() {
        still.touched.clear(width, &mut still.foreground.sums, [0.0; 4]);
    }
    let bounds = painting.bounds(painting.frame.passing());
    let mut touched = Blocks::none(width, height);
    touched.mark(&bounds, RING);
    painting.paint(painting.frame.lasting_tiles, &bounds, &mut still.foreground)?;
    let mut painted = still.free_picture(&background_picture);
    painted.touched.join(&touched);
    let picture = Arc::make_mut(&mut painted.picture);
    let front = Some(&still.foreground);
    painting.resolve(&still.background, front, Some(&background_picture), (&painted.touched, picture))?;
    painted.touched = touched.clone();
    still.pictures.insert(0, painted);
    still.touched = touched;
    still.background_picture = Some(background_picture);
    Ok(still)
}

/// Whether the vantage can be painted.
pub(super) fn check(samples: &SampleSet, vantage: &Vantage) -> Result<()> {
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
