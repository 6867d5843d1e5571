//! What the stages work on, the same in every run: built-in scenes, recorded once.
//!
//! ```text
//! nine-cameras, 3 frames ─┬─ frame 0, pruning off ─▶ unpruned: every pixel a sample, in one span of all frames
//!                         │                    └───▶ split: the same, an object on a tenth of the picture in spans of one frame
//!                         └─ frame 0, defaults ────▶ pruned, in one span of all frames
//! nine-cameras, orrery, 3 frames ── defaults ──────▶ animations, seen from an orbit
//! ```

use std::sync::{Arc, LazyLock};

use glam::{DMat3, DVec2, DVec3};
use overlook_engine::capture::{Camera, Capture, Intrinsics, pivot};
use overlook_engine::demo::{Demo, DemoSpec};
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::preprocess::{inspect_frame, preprocess};
use overlook_engine::render::{CpuRenderer, Vantage};
use overlook_engine::samples::{SampleImage, SampleSet, Span};
use overlook_engine::settings::{CaptureSettings, Fill, PruningMethod, RenderSettings, Settings};

/// The built-in scene that most stages work on.
pub(crate) const SCENE: &str = "nine-cameras";

/// The animations whose default pictures are measured: a room with a view of the sky, and an orrery that is recorded without one.
pub(crate) const ANIMATIONS: [&str; 2] = [SCENE, "orrery"];

/// Frames of each recording; animations play them in a loop.
pub(crate) const FRAMES: usize = 3;

/// Columns and rows of the cameras.
pub(crate) const CAMERA_SIZE: (u32, u32) = (640, 480);

/// Share of the picture that shows what moves in [`Scene::split`].
const FOREGROUND_SHARE: f64 = 0.1;

/// Distance of the two vantages, m: too small to change the picture, enough that no cache serves both.
const SIDE_STEP_M: f64 = 1e-6;

/// Turn of an orbit between two viewpoints, radians: a drag of a few pixels.
const STEP_RAD: f64 = 0.012;

/// Distance of the pivot from the first camera where cameras do not look at one point, m.
const TYPICAL_DEPTH_M: f64 = 3.0;

const ALL_FRAMES: Span = Span { start: 0, end: FRAMES as u32 };

/// Recorded when the first stage asks for it.
pub(crate) static MEASURED: LazyLock<Scene> = LazyLock::new(|| Scene::new().unwrap());

/// As [`ANIMATIONS`].
static ANIMATED: LazyLock<[Animation; 2]> =
    LazyLock::new(|| ANIMATIONS.map(|name| Animation::of(name).unwrap()));

/// The default settings of rendering without filling of holes, which takes the same time after every kernel.
pub(crate) fn without_filling() -> RenderSettings {
    RenderSettings { fill: Fill::None, free_space: false, ..RenderSettings::default() }
}

/// A recording and what becomes of its first frame.
pub(crate) struct Scene {
    /// All frames, in memory.
    pub(crate) capture: Capture,
    /// Every pixel of every camera, over all frames.
    pub(crate) unpruned: Arc<SampleSet>,
    /// What default settings keep of it.
    pub(crate) pruned: Arc<SampleSet>,
    /// The unpruned set with an object in spans of one frame, the same samples at every frame.
    pub(crate) split: Arc<SampleSet>,
    home: Camera,
}

impl Scene {
    fn new() -> Result<Self> {
        let job = Job::new();
        let demo = Demo::new(&DemoSpec::new(SCENE).frames(FRAMES).size(CAMERA_SIZE))?;
        let capture = demo.capture(&CaptureSettings { memory: 4096, ..CaptureSettings::default() });
        let mut settings = Settings::default();
        let pruned = over_all_frames(&inspect_frame(&capture, None, &settings, 0, &job)?.samples);
        settings.pruning.method = PruningMethod::Off;
        let unpruned = over_all_frames(&inspect_frame(&capture, None, &settings, 0, &job)?.samples);
        for camera in 0..capture.cameras.len() {
            for frame in 0..FRAMES {
                capture.frame(camera, frame)?;
            }
        }
        let mut scene = Self { capture, split: unpruned.clone(), unpruned, pruned, home: demo.home() };
        scene.split = scene.with_moving_object()?;
        Ok(scene)
    }

    /// A vantage between the cameras whose picture the scene fills, and one right beside it that shows the same.
    pub(crate) fn vantages(&self, size: (u32, u32), frame: usize) -> [Vantage; 2] {
        [0.0, SIDE_STEP_M].map(|step| {
            let mut camera = Camera { intrinsics: lens_of(&self.home, size), ..self.home.clone() };
            camera.world_from_camera.translation += DVec3::X * step;
            Vantage { camera, frame }
        })
    }

