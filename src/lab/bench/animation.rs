//! The animations whose default pictures are measured.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use overlook_engine::capture::{Camera, Intrinsics, pivot};
use overlook_engine::demo::{Demo, DemoSpec};
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::preprocess::preprocess;
use overlook_engine::render::Vantage;
use overlook_engine::samples::SampleSet;
use overlook_engine::settings::Settings;

/// Frames of each animation, which plays in a loop.
pub(super) const FRAMES: usize = 3;

/// Turn of the orbit between two viewpoints, radians: a drag of a few pixels.
const STEP_RAD: f64 = 0.012;

/// Where the view turns about, before the first camera, if the cameras do not look at one point.
const TYPICAL_DEPTH_M: f64 = 3.0;

/// What the animations are called: a room with a view of the sky, and an orrery that is recorded without one.
pub(super) const SCENES: [&str; 2] = ["nine-cameras", "orrery-no-sky"];

/// What the name of an animation ends in that leaves out the sky of its built-in scene.
const NO_SKY: &str = "-no-sky";

/// An animation, pruned by the default settings, and where it is seen from.
#[derive(Debug)]
pub(crate) struct Animation {
    pub(super) samples: Arc<SampleSet>,
    home: Camera,
    pivot_in_world: DVec3,
}

impl Animation {
    /// A built-in scene, recorded with cameras of `size`.
    fn of(scene: &str, size: (u32, u32), job: &Job) -> Result<Self> {
        let settings = Settings::default();
        let recorded = scene.trim_end_matches(NO_SKY);
        let demo = Demo::new(&DemoSpec::new(recorded).frames(FRAMES).size(size))?;
        let capture = demo.capture(&settings.capture);
        let mut samples = preprocess(&capture, &settings, job)?.samples;
        if recorded != scene {
            samples = Arc::new(without_sky(&samples));
        }
        let pivot_in_world = pivot(&capture.cameras, TYPICAL_DEPTH_M);
        Ok(Self { samples, home: demo.home(), pivot_in_world })
    }

    /// A viewpoint of the orbit, at a frame.
    pub(super) fn vantage(&self, (viewpoint, frame): (usize, usize), size: (u32, u32)) -> Vantage {
        let home = self.home.intrinsics;
        let angle_x_rad = 2.0 * (f64::from(home.width) / (2.0 * home.fx)).atan();
        let up = self.samples.up_in_world;
        let turn = DMat3::from_axis_angle(up, STEP_RAD * viewpoint as f64);
        let eye = self.pivot_in_world + turn * (self.home.position_in_world() - self.pivot_in_world);
        let lens = Intrinsics::from_horizontal_angle(size.0, size.1, angle_x_rad);
        let target = self.pivot_in_world;
        Vantage { camera: Camera::look_at("orbit", lens, eye, target, up), frame }
    }
}

/// The samples that are not at infinity.
fn without_sky(samples: &SampleSet) -> SampleSet {
    let images = samples.images.iter().map(|image| Arc::new(image.part(image.span, |_, w| w > 0.0)));
    SampleSet { images: images.collect(), ..samples.clone() }
}

/// The scenes, recorded with cameras of `size`.
pub(super) fn animations(size: (u32, u32), job: &Job) -> Result<Vec<Animation>> {
    SCENES.iter().map(|scene| Animation::of(scene, size, job)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use overlook_engine::render::Renderer;
    use overlook_engine::settings::{Backend, RenderSettings};

    #[test]
    fn one_scene_has_a_sky_and_neither_is_empty() {
        let animations = animations((64, 48), &Job::new()).unwrap();
        let has_sky = |animation: &Animation| {
            let mut tiles = animation.samples.images.iter().flat_map(|image| image.depth.tiles());
            tiles.any(|tile| tile.farthest == 0)
        };
        for animation in &animations {
            let vantage = animation.vantage((3, 1), (64, 48));
            let settings = RenderSettings { backend: Backend::Cpu, ..RenderSettings::default() };
            let (_, stats) =
                Renderer::new().render(&animation.samples, &vantage, &settings, &Job::new()).unwrap();
            assert!(stats.samples > 1000 && stats.holes < 64 * 48 / 2, "{stats:?}");
        }
        assert_eq!(animations.iter().filter(|animation| has_sky(animation)).count(), 1);
    }
}
