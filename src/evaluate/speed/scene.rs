//! What the stages work on: a built-in scene as nine cameras see it, the same in every run.
//!
//! ```text
//! nine-cameras, 3 frames ─┬─ frame 0, pruning off ─▶ unpruned: every pixel a sample, in one span of all frames
//!                         │                    └───▶ split: the same, an object on a tenth of the picture in spans of one frame
//!                         └─ frame 0, defaults ────▶ pruned, in one span of all frames
//! ```

use std::sync::Arc;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::capture::demo::{Demo, DemoSpec};
use crate::capture::{Camera, Capture, Intrinsics};
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::{DepthPlane, SampleImage, SampleSet, SampleTile, Span, TILE, inspect_frame};
use crate::render::{CpuRenderer, Vantage};
use crate::settings::{CaptureSettings, PruningMethod, RenderSettings, Settings};

/// The built-in scene that is measured.
pub const SCENE: &str = "nine-cameras";

/// Frames that are recorded; the spans of the sets run over all of them.
pub const FRAMES: usize = 3;

/// Share of the picture from [`Scene::vantages`] that shows foreground in [`Scene::split`].
const FOREGROUND_SHARE: f64 = 0.1;

/// How far the second of two vantages stands beside the first, m: too little to change what is seen, enough for no cache
/// to serve both.
const SIDE_STEP_M: f64 = 1e-6;

/// Seeded input for every stage.
#[derive(Debug)]
pub struct Scene {
    /// All frames, traced and in memory.
    pub capture: Capture,
    /// Every pixel of every camera at one frame, in camera order.
    pub unpruned: Arc<SampleSet>,
    /// What default settings keep of it.
    pub pruned: Arc<SampleSet>,
    /// The unpruned set with the tiles that show a ball in the middle of the scene in spans of one frame; it covers a tenth of the
    /// picture from [`Scene::vantages`].
    pub split: Arc<SampleSet>,
    home: Camera,
}

impl Scene {
    /// Records the scene with cameras of `size` and prunes it.
    ///
    /// # Errors
    /// `Cancelled`, and what recording and pruning give.
    pub fn new(size: (u32, u32), job: &Job) -> Result<Self> {
        let (demo, capture) = recorded(SCENE, FRAMES, size, job)?;
        let mut settings = Settings::default();
        let pruned = one_span(&inspect_frame(&capture, None, &settings, 0, job)?.samples);
        settings.pruning.method = PruningMethod::Off;
        let unpruned = one_span(&inspect_frame(&capture, None, &settings, 0, job)?.samples);
        let unpruned = Arc::new(unpruned);
        let whole =
            Self { split: unpruned.clone(), unpruned, pruned: Arc::new(pruned), capture, home: demo.home() };
        let split = split(&whole.unpruned, &whole.object(size, job)?);
        Ok(Self { split: Arc::new(split), ..whole })
    }

    /// The ball around what the middle of the picture shows that covers [`FOREGROUND_SHARE`] of the picture.
    fn object(&self, size: (u32, u32), job: &Job) -> Result<Ball> {
        let [vantage, _] = self.vantages(size, 0);
        let settings = RenderSettings::default();
        let (picture, _) = CpuRenderer::new().render(&self.unpruned, &vantage, &settings, job)?;
        let (width, height) = picture.inverse_depth.size();
        let point_at = |pixel: (usize, usize)| {
            let center = DVec2::new(pixel.0 as f64 + 0.5, pixel.1 as f64 + 0.5);
            point_in_world(&vantage.camera, center, picture.inverse_depth[pixel])
        };
        let center_in_world = point_at((width / 2, height / 2));
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let shown = pixels.filter(|pixel| picture.shows(*pixel));
        let mut distances: Vec<f64> = shown.map(|pixel| point_at(pixel).distance(center_in_world)).collect();
        distances.sort_by(f64::total_cmp);
        let nth = (FOREGROUND_SHARE * (width * height) as f64) as usize;
        Ok(Ball { center_in_world, radius_m: distances.get(nth).copied().unwrap_or(0.0) })
    }

