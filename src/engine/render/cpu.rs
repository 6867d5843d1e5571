//! The CPU renderer: the reference, which runs everywhere.
//!
//! Source: Interactive Dynamic Environments Using Image-Based Modeling and Rendering, §3.3: "We render the background images
//! once and paint the foreground over top for each consecutive time step. Only when the user moves vantage points do we
//! re-render the background." What differs: only blocks of the picture that the foreground leaves or enters are touched, and in
//! them only pixels beside which it is seen are painted; others are copied from the background's picture.

use std::cell::RefCell;
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use super::finish::{Finisher, changes_pictures, wants_fronts};
use super::gather::{RING, ScratchPool, SourceViews};
use super::geometry::{FootprintReach, MAX_STRETCH, TileBounds, bands, bounds};
use super::input::{BackgroundKey, CellTable, FrameImages, FrameSamples, TileIndex};
use super::orthographic::OrthographicView;
use super::resolve::{BlockSet, PaintedLayer, ResolveInput, resolve};
use super::splat::{BLEND_REACH, StageInput, blend, surface};
use super::stage_times::{Stage, StageClock};
use super::supersample::{finer, subpixels};
use super::vantage::{NO_FRONT, NO_IMAGE, Picture, RenderStats, Vantage};
use crate::capture::Camera;
use crate::error::Result;
use crate::job::Job;
use crate::samples::SampleSet;
use crate::settings::{Kernel, RenderSettings};

/// Finished pictures whose memory may be used again.
const KEPT_PICTURES: usize = 2;

/// Renders vantages, and keeps the background while the vantage is still.
#[derive(Debug, Default)]
pub struct CpuRenderer {
    cache: Option<VantageCache>,
    scratches: ScratchPool,
    finisher: Finisher,
    /// The last finished pictures. A caller may hold one of them; the memory of the other is used again.
    finished: Vec<Arc<Picture>>,
}

/// What is kept from one frame to the next while the vantage is still.
#[derive(Debug)]
struct VantageCache {
    key: BackgroundKey,
    /// The index of the background's tiles; moves on to the next frame.
    tile_index: TileIndex,
    /// Where these tiles are in the cameras, for the gather kernel.
    cells: Option<CellTable>,
    background: PaintedLayer,
    /// The picture of the background alone, and its holes; made for the second frame at the same vantage.
    background_picture: Option<(Picture, u64)>,
    foreground: PaintedLayer,
    /// The blocks that the foreground has touched.
    touched: BlockSet,
    /// The last picture and an earlier one. A caller may hold one of them; the other is painted over instead of copied.
    pictures: Vec<CachedPicture>,
}

/// A picture, and the blocks in which it may differ from that of the background.
#[derive(Debug)]
struct CachedPicture {
    picture: Arc<Picture>,
    touched: BlockSet,
    /// Pixels of the picture without a sample.
    holes: u64,
}

/// What one picture is painted from.
struct PictureInput<'a> {
    stage: StageInput<'a>,
    /// The vantage's camera, with as many pixels as the z-buffer.
    target: &'a Camera,
    /// Pixels of the z-buffer along each side of a pixel of the picture.
    subpixels: usize,
    settings: &'a RenderSettings,
    scratches: &'a ScratchPool,
    clock: RefCell<StageClock>,
}

