//! What the stages work on: a built-in scene as nine cameras see it, the same in every run.
//!
//! ```text
//! nine-cameras, 3 frames ─┬─ frame 0, pruning off ─▶ unpruned: every pixel a sample, in one span of all frames
//!                         │                    └───▶ split: the same, a tenth of each picture in spans of one frame
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
use crate::render::Vantage;
use crate::settings::{CaptureSettings, PruningMethod, Settings};

/// The built-in scene that is measured.
pub const SCENE: &str = "nine-cameras";

/// Frames that are recorded; the spans of the sets run over all of them.
pub const FRAMES: usize = 3;

/// Share of the tiles that are foreground in [`Scene::split`].
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
    /// The unpruned set with a tenth of the tiles, one block in the middle of each picture, in spans of one frame.
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
        Ok(Self {
            split: Arc::new(split(&unpruned)),
            unpruned: Arc::new(unpruned),
            pruned: Arc::new(pruned),
            capture,
            home: demo.home(),
        })
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

/// For every image, which of its tiles show an object: the [`FOREGROUND_SHARE`] of all tiles whose middle samples lie nearest
/// to the point in the middle of the first image.
fn object_tiles(set: &SampleSet) -> Vec<Vec<bool>> {
    let middle_of = |image: &SampleImage, tile: usize| {
        let camera = &set.cameras[image.camera as usize];
        let tile_place = &image.tiles[tile];
        let nth = tile_place.count() / 2;
        let w = f64::from(image.depth.tile(tile, tile_place.first, tile_place.count()).get(nth));
        let corner = DVec2::new(f64::from(tile_place.tile_x), f64::from(tile_place.tile_y)) * TILE as f64;
        // Samples at infinity go far away.
        camera.unproject(corner + 0.5 * TILE as f64, 1.0 / w.max(1e-6))
    };
    let Some(first) = set.images.first() else { return Vec::new() };
    let anchor = middle_of(first, first.tiles.len() / 2);
    let mut distances: Vec<(f64, usize, usize)> = Vec::new();
    for (index, image) in set.images.iter().enumerate() {
        let tiles = 0..image.tiles.len();
        distances.extend(tiles.map(|tile| (middle_of(image, tile).distance(anchor), index, tile)));
    }
    distances.sort_by(|a, b| a.0.total_cmp(&b.0));
    let count = (FOREGROUND_SHARE * distances.len() as f64) as usize;
    let mut marked: Vec<Vec<bool>> = set.images.iter().map(|image| vec![false; image.tiles.len()]).collect();
    for (_, image, tile) in &distances[..count] {
        marked[*image][*tile] = true;
    }
    marked
}

/// The set with the foreground's tiles in spans of one frame, the same ones at every frame.
fn split(set: &SampleSet) -> SampleSet {
    let marked = object_tiles(set);
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
    use crate::render::CpuRenderer;
    use crate::settings::RenderSettings;

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
    fn the_split_set_shows_the_same_samples_at_every_frame_and_a_tenth_of_them_moves() {
        let scene = &*SCENE;
        for frame in 0..FRAMES {
            let at_frame: Vec<_> = scene.split.images_at(frame).collect();
            let samples: usize = at_frame.iter().map(|image| image.len()).sum();
            assert_eq!(samples as u64, scene.unpruned.sample_count());
            let moving = at_frame.iter().filter(|image| image.span.len() == 1);
            let share = moving.map(|image| image.len()).sum::<usize>() as f64 / samples as f64;
            assert!((0.05..0.2).contains(&share), "{share}");
        }
        let [vantage, _] = scene.vantages(SIZE, 1);
        let paint = |set| {
            let settings = RenderSettings::default();
            CpuRenderer::new().render(set, &vantage, &settings, &Job::new()).unwrap().0.inverse_depth.clone()
        };
        assert_eq!(paint(&scene.split), paint(&scene.unpruned));
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
