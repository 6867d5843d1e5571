//! What the stages work on: a built-in scene as nine cameras see it, the same in every run.
//!
//! ```text
//! nine-cameras, 3 frames ─┬─ frame 0, pruning off ─▶ unpruned: every pixel a sample, in one span of all frames
//!                         │                    └───▶ split: the same, an object on a tenth of the picture in spans of one frame
//!                         └─ frame 0, defaults ────▶ pruned, in one span of all frames
//! ```

use std::sync::{Arc, OnceLock};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::animation::{self, Animation};
use overlook_engine::capture::{Camera, Capture, Intrinsics};
use overlook_engine::demo::{Demo, DemoSpec};
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::preprocess::inspect_frame;
use overlook_engine::render::{CpuRenderer, Vantage};
use overlook_engine::samples::{Sample, SampleImage, SampleSet, SampleTile, Span, TILE};
use overlook_engine::settings::{CaptureSettings, Fill, PruningMethod, RenderSettings, Settings};

/// The built-in scene that is measured.
pub(crate) const SCENE: &str = "nine-cameras";

/// Frames that are recorded; the spans of the sets run over all of them.
pub(crate) const FRAMES: usize = 3;

/// Share of the picture from [`BenchScene::vantages`] that shows foreground in [`BenchScene::split`].
const FOREGROUND_SHARE: f64 = 0.1;

/// Distance of the two vantages, m: too small to change the picture, enough that no cache serves both.
const SIDE_STEP_M: f64 = 1e-6;

/// The default settings of rendering, but for holes: finding and filling them takes the same time after every kernel, so that
/// measured kernels leave them.
pub(crate) fn without_filling() -> RenderSettings {
    RenderSettings { fill: Fill::None, free_space: false, ..RenderSettings::default() }
}

/// Seeded input for every stage.
#[derive(Debug)]
pub(crate) struct BenchScene {
    /// All frames, traced and in memory.
    pub(crate) capture: Capture,
    /// Every pixel of every camera at one frame, in camera order.
    pub(crate) unpruned: Arc<SampleSet>,
    /// What default settings keep of it.
    pub(crate) pruned: Arc<SampleSet>,
    /// The unpruned set with part of the scene in spans of one frame: about a tenth of the picture from [`BenchScene::vantages`]
    /// and of the samples.
    pub(crate) split: Arc<SampleSet>,
    home: Camera,
    size: (u32, u32),
    /// Recorded when a default picture is first measured.
    animations: OnceLock<Vec<Animation>>,
}

impl BenchScene {
    /// Records the scene with cameras of `size` and prunes it.
    pub(crate) fn new(size: (u32, u32), job: &Job) -> Result<Self> {
        let (demo, capture) = recorded(size, job)?;
        let mut settings = Settings::default();
        let pruned = one_span(&inspect_frame(&capture, None, &settings, 0, job)?.samples);
        settings.pruning.method = PruningMethod::Off;
        let unpruned = one_span(&inspect_frame(&capture, None, &settings, 0, job)?.samples);
        let unpruned = Arc::new(unpruned);
        let whole = Self {
            split: unpruned.clone(),
            unpruned,
            pruned: Arc::new(pruned),
            capture,
            home: demo.home(),
            size,
            animations: OnceLock::new(),
        };
        let split = split(&whole.unpruned, &whole.object(size, job)?);
        Ok(Self { split: Arc::new(split), ..whole })
    }

    /// The animations whose default pictures are measured.
    pub(super) fn animations(&self, job: &Job) -> Result<&[Animation]> {
        if let Some(animations) = self.animations.get() {
            return Ok(animations);
        }
        let animations = animation::animations(self.size, job)?;
        Ok(self.animations.get_or_init(|| animations))
    }