impl PictureInput<'_> {
    /// Columns and rows of the picture.
    fn picture_size(&self) -> (usize, usize) {
        let (width, height) = self.target.intrinsics.size();
        (width / self.subpixels, height / self.subpixels)
    }

    fn bounds(&self, tiles: Range<usize>) -> Vec<TileBounds> {
        let reach = match self.stage.kernel {
            Kernel::Point => FootprintReach { pixels: 0.0, source_pixels: 0.0 },
            Kernel::Block => FootprintReach { pixels: 1.0, source_pixels: 0.0 },
            Kernel::Surfel => BLEND_REACH,
            Kernel::Gather => FootprintReach { pixels: 1.0, source_pixels: MAX_STRETCH },
        };
        let found = bounds(self.stage.frame, tiles, &self.stage.projectors, self.target, reach);
        self.end(Stage::Select);
        found
    }

    /// Counts the time since the last stage ended for this one.
    fn end(&self, stage: Stage) {
        self.clock.borrow_mut().end(stage);
    }

    /// Paints tiles into a layer, over what is there; their numbers begin with `first_tile`.
    fn paint(&self, first_tile: usize, bounds: &[TileBounds], layer: &mut PaintedLayer) -> Result<()> {
        let threads = rayon::current_num_threads();
        let (_, height) = self.target.intrinsics.size();
        let count = if threads == 1 { 1 } else { 2 * threads };
        let bands = bands(self.stage.frame, bounds, first_tile, height, count);
        self.end(Stage::Select);
        surface(&self.stage, &bands, &mut layer.keys)?;
        if self.stage.blends() {
            blend(&self.stage, &bands, &layer.keys, &mut layer.sums)?;
        }
        self.end(Stage::Paint);
        Ok(())
    }

    /// Resolves some blocks of a picture: of the cached background, over it a foreground if there is one. `background_picture` is
    /// that of the background alone, if it exists already.
    fn resolve(
        &self,
        cache: &VantageCache,
        foreground: Option<&PaintedLayer>,
        background_picture: Option<&Picture>,
        which: &BlockSet,
        picture: &mut Picture,
    ) -> Result<()> {
        self.scratches.forget();
        let (frame, cells) = (self.stage.frame, cache.cells.as_ref());
        let views = |table| SourceViews::new(frame, table, self.target, self.settings, self.subpixels);
        // Pixels without foreground are copied from the background's picture, if that exists already.
        let behind = cells.filter(|_| background_picture.is_none()).map(|cells| views(cells.clone()));
        let all = cells.filter(|_| foreground.is_some());
        let all = all.map(|cells| views(cells.clone().with(frame, frame.foreground_tiles())));
        let either = behind.as_ref().or(all.as_ref());
        let input = ResolveInput {
            stage: &self.stage,
            background: &cache.background,
            foreground,
            background_picture,
            views: either.map(|either| [either, all.as_ref().unwrap_or(either)]),
            scratches: self.scratches,
            subpixels: self.subpixels,
        };
        resolve(&input, which, picture)?;
        let spent = self.scratches.take_spent();
        self.clock.borrow_mut().end_both([Stage::Silhouettes, Stage::LookUp], spent);
        Ok(())
    }
}

impl CpuRenderer {
    /// A renderer with nothing cached.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Paints the samples of the vantage's frame. While a caller holds more than the last picture, pictures are copied.
    ///
    /// # Errors
    /// `Cancelled`; `Invalid` as [`Vantage::check`]; `Unsupported` where a frame has more samples than can be numbered.
    pub fn render(
        &mut self,
        samples: &Arc<SampleSet>,
        vantage: &Vantage,
        settings: &RenderSettings,
        job: &Job,
    ) -> Result<(Arc<Picture>, RenderStats)> {
        if vantage.camera.intrinsics.is_orthographic() {
            let view = OrthographicView::of_camera(samples, vantage)?;
            let (picture, stats) = self.render(&view.samples, &view.vantage, settings, job)?;
            return Ok((Arc::new(view.finish(&picture)), stats));
        }
        // From a thread of the pool a stage begins at once; from any other it wakes one and waits for it.
        rayon::scope(|_| self.render_in_pool(samples, vantage, settings, job))
    }

