//! Built-in scenes, traced on demand: exact depth and normals at pixel centers, truth for any vantage.
//!
//! ```text
//! scenes: orrery, nine_cameras, ─── tracer: world (solids, light) ──── trace ── Frame
//!         four_cameras, crystal             shapes, hits, bvh, shadow_map    └─ shade, texture, camera_noise
//!               └─ props, materials
//! ```
//!
//! Surfaces are diffuse: a point has one color at a time, whoever looks. World space is in meters, z up.

mod scenes;
mod tracer;

use std::sync::Arc;

use glam::DVec3;

use crate::capture::{Camera, Capture, CaptureParts, Frame, FrameSource, TruthView};
use crate::error::{Error, Result};
use crate::settings::CaptureSettings;
use scenes::SceneCameras;
pub use tracer::with_render_noise;
use tracer::{RenderNoise, WantedPlanes, World, WorldBuilder};

/// Names and one-line descriptions of the built-in scenes, the default first.
pub const SCENES: &[(&str, &str)] = &[
    (ORRERY.name, ORRERY.description),
    (NINE_CAMERAS.name, NINE_CAMERAS.description),
    (FOUR_CAMERAS.name, FOUR_CAMERAS.description),
    (CRYSTAL.name, CRYSTAL.description),
];

/// Most cameras a demo is recorded with.
pub const MAX_CAMERAS: usize = 320;
/// Most frames a demo is recorded for.
pub const MAX_FRAMES: usize = 100_000;
/// Most columns or rows of a demo's pictures.
pub const MAX_SIZE: u32 = 16_384;
/// Frames of the animation, evenly spread, at which each truth vantage looks.
const TRUTH_FRAMES: usize = 5;

/// Which scene, and how it is recorded. `None` keeps the scene's own value.
#[derive(Clone, Debug, PartialEq)]
pub struct DemoSpec {
    /// One of [`SCENES`].
    pub scene: String,
    /// Number of cameras, 1 to [`MAX_CAMERAS`]: the scene's own first, then more around it.
    pub cameras: Option<usize>,
    /// Number of frames, 1 to [`MAX_FRAMES`], spread over the whole animation.
    pub frames: Option<usize>,
    /// Columns and rows of every camera, 1 to [`MAX_SIZE`] each. The horizontal angle of view stays.
    pub size: Option<(u32, u32)>,
    /// Relative standard deviation of the renderer-like color noise, 0 (none) to 1.
    pub noise: Option<f32>,
}

/// A scene and the way it is recorded by default.
#[derive(Debug)]
struct DemoScene {
    name: &'static str,
    description: &'static str,
    /// The solids at a moment of the animation, 0 to 1, in the same order at every moment.
    stage: fn(f64) -> WorldBuilder,
    /// The cameras of the scene and its further viewpoints.
    cameras: fn() -> SceneCameras,
    frames: usize,
    size: (u32, u32),
    noise: f32,
    antialiased: bool,
    normals: bool,
    /// Tells the noise of the scenes apart.
    seed: u64,
}

impl DemoSpec {
    /// A scene recorded the way of its own.
    #[must_use]
    pub fn new(scene: impl Into<String>) -> Self {
        Self { scene: scene.into(), cameras: None, frames: None, size: None, noise: None }
    }

    /// The same with another number of cameras.
    #[must_use]
    pub fn cameras(self, cameras: usize) -> Self {
        Self { cameras: Some(cameras), ..self }
    }

    /// The same with another number of frames.
    #[must_use]
    pub fn frames(self, frames: usize) -> Self {
        Self { frames: Some(frames), ..self }
    }

    /// The same with other columns and rows.
    #[must_use]
    pub fn size(self, size: (u32, u32)) -> Self {
        Self { size: Some(size), ..self }
    }

    /// The same with other noise.
    #[must_use]
    pub fn noise(self, noise: f32) -> Self {
        Self { noise: Some(noise), ..self }
    }
}

impl DemoScene {
    /// The scene at a moment of its animation, 0 to 1.
    fn world(&self, moment: f64) -> World {
        (self.stage)(moment).build()
    }
}

const ORRERY: DemoScene = DemoScene {
    name: "orrery",
    description: "a brass orrery on a table: 5 cameras, 48 frames that loop, normals",
    stage: scenes::orrery::stage,
    cameras: scenes::orrery::cameras,
    frames: 48,
    size: (480, 360),
    noise: 0.0,
    antialiased: false,
    normals: true,
    seed: 1,
};

const NINE_CAMERAS: DemoScene = DemoScene {
    name: "nine-cameras",
    description: "a living room with a toy train: 9 cameras, 60 frames, anti-aliased and noisy color, no normals",
    stage: scenes::nine_cameras::stage,
    cameras: scenes::nine_cameras::cameras,
    frames: 60,
    size: (640, 480),
    noise: 0.03,
    antialiased: true,
    normals: false,
    seed: 2,
};

const FOUR_CAMERAS: DemoScene = DemoScene {
    name: "four-cameras",
    description: "crystals that grow on a laboratory bench: 4 cameras, 300 frames, normals",
    stage: scenes::four_cameras::stage,
    cameras: scenes::four_cameras::cameras,
    frames: 300,
    size: (320, 240),
    noise: 0.0,
    antialiased: false,
    normals: true,
    seed: 3,
};