    /// A ball that covers [`FOREGROUND_SHARE`] of the picture and holds about that share of the samples: there are more where
    /// more cameras are near.
    fn object(&self, size: (u32, u32), job: &Job) -> Result<Ball> {
        // The shape of the larger of the measured pictures.
        let [vantage, _] = self.vantages((size.0, size.0 * 9 / 16), 0);
        let settings = without_filling();
        let (picture, _) = CpuRenderer::new().render(&self.unpruned, &vantage, &settings, job)?;
        let (width, height) = picture.inverse_depth.size();
        let pixels = |step: usize| {
            let rows = (step / 2..height).step_by(step);
            rows.flat_map(move |y| (step / 2..width).step_by(step).map(move |x| (x, y)))
        };
        let point_at = |pixel: (usize, usize)| {
            let center = DVec2::new(pixel.0 as f64 + 0.5, pixel.1 as f64 + 0.5);
            point_in_world(&vantage.camera, center, picture.inverse_depth[pixel])
        };
        let points_of = |step| pixels(step).filter(|pixel| picture.shows(*pixel)).map(point_at);
        let shown: Vec<DVec3> = points_of((width / 160).max(1)).collect();
        let sampled: Vec<DVec3> =
            self.unpruned.images.iter().flat_map(|image| self.some_points(image)).collect();
        let around = |center_in_world: DVec3| {
            let mut distances: Vec<f64> = shown.iter().map(|point| point.distance(center_in_world)).collect();
            distances.sort_by(f64::total_cmp);
            let radius_m = distances[(FOREGROUND_SHARE * distances.len() as f64) as usize];
            Ball { center_in_world, radius_m }
        };
        let excess = |ball: &Ball| {
            let held = sampled.iter().filter(|point| ball.holds(**point)).count();
            (held as f64 / sampled.len() as f64 - FOREGROUND_SHARE).abs()
        };
        let balls = points_of((width / 12).max(1)).map(around);
        let best = balls.map(|ball| (excess(&ball), ball)).min_by(|a, b| a.0.total_cmp(&b.0));
        Ok(best.map_or(Ball { center_in_world: DVec3::ZERO, radius_m: 0.0 }, |(_, ball)| ball))
    }

    /// What the first sample of each tile of an image shows.
    fn some_points(&self, image: &SampleImage) -> Vec<DVec3> {
        let camera = &self.unpruned.cameras[image.camera as usize];
        let first_of = |(index, tile): (usize, &SampleTile)| {
            let corner = DVec2::new(f64::from(tile.tile_x), f64::from(tile.tile_y)) * TILE as f64;
            let inverse_depth = image.depth.tile(index, tile.first, tile.count()).get(0);
            point_in_world(camera, corner + 0.5, inverse_depth)
        };
        image.tiles.iter().enumerate().map(first_of).collect()
    }

    /// A vantage between the cameras whose picture the scene fills, and one right beside it that shows the same.
    pub(crate) fn vantages(&self, size: (u32, u32), frame: usize) -> [Vantage; 2] {
        let home = self.home.intrinsics;
        let angle_x_rad = 2.0 * (f64::from(home.width) / (2.0 * home.fx)).atan();
        [0.0, SIDE_STEP_M].map(|step| {
            let mut camera = self.home.clone();
            camera.intrinsics = Intrinsics::from_horizontal_angle(size.0, size.1, angle_x_rad);
            camera.world_from_camera.translation += DVec3::X * step;
            Vantage { camera, frame }
        })
    }
}

/// The built-in scene with all frames traced and in memory.
fn recorded(size: (u32, u32), job: &Job) -> Result<(Demo, Capture)> {
    let spec = DemoSpec::new(SCENE).frames(FRAMES).size(size);
    let demo = Demo::new(&spec)?;
    let capture = demo.capture(&CaptureSettings { memory: 4096, ..CaptureSettings::default() });
    let cameras = capture.cameras.len();
    job.start("Recording the scene", cameras * FRAMES);
    (0..cameras * FRAMES).into_par_iter().try_for_each(|index| {
        job.check()?;
        capture.frame(index % cameras, index / cameras)?;
        job.advance(1);
        Ok(())
    })?;
    Ok((demo, capture))
}

const ALL_FRAMES: Span = Span { start: 0, end: FRAMES as u32 };

/// The set with every image over all frames.
fn one_span(set: &SampleSet) -> SampleSet {
    let images = set.images.iter().map(|image| {
        let image = SampleImage { span: ALL_FRAMES, ..image.as_ref().clone() };
        Arc::new(image)
    });
    SampleSet { images: images.collect(), ..set.clone() }
}

/// A part of space.
#[derive(Clone, Copy, Debug)]
struct Ball {
    center_in_world: DVec3,
    radius_m: f64,
}

/// The point that a pixel of a camera shows; those at infinity are far away.
fn point_in_world(camera: &Camera, pixel: DVec2, inverse_depth: f32) -> DVec3 {
    camera.unproject(pixel, 1.0 / f64::from(inverse_depth).max(1e-6))
}

