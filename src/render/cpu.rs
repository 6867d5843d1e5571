//! The CPU renderer: the reference, and the one that runs everywhere.
//!
//! Source: Interactive Dynamic Environments Using Image-Based Modeling and Rendering, §3.3: "We render the background images
//! once and paint the foreground over top for each consecutive time step. Only when the user moves vantage points do we
//! re-render the background." What differs: only blocks of the picture that the foreground leaves or enters are touched, and in
//! them only pixels beside which it is seen are painted; others are copied from the background's picture.

use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use super::fill::fill;
use super::gather::{RING, ScratchPool, SourceViews};
use super::geometry::{
    FootprintReach, MAX_STRETCH, Projector, TileBounds, bands, bounds, focal, rays_in_world,
};
use super::input::{CellTable, FrameImages, FrameSamples, TileIndex};
use super::resolve::{BlockSet, PaintedLayer, ResolveInput, resolve};
use super::splat::{BLEND_REACH, SplatInput, blend, surface};
use super::vantage::{NO_IMAGE, Picture, RenderStats, Vantage};
use crate::capture::Camera;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::samples::SampleSet;
use crate::settings::{Fill, Kernel, RenderSettings};

/// Largest picture that is rendered, pixels: 16K by 8K.
pub const MAX_PIXELS: usize = 1 << 27;

/// Renders vantages, and keeps the background while the vantage is still.
#[derive(Debug, Default)]
pub struct CpuRenderer {
    still: Option<VantageCache>,
    scratches: ScratchPool,
}

/// What is kept from one frame to the next.
#[derive(Debug)]
struct VantageCache {
    samples: Arc<SampleSet>,
    /// Indices of the images that outlast the frame.
    images: Vec<usize>,
    camera: Camera,
    settings: RenderSettings,
    /// What is known of the tiles of these images; given to the next frame.
    numbers: TileIndex,
    /// Where these tiles lie in the cameras, for kernels that gather.
    cells: Option<CellTable>,
    background: PaintedLayer,
    /// The background alone, and its holes; made when the first frame follows at the same vantage.
    background_picture: Option<(Picture, u64)>,
    foreground: PaintedLayer,
    /// The blocks that the foreground has touched.
    touched: BlockSet,
    /// The last picture, and before it one that whoever asked for it may still hold: while they look at one, the other is
    /// painted over instead of copied.
    pictures: Vec<CachedPicture>,
}

/// A picture, and the blocks in which it may differ from the background's.
#[derive(Debug)]
struct CachedPicture {
    picture: Arc<Picture>,
    touched: BlockSet,
    /// Pixels of the picture without a sample.
    holes: u64,
}

/// What the stages of one picture are made of.
struct PictureInput<'a> {
    frame: &'a FrameSamples<'a>,
    target: &'a Camera,
    settings: &'a RenderSettings,
    projectors: Vec<Projector>,
    per_footprint: Vec<f32>,
    surface_ratio: f32,
    scratches: &'a ScratchPool,
    job: &'a Job,
}