const CRYSTAL: DemoScene = DemoScene {
    name: "crystal",
    description: "a melt that condenses into rock salt: 6 cameras, 60 frames, anti-aliased color, normals, white around",
    stage: scenes::crystal::stage,
    cameras: scenes::crystal::cameras,
    frames: 60,
    size: (640, 480),
    noise: 0.0,
    antialiased: true,
    normals: true,
    seed: 4,
};

const ALL: [&DemoScene; 4] = [&ORRERY, &NINE_CAMERAS, &FOUR_CAMERAS, &CRYSTAL];

/// A built-in scene with its recording decided.
#[derive(Clone, Debug)]
pub struct Demo {
    scene: &'static DemoScene,
    cameras: Vec<Camera>,
    novel: Vec<Camera>,
    frames: usize,
    noise: f32,
}

impl Demo {
    /// Decides the recording.
    ///
    /// # Errors
    /// `Invalid` for an unknown scene, and for a count, size or noise out of the ranges that [`DemoSpec`] states.
    pub fn new(spec: &DemoSpec) -> Result<Self> {
        let index = SCENES.iter().position(|(name, _)| *name == spec.scene).ok_or_else(|| {
            let names: Vec<_> = SCENES.iter().map(|(name, _)| *name).collect();
            Error::invalid(
                format!("demo '{}'", spec.scene),
                format!("there is no such scene; choose one of {}", names.join(", ")),
            )
        })?;
        let scene = ALL[index];
        let of_scene = (scene.cameras)();
        let cameras = spec.cameras.unwrap_or(of_scene.cameras.len());
        let frames = spec.frames.unwrap_or(scene.frames);
        let size = spec.size.unwrap_or(scene.size);
        let noise = spec.noise.unwrap_or(scene.noise);
        check(scene, "cameras", cameras as f64, 1.0..=MAX_CAMERAS as f64)?;
        check(scene, "frames", frames as f64, 1.0..=MAX_FRAMES as f64)?;
        check(scene, "columns", f64::from(size.0), 1.0..=f64::from(MAX_SIZE))?;
        check(scene, "rows", f64::from(size.1), 1.0..=f64::from(MAX_SIZE))?;
        check(scene, "noise", f64::from(noise), 0.0..=1.0)?;
        let novel = of_scene.novel.iter().map(|vantage| vantage.camera(size)).collect();
        Ok(Self { scene, cameras: of_scene.cameras(cameras, size), novel, frames, noise })
    }

    /// The scene as a capture whose frames are traced on demand.
    #[must_use]
    pub fn capture(&self, settings: &CaptureSettings) -> Capture {
        let parts = CaptureParts {
            name: self.scene.name.to_owned(),
            cameras: self.cameras.clone(),
            frame_numbers: (0..self.frames as i64).collect(),
            up_in_world: DVec3::Z,
            has_normals: self.scene.normals,
            antialiased_color: self.scene.antialiased,
            warnings: Vec::new(),
            source: Arc::new(self.clone()),
        };
        Capture::new(parts, settings.frame_cache_bytes())
    }

    /// Vantages without a camera, with truth: three, each at up to five frames spread over the animation.
    #[must_use]
    pub fn truth_views(&self) -> Vec<TruthView> {
        let count = TRUTH_FRAMES.min(self.frames);
        let mut views = Vec::with_capacity(self.novel.len() * count);
        for (index, camera) in self.novel.iter().enumerate() {
            for step in 0..count {
                let frame = step * self.frames / count;
                let mut camera = camera.clone();
                camera.name = format!("novel{index}");
                let (demo, truth_camera) = (self.clone(), camera.clone());
                let truth = Arc::new(move || Ok(demo.render(&truth_camera, frame)));
                let file_path = format!("novel{index}/{frame:04}.exr");
                views.push(TruthView::new(file_path, camera, frame as i64, Some(truth)));
            }
        }
        views
    }

    /// A position without a camera, with a good view of the scene.
    #[must_use]
    pub fn home(&self) -> Camera {
        self.novel[0].clone()
    }

    /// What a camera anywhere would record: exact, without noise. Frames beyond the last go on with the animation.
    #[must_use]
    pub fn render(&self, camera: &Camera, frame: usize) -> Frame {
        self.picture(camera, frame, None)
    }

    fn picture(&self, camera: &Camera, frame: usize, noise: Option<RenderNoise>) -> Frame {
        let wanted = WantedPlanes { antialiased: self.scene.antialiased, normals: self.scene.normals, noise };
        tracer::picture(&self.scene.world(frame as f64 / self.frames as f64), camera, wanted)
    }
}

impl FrameSource for Demo {
    fn load(&self, camera: usize, frame: usize) -> Result<Frame> {
        let noise = RenderNoise::new(self.noise, self.scene.seed, camera, frame);
        Ok(self.picture(&self.cameras[camera], frame, noise))
    }

    fn place(&self, camera: usize, frame: usize) -> String {
        format!("demo {}, camera '{}', frame {frame}", self.scene.name, self.cameras[camera].name)
    }
}

fn check(scene: &DemoScene, what: &str, value: f64, range: std::ops::RangeInclusive<f64>) -> Result<()> {
    if range.contains(&value) {
        return Ok(());
    }
    Err(Error::invalid(
        format!("demo {}", scene.name),
        format!("{value} {what} cannot be recorded; ask for {} to {}", range.start(), range.end()),
    ))
}