impl Ball {
    fn holds(&self, point_in_world: DVec3) -> bool {
        point_in_world.distance(self.center_in_world) <= self.radius_m
    }
}

/// The set with the samples of an object in spans of one frame, the same ones at every frame.
fn split(set: &SampleSet, object: &Ball) -> SampleSet {
    let frames = (0..FRAMES as u32).map(|start| Span { start, end: start + 1 });
    let of_span = |span: Span| {
        let camera = |image: &SampleImage| &set.cameras[image.camera as usize];
        let images = set.images.iter();
        images.map(move |image| {
            let shows_object = |sample: &Sample, inverse_depth: f32| {
                let center = DVec2::new(sample.x as f64 + 0.5, sample.y as f64 + 0.5);
                object.holds(point_in_world(camera(image), center, inverse_depth))
            };
            let foreground = span != ALL_FRAMES;
            Arc::new(image.part(span, |sample, w| shows_object(sample, w) == foreground))
        })
    };
    let images = of_span(ALL_FRAMES).chain(frames.flat_map(of_span));
    SampleSet { images: images.filter(|image| !image.is_empty()).collect(), ..set.clone() }
}

#[cfg(test)]
mod tests {
    use std::sync::LazyLock;

    use super::*;
    const SIZE: (u32, u32) = (96, 64);

    static SMALL: LazyLock<BenchScene> = LazyLock::new(scene);

    fn scene() -> BenchScene {
        BenchScene::new(SIZE, &Job::new()).unwrap()
    }

    #[test]
    fn two_scenes_are_the_same() {
        let (a, b) = (&*SMALL, scene());
        for (a, b) in [(&a.unpruned, &b.unpruned), (&a.pruned, &b.pruned), (&a.split, &b.split)] {
            assert_eq!(a.images, b.images);
        }
        assert_eq!(a.vantages(SIZE, 1), b.vantages(SIZE, 1));
    }

    #[test]
    fn every_pixel_of_nine_cameras_is_a_sample_and_pruning_drops_some() {
        let scene = &*SMALL;
        assert_eq!(scene.unpruned.sample_count(), 9 * 96 * 64);
        assert!(scene.unpruned.images.is_sorted_by_key(|image| image.camera));
        assert!(scene.pruned.sample_count() < scene.unpruned.sample_count());
        let images = scene.unpruned.images.iter().chain(&scene.pruned.images);
        assert!(images.into_iter().all(|image| image.span == ALL_FRAMES));
    }

    #[test]
    fn the_split_set_shows_the_same_samples_at_every_frame_and_moves_on_a_tenth_of_the_picture() {
        let scene = &*SMALL;
        for frame in 0..FRAMES {
            let at_frame: Vec<_> = scene.split.images_at(frame).collect();
            let samples: usize = at_frame.iter().map(|image| image.len()).sum();
            assert_eq!(samples as u64, scene.unpruned.sample_count());
        }
        let [vantage, _] = scene.vantages(SIZE, 1);
        let paint = |set| {
            let settings = without_filling();
            CpuRenderer::new().render(set, &vantage, &settings, &Job::new()).unwrap().0
        };
        let (split, unpruned) = (paint(&scene.split), paint(&scene.unpruned));
        // Where samples were split, a slope may be taken from the other side.
        let depths = split.inverse_depth.as_slice().iter().zip(unpruned.inverse_depth.as_slice());
        let unlike = depths.filter(|(a, b)| (**a - **b).abs() > 0.01 * b.abs()).count();
        assert!(unlike < 200, "{unlike}");
        let moves = |image: &&u32| {
            scene.split.images.get(**image as usize).is_some_and(|image| image.span.len() == 1)
        };
        let share = split.image.as_slice().iter().filter(moves).count() as f64 / f64::from(SIZE.0 * SIZE.1);
        assert!((0.07..0.13).contains(&share), "{share}");
    }

    #[test]
    fn the_scene_fills_the_picture() {
        let scene = &*SMALL;
        for vantage in scene.vantages(SIZE, 0) {
            let settings = without_filling();
            let (picture, _) =
                CpuRenderer::new().render(&scene.unpruned, &vantage, &settings, &Job::new()).unwrap();
            assert!((picture.holes() as f64) < 0.02 * 96.0 * 64.0, "{} holes", picture.holes());
        }
    }
}