    /// [`Scene::split`]: what lies within a ball around what the middle of the picture shows moves.
    fn with_moving_object(&self) -> Result<Arc<SampleSet>> {
        let [vantage, _] = self.vantages(CAMERA_SIZE, 0);
        let (picture, _) =
            CpuRenderer::new().render(&self.unpruned, &vantage, &without_filling(), &Job::new())?;
        let (width, height) = picture.inverse_depth.size();
        let shown = |(x, y): (usize, usize)| {
            point_in_world(&vantage.camera, x as f64, y as f64, picture.inverse_depth[(x, y)])
        };
        let center_in_world = shown((width / 2, height / 2));
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let mut distances: Vec<f64> = pixels.map(|pixel| shown(pixel).distance(center_in_world)).collect();
        distances.sort_by(f64::total_cmp);
        let radius_m = distances[(FOREGROUND_SHARE * distances.len() as f64) as usize];
        let part = |image: &SampleImage, span: Span, moves: bool| {
            let camera = &self.unpruned.cameras[image.camera as usize];
            let of_part = image.part(span, |sample, inverse_depth| {
                let point = point_in_world(camera, sample.x as f64, sample.y as f64, inverse_depth);
                (point.distance(center_in_world) <= radius_m) == moves
            });
            Arc::new(of_part)
        };
        let images = &self.unpruned.images;
        let still = images.iter().map(|image| part(image, ALL_FRAMES, false));
        let moving = (0..FRAMES as u32).flat_map(|start| {
            images.iter().map(move |image| part(image, Span { start, end: start + 1 }, true))
        });
        let images = still.chain(moving).filter(|image| !image.is_empty()).collect();
        Ok(Arc::new(SampleSet { images, ..SampleSet::clone(&self.unpruned) }))
    }
}

/// The point that the center of a pixel shows; those at infinity are far away.
fn point_in_world(camera: &Camera, x: f64, y: f64, inverse_depth: f32) -> DVec3 {
    camera.unproject(DVec2::new(x, y) + 0.5, 1.0 / f64::from(inverse_depth).max(1e-6))
}

/// The lens of a camera for pictures of another size.
fn lens_of(camera: &Camera, (width, height): (u32, u32)) -> Intrinsics {
    let of = camera.intrinsics;
    let angle_x_rad = 2.0 * (f64::from(of.width) / (2.0 * of.fx)).atan();
    Intrinsics::from_horizontal_angle(width, height, angle_x_rad)
}

fn over_all_frames(set: &SampleSet) -> Arc<SampleSet> {
    let images = set.images.iter();
    let images = images.map(|image| Arc::new(SampleImage { span: ALL_FRAMES, ..SampleImage::clone(image) }));
    Arc::new(SampleSet { images: images.collect(), ..set.clone() })
}

/// An animation, pruned by the default settings, and where it is seen from.
pub(crate) struct Animation {
    pub(crate) samples: Arc<SampleSet>,
    home: Camera,
    pivot_in_world: DVec3,
}

impl Animation {
    /// One of [`ANIMATIONS`].
    pub(crate) fn named(name: &str) -> &'static Self {
        &ANIMATED[usize::from(name == ANIMATIONS[1])]
    }

    fn of(name: &str) -> Result<Self> {
        let settings = Settings::default();
        let demo = Demo::new(&DemoSpec::new(name).frames(FRAMES).size(CAMERA_SIZE))?;
        let capture = demo.capture(&settings.capture);
        let mut samples = preprocess(&capture, &settings, &Job::new())?.samples;
        if name != SCENE {
            samples = without_sky(&samples);
        }
        Ok(Self { samples, home: demo.home(), pivot_in_world: pivot(&capture.cameras, TYPICAL_DEPTH_M) })
    }

    /// A viewpoint of the orbit, at a frame.
    pub(crate) fn vantage(&self, (viewpoint, frame): (usize, usize), size: (u32, u32)) -> Vantage {
        let (up, target) = (self.samples.up_in_world, self.pivot_in_world);
        let turn = DMat3::from_axis_angle(up, STEP_RAD * viewpoint as f64);
        let eye = target + turn * (self.home.position_in_world() - target);
        Vantage { camera: Camera::look_at("orbit", lens_of(&self.home, size), eye, target, up), frame }
    }
}

/// The samples that are not at infinity.
fn without_sky(samples: &SampleSet) -> Arc<SampleSet> {
    let images = samples.images.iter().map(|image| Arc::new(image.part(image.span, |_, w| w > 0.0)));
    Arc::new(SampleSet { images: images.collect(), ..samples.clone() })
}