    /// A place between the cameras from which the scene fills the picture, as a picture of `size` at `frame`; and one so
    /// close beside it that it shows the same.
    #[must_use]
    pub fn vantages(&self, size: (u32, u32), frame: usize) -> [Vantage; 2] {
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

/// A built-in scene all of whose frames are traced and stay in memory.
///
/// # Errors
/// `Cancelled`, and `Invalid` where there is no such scene.
pub fn recorded(scene: &str, frames: usize, size: (u32, u32), job: &Job) -> Result<(Demo, Capture)> {
    let spec = DemoSpec {
        scene: scene.to_owned(),
        cameras: None,
        frames: Some(frames),
        size: Some(size),
        noise: None,
    };
    let demo = Demo::new(&spec)?;
    let capture = demo.capture(&CaptureSettings { cache: 4096 });
    let cameras = capture.cameras.len();
    job.start("Recording the scene", cameras * frames);
    (0..cameras * frames).into_par_iter().try_for_each(|index| {
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

/// Which tiles of an image show an object: those whose middle sample lies in it.
fn object_tiles(camera: &Camera, image: &SampleImage, object: &Ball) -> Vec<bool> {
    let shows_object = |(index, tile): (usize, &SampleTile)| {
        let nth = tile.count() / 2;
        let inverse_depth = image.depth.tile(index, tile.first, tile.count()).get(nth);
        let corner = DVec2::new(f64::from(tile.tile_x), f64::from(tile.tile_y)) * TILE as f64;
        let middle = point_in_world(camera, corner + 0.5 * TILE as f64, inverse_depth);
        middle.distance(object.center_in_world) <= object.radius_m
    };
    image.tiles.iter().enumerate().map(shows_object).collect()
}

/// The set with the tiles that show an object in spans of one frame, the same ones at every frame.
fn split(set: &SampleSet, object: &Ball) -> SampleSet {
    let tiles_of =
        |image: &Arc<SampleImage>| object_tiles(&set.cameras[image.camera as usize], image, object);
    let marked: Vec<Vec<bool>> = set.images.iter().map(tiles_of).collect();
    let frames = (0..FRAMES as u32).map(|start| Span { start, end: start + 1 });
    let of_span = |span: Span| {
        let foreground = span != ALL_FRAMES;
        let images = set.images.iter().zip(&marked);
        images
            .map(move |(image, marked)| Arc::new(tiles_where(image, span, |tile| marked[tile] == foreground)))
    };
    let images = of_span(ALL_FRAMES).chain(frames.flat_map(of_span));
    SampleSet { images: images.filter(|image| !image.is_empty()).collect(), ..set.clone() }
}

/// The image's tiles for whose index `keep` holds, as an image of `span`.
fn tiles_where(image: &SampleImage, span: Span, keep: impl Fn(usize) -> bool) -> SampleImage {
    let mut part = SampleImage {
        camera: image.camera,
        span,
        tiles: Vec::new(),
        color: Vec::new(),
        depth: DepthPlane::default(),
        normal: image.normal.as_ref().map(|_| Vec::new()),
    };
    let inverse_depths = image.inverse_depths();
    let mut kept_depths = Vec::new();
    for (_, tile) in image.tiles.iter().enumerate().filter(|(index, _)| keep(*index)) {
        let samples = tile.first as usize..tile.first as usize + tile.count();
        part.tiles.push(SampleTile { first: kept_depths.len() as u32, ..*tile });
        part.color.extend_from_slice(&image.color[samples.clone()]);
        kept_depths.extend_from_slice(&inverse_depths[samples.clone()]);
        if let (Some(part), Some(normals)) = (&mut part.normal, &image.normal) {
            part.extend_from_slice(&normals[samples]);
        }
    }
    part.depth = DepthPlane::pack(&part.tiles, &kept_depths);
    part
}

#[cfg(test)]
mod tests {
    use std::sync::LazyLock;

    use super::*;
    const SIZE: (u32, u32) = (96, 64);

    static SCENE: LazyLock<Scene> = LazyLock::new(scene);

    fn scene() -> Scene {
        Scene::new(SIZE, &Job::new()).unwrap()
    }

    #[test]
    fn two_scenes_are_the_same() {
        let (a, b) = (&*SCENE, scene());
        for (a, b) in [(&a.unpruned, &b.unpruned), (&a.pruned, &b.pruned), (&a.split, &b.split)] {
            assert_eq!(a.images, b.images);
        }
        assert_eq!(a.vantages(SIZE, 1), b.vantages(SIZE, 1));
    }

    #[test]
    fn every_pixel_of_nine_cameras_is_a_sample_and_pruning_drops_some() {
        let scene = &*SCENE;
        assert_eq!(scene.unpruned.sample_count(), 9 * 96 * 64);
        assert!(scene.unpruned.images.is_sorted_by_key(|image| image.camera));
        assert!(scene.pruned.sample_count() < scene.unpruned.sample_count());
        let images = scene.unpruned.images.iter().chain(&scene.pruned.images);
        assert!(images.into_iter().all(|image| image.span == ALL_FRAMES));
    }

    #[test]
    fn the_split_set_shows_the_same_samples_at_every_frame_and_moves_on_a_tenth_of_the_picture() {
        let scene = &*SCENE;
        for frame in 0..FRAMES {
            let at_frame: Vec<_> = scene.split.images_at(frame).collect();
            let samples: usize = at_frame.iter().map(|image| image.len()).sum();
            assert_eq!(samples as u64, scene.unpruned.sample_count());
        }
        let [vantage, _] = scene.vantages(SIZE, 1);
        let paint = |set| {
            let settings = RenderSettings::default();
            CpuRenderer::new().render(set, &vantage, &settings, &Job::new()).unwrap().0
        };
        let split = paint(&scene.split);
        assert_eq!(split.inverse_depth, paint(&scene.unpruned).inverse_depth);
        let moves = |image: &&u32| {
            scene.split.images.get(**image as usize).is_some_and(|image| image.span.len() == 1)
        };
        let share = split.image.as_slice().iter().filter(moves).count() as f64 / f64::from(SIZE.0 * SIZE.1);
        assert!((0.07..0.13).contains(&share), "{share}");
    }

    #[test]
    fn the_scene_fills_the_picture() {
        let scene = &*SCENE;
        for vantage in scene.vantages(SIZE, 0) {
            let settings = RenderSettings::default();
            let (picture, _) =
                CpuRenderer::new().render(&scene.unpruned, &vantage, &settings, &Job::new()).unwrap();
            assert!((picture.holes() as f64) < 0.02 * 96.0 * 64.0, "{} holes", picture.holes());
        }
    }
}