    /// [`CpuRenderer::render`] in perspective, on a thread of the pool.
    fn render_in_pool(
        &mut self,
        samples: &Arc<SampleSet>,
        vantage: &Vantage,
        settings: &RenderSettings,
        job: &Job,
    ) -> Result<(Arc<Picture>, RenderStats)> {
        let (started, clock) = (Instant::now(), RefCell::new(StageClock::start()));
        vantage.check(samples)?;
        let images = FrameImages::at(samples, vantage.frame);
        // Taken out, so that a canceled job leaves nothing half painted in the cache.
        let mut cache = self.cache.take();
        let key = BackgroundKey {
            samples: samples.clone(),
            images: images.background().to_vec(),
            camera: vantage.camera.clone(),
            settings: settings.clone(),
            subpixels: subpixels(samples, vantage, settings),
            with_fronts: wants_fronts(samples, images.all(), settings),
        };
        let reused = cache
            .as_mut()
            .filter(|cache| cache.key.matches(&key))
            .map(|cache| std::mem::take(&mut cache.tile_index));
        let background_reused = reused.is_some();
        let frame = FrameSamples::of(samples, vantage.frame, images, reused)?;
        let subpixels = key.subpixels;
        let target = finer(&vantage.camera, subpixels);
        let stage = StageInput::new(&frame, &target, settings, job);
        let scratches = &self.scratches;
        let input = PictureInput { stage, target: &target, subpixels, settings, scratches, clock };
        input.end(Stage::Select);
        let mut cache = match cache {
            Some(cache) if background_reused => paint_foreground(&input, cache)?,
            cache => paint_all(&input, key, cache)?,
        };
        let CachedPicture { picture, holes, .. } = &cache.pictures[0];
        let (mut picture, mut holes) = (picture.clone(), *holes);
        let mut clock = input.clock.into_inner();
        let painted = if background_reused { frame.foreground_tiles() } else { 0..frame.tile_count() };
        let painted = frame.sample_count(painted);
        cache.tile_index = frame.into_background_index();
        self.cache = Some(cache);
        if changes_pictures(settings) {
            let mut finished = self.copy_of(&picture);
            let changed = Arc::make_mut(&mut finished);
            clock.end(Stage::Copy);
            self.finisher.finish(changed, &picture.fronts, samples, vantage, settings, &mut clock)?;
            holes = finished.holes();
            self.finished.insert(0, finished.clone());
            self.finished.truncate(KEPT_PICTURES);
            picture = finished;
        }
        let stats = RenderStats {
            samples: painted,
            holes,
            milliseconds: started.elapsed().as_secs_f64() * 1e3,
            stages: clock.times(),
            background_reused,
        };
        Ok((picture, stats))
    }
}

impl CpuRenderer {
    /// A copy of a picture, without fronts, in the memory of a finished one that no caller holds if there is one.
    fn copy_of(&mut self, picture: &Picture) -> Arc<Picture> {
        let is_free = |kept: &mut Arc<Picture>| Arc::get_mut(kept).is_some();
        let free = self.finished.iter_mut().position(is_free).map(|nth| self.finished.swap_remove(nth));
        let mut copy = free
            .filter(|kept| kept.image.size() == picture.image.size())
            .unwrap_or_else(|| Arc::new(Picture::empty(picture.image.width(), picture.image.height())));
        let planes = Arc::make_mut(&mut copy);
        let Picture { color, inverse_depth, image, coverage, .. } = planes;
        coverage.clone_from(&picture.coverage);
        rayon::join(
            || color.as_mut_slice().copy_from_slice(picture.color.as_slice()),
            || {
                inverse_depth.as_mut_slice().copy_from_slice(picture.inverse_depth.as_slice());
                image.as_mut_slice().copy_from_slice(picture.image.as_slice());
            },
        );
        copy
    }
}

impl VantageCache {
    /// Memory for the next picture, whose z-buffer has a size: the background's layer, an empty foreground, and a picture that no caller
    /// holds.
    fn into_buffers(mut self, size: (usize, usize)) -> (PaintedLayer, PaintedLayer, Option<Picture>) {
        if finer(&self.key.camera, self.key.subpixels).intrinsics.size() == size {
            self.foreground.clear(&self.touched, size.0);
        } else {
            self.foreground = PaintedLayer::default();
        }
        let free = self.pictures.into_iter().find_map(|cached| Arc::into_inner(cached.picture));
        (self.background, self.foreground, free)
    }