impl<'a> PictureInput<'a> {
    fn new(
        frame: &'a FrameSamples<'a>,
        (target, settings): (&'a Camera, &'a RenderSettings),
        scratches: &'a ScratchPool,
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
            scratches,
            job,
        }
    }

    fn size(&self) -> (usize, usize) {
        self.target.intrinsics.size()
    }

    fn blends(&self) -> bool {
        matches!(self.settings.kernel, Kernel::Block | Kernel::Surfel)
    }

    fn bounds(&self, tiles: Range<usize>) -> Vec<TileBounds> {
        let reach = match self.settings.kernel {
            Kernel::Point => FootprintReach { pixels: 0.0, source_pixels: 0.0 },
            Kernel::Block => FootprintReach { pixels: 1.0, source_pixels: 0.0 },
            Kernel::Surfel => BLEND_REACH,
            Kernel::Gather => FootprintReach { pixels: 1.0, source_pixels: MAX_STRETCH },
        };
        bounds(self.frame, tiles, &self.projectors, self.target, reach)
    }

    /// Paints some tiles into a layer, over what is there.
    fn paint(&self, first_tile: usize, bounds: &[TileBounds], layer: &mut PaintedLayer) -> Result<()> {
        let (width, height) = self.size();
        let stage = SplatInput {
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

    /// Where the lasting tiles lie in the cameras, for kernels that gather.
    fn cells(&self) -> Option<CellTable> {
        let gathers = self.settings.kernel == Kernel::Gather;
        gathers.then(|| CellTable::empty(&self.frame.set.cameras).with(self.frame, self.frame.lasting()))
    }

    /// Resolves some blocks of a picture; without a foreground, those of the background alone.
    fn resolve(
        &self,
        (background, cells): (&PaintedLayer, Option<&CellTable>),
        foreground: Option<&PaintedLayer>,
        background_picture: Option<&Picture>,
        (which, picture): (&BlockSet, &mut Picture),
    ) -> Result<()> {
        self.scratches.forget();
        let among = |table| SourceViews::new(self.frame, table, self.target, self.settings.depth_tolerance);
        // Pixels without foreground are copied where the background's picture is there already.
        let lasting = cells.filter(|_| background_picture.is_none()).map(|cells| among(cells.clone()));
        let all = cells.filter(|_| foreground.is_some());
        let all = all.map(|cells| among(cells.clone().with(self.frame, self.frame.passing())));
        let either = lasting.as_ref().or(all.as_ref());
        let input = ResolveInput {
            frame: self.frame,
            kernel: self.settings.kernel,
            width: self.size().0,
            surface_ratio: self.surface_ratio,
            background,
            foreground,
            background_picture,
            views: either.map(|either| [either, all.as_ref().unwrap_or(either)]),
            scratches: self.scratches,
            job: self.job,
        };
        resolve(&input, which, picture)
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
        let images = FrameImages::at(samples, vantage.frame);
        // Taken out, so that a canceled job leaves nothing half painted behind.
        let mut still = self.still.take();
        let reused = still
            .as_mut()
            .filter(|still| still.shows(samples, images.lasting(), &vantage.camera, settings))
            .map(|still| std::mem::take(&mut still.numbers));
        let background_reused = reused.is_some();
        let frame = FrameSamples::of(samples, vantage.frame, images, reused)?;
        let painting = PictureInput::new(&frame, (&vantage.camera, settings), &self.scratches, job);
        let mut still = match still {
            Some(still) if background_reused => repaint(&painting, still)?,
            still => paint_anew(&painting, samples, still.map(RecycledBuffers::of).unwrap_or_default())?,
        };
        let CachedPicture { picture, holes, .. } = &still.pictures[0];
        let (mut picture, holes) = (picture.clone(), *holes);
        let painted = if background_reused { frame.passing() } else { 0..frame.tile_count() };
        let painted = frame.sample_count(painted);
        still.numbers = frame.into_lasting_numbers();
        self.still = Some(still);
        let filling = Instant::now();
        if settings.fill != Fill::None {
            fill(Arc::make_mut(&mut picture), &vantage.camera, settings);
        }
        let fill_ms = filling.elapsed().as_secs_f64() * 1e3;
        let stats = RenderStats {
            samples: painted,
            holes,
            milliseconds: started.elapsed().as_secs_f64() * 1e3,
            fill_ms,
            background_reused,
        };
        Ok((picture, stats))
    }
}

impl VantageCache {
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
    fn free_picture(&mut self, background: &Picture) -> CachedPicture {
        let is_free = |painted: &mut CachedPicture| Arc::get_mut(&mut painted.picture).is_some();
        let free = self.pictures.iter_mut().position(is_free).map(|nth| self.pictures.remove(nth));
        self.pictures.truncate(1);
        free.unwrap_or_else(|| CachedPicture {
            touched: self.touched.emptied(),
            picture: Arc::new(background.clone()),
            holes: 0,
        })
    }
}

/// What an earlier picture leaves for the next: memory that need not be asked for again.
#[derive(Default)]
struct RecycledBuffers {
    background: PaintedLayer,
    foreground: PaintedLayer,
    picture: Option<Picture>,
}

impl RecycledBuffers {
    fn of(still: VantageCache) -> Self {
        let VantageCache { background, foreground, pictures, .. } = still;
        let picture = pictures.into_iter().find_map(|painted| Arc::into_inner(painted.picture));
        Self { background, foreground, picture }
    }
}

/// Background and foreground.
fn paint_anew(
    painting: &PictureInput<'_>,
    samples: &Arc<SampleSet>,
    buffers: RecycledBuffers,
) -> Result<VantageCache> {
    let (width, height) = painting.size();
    let frame = painting.frame;
    let RecycledBuffers { mut background, mut foreground, picture } = buffers;
    let (pixels, sums) = (width * height, if painting.blends() { width * height } else { 0 });
    background.reset(pixels, sums);
    painting.paint(0, &painting.bounds(frame.lasting()), &mut background)?;
    let mut touched = BlockSet::none(width, height);
    if frame.passing().is_empty() {
        // When the next frame is painted over, only blocks that are touched are cleared: nothing may be left in others.
        foreground = PaintedLayer::default();
    } else {
        foreground.reset(pixels, sums);
        let bounds = painting.bounds(frame.passing());
        touched.mark(&bounds, RING);
        painting.paint(frame.lasting_tiles, &bounds, &mut foreground)?;
    }
    let mut picture = picture
        .filter(|picture| picture.color.size() == (width, height))
        .unwrap_or_else(|| Picture::empty(width, height));
    let front = (!frame.passing().is_empty()).then_some(&foreground);
    let cells = painting.cells();
    let all = BlockSet::all(width, height);
    painting.resolve((&background, cells.as_ref()), front, None, (&all, &mut picture))?;
    Ok(VantageCache {
        samples: samples.clone(),
        images: frame.images[..frame.lasting_images].to_vec(),
        camera: painting.target.clone(),
        settings: painting.settings.clone(),
        numbers: TileIndex::default(),
        cells,
        background,
        background_picture: None,
        foreground,
        pictures: vec![CachedPicture {
            holes: picture.holes(),
            picture: Arc::new(picture),
            touched: touched.clone(),
        }],
        touched,
    })
}

/// The foreground alone, over the background that is there.
fn repaint(painting: &PictureInput<'_>, mut still: VantageCache) -> Result<VantageCache> {
    let (width, height) = painting.size();
    let cells = still.cells.take();
    let (background_picture, background_holes) = if let Some(kept) = still.background_picture.take() {
        kept
    } else {
        let CachedPicture { picture, touched, .. } = &still.pictures[0];
        let mut picture = (**picture).clone();
        painting.resolve((&still.background, cells.as_ref()), None, None, (touched, &mut picture))?;
        let holes = picture.holes();
        (picture, holes)
    };
    let pixels = width * height;
    still.foreground.keys.resize(pixels, 0);
    still.foreground.sums.resize(if painting.blends() { pixels } else { 0 }, [0.0; 4]);
    still.touched.clear(width, &mut still.foreground.keys, 0);
    if painting.blends() {
        still.touched.clear(width, &mut still.foreground.sums, [0.0; 4]);
    }
    let bounds = painting.bounds(painting.frame.passing());
    let mut touched = BlockSet::none(width, height);
    touched.mark(&bounds, RING);
    painting.paint(painting.frame.lasting_tiles, &bounds, &mut still.foreground)?;
    let mut painted = still.free_picture(&background_picture);
    painted.touched.join(&touched);
    let picture = Arc::make_mut(&mut painted.picture);
    let (front, back) = (Some(&still.foreground), Some(&background_picture));
    painting.resolve((&still.background, cells.as_ref()), front, back, (&painted.touched, picture))?;
    let holes_in =
        |picture: &Picture| touched.count(width, picture.image.as_slice(), |image| *image == NO_IMAGE);
    painted.holes = background_holes - holes_in(&background_picture) + holes_in(picture);
    painted.touched = touched.clone();
    still.cells = cells;
    still.pictures.insert(0, painted);
    still.touched = touched;
    still.background_picture = Some((background_picture, background_holes));
    Ok(still)
}

/// Whether the vantage can be painted.
pub(crate) fn check(samples: &SampleSet, vantage: &Vantage) -> Result<()> {
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