    /// A picture that no caller holds; of the others, the last one is kept.
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

/// Paints background and foreground, into the memory of an earlier picture if there is one.
fn paint_all(
    input: &PictureInput<'_>,
    key: BackgroundKey,
    earlier: Option<VantageCache>,
) -> Result<VantageCache> {
    let (width, height) = input.target.intrinsics.size();
    let frame = input.stage.frame;
    let (mut background, mut foreground, picture) =
        earlier.map(|cache| cache.into_buffers((width, height))).unwrap_or_default();
    let (pixels, sums) = (width * height, if input.stage.blends() { width * height } else { 0 });
    background.reset(pixels, sums);
    input.paint(0, &input.bounds(frame.background_tiles()), &mut background)?;
    let mut touched = BlockSet::none(width, height);
    if frame.foreground_tiles().is_empty() {
        // For the next frame only touched blocks are cleared; the others must be empty already.
        foreground = PaintedLayer::default();
    } else {
        foreground.resize(pixels, sums);
        let bounds = input.bounds(frame.foreground_tiles());
        touched.mark(&bounds, RING);
        input.paint(frame.background_tile_count, &bounds, &mut foreground)?;
    }
    let mut cache = VantageCache {
        key,
        tile_index: TileIndex::default(),
        cells: (input.stage.kernel == Kernel::Gather)
            .then(|| CellTable::empty(&frame.set.cameras).with(frame, frame.background_tiles())),
        background,
        background_picture: None,
        foreground,
        pictures: Vec::new(),
        touched,
    };
    let mut picture = picture
        .filter(|picture| picture.color.size() == input.picture_size())
        .unwrap_or_else(|| Picture::empty(input.picture_size().0, input.picture_size().1));
    picture.fronts.resize(if cache.key.with_fronts { picture.image.len() } else { 0 }, NO_FRONT);
    picture.coverage.resize(if input.subpixels > 1 { picture.image.len() } else { 0 }, 1.0);
    let front = (!frame.foreground_tiles().is_empty()).then_some(&cache.foreground);
    input.resolve(&cache, front, None, &BlockSet::all(width, height), &mut picture)?;
    let (holes, touched) = (picture.holes(), cache.touched.clone());
    cache.pictures.push(CachedPicture { holes, picture: Arc::new(picture), touched });
    Ok(cache)
}

/// Paints the foreground alone, over the cached background.
fn paint_foreground(input: &PictureInput<'_>, mut cache: VantageCache) -> Result<VantageCache> {
    let (width, height) = input.target.intrinsics.size();
    let (background_picture, background_holes) = if let Some(kept) = cache.background_picture.take() {
        kept
    } else {
        let CachedPicture { picture, touched, .. } = &cache.pictures[0];
        let mut picture = (**picture).clone();
        input.resolve(&cache, None, None, touched, &mut picture)?;
        let holes = picture.holes();
        (picture, holes)
    };
    let pixels = width * height;
    cache.foreground.resize(pixels, if input.stage.blends() { pixels } else { 0 });
    cache.foreground.clear(&cache.touched, width);
    let bounds = input.bounds(input.stage.frame.foreground_tiles());
    let mut touched = BlockSet::none(width, height);
    touched.mark(&bounds, RING);
    input.paint(input.stage.frame.background_tile_count, &bounds, &mut cache.foreground)?;
    let mut painted = cache.free_picture(&background_picture);
    painted.touched.join(&touched);
    let picture = Arc::make_mut(&mut painted.picture);
    input.resolve(&cache, Some(&cache.foreground), Some(&background_picture), &painted.touched, picture)?;
    let (columns, _) = input.picture_size();
    let is_hole = |image: &u32| *image == NO_IMAGE;
    let holes_in =
        |picture: &Picture| touched.count(picture.image.as_slice(), columns, input.subpixels, is_hole);
    painted.holes = background_holes - holes_in(&background_picture) + holes_in(picture);
    painted.touched = touched.clone();
    cache.pictures.insert(0, painted);
    cache.touched = touched;
    cache.background_picture = Some((background_picture, background_holes));
    Ok(cache)
}
