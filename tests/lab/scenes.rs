//! Small captures with truth: the orrery as it is, standing still, changing everywhere, and with a camera too many.

use std::sync::Arc;

use overlook_engine::capture::{Capture, CaptureParts, Frame, FrameSource};
use overlook_engine::demo::{Demo, DemoSpec};
use overlook_engine::error::Result;
use overlook_engine::settings::CaptureSettings;
use overlook_lab::truth::Truth;

/// A capture and what it is held against.
pub(crate) struct Scene {
    pub(crate) capture: Capture,
    pub(crate) truth: Truth,
}

fn demo(frames: usize) -> Demo {
    let spec = DemoSpec::new("orrery").cameras(3).frames(frames).size((64, 48));
    Demo::new(&spec).unwrap()
}

/// Three cameras of the orrery, and three places where none stands.
pub(crate) fn orrery(frames: usize) -> Scene {
    let demo = demo(frames);
    let truth = Truth::Views(demo.truth_views());
    Scene { capture: demo.capture(&CaptureSettings::default()), truth }
}

/// A capture made of another's frames.
struct Changed<F> {
    capture: Capture,
    change: F,
}

impl<F: Fn(&Capture, usize, usize) -> Result<Frame> + Send + Sync> FrameSource for Changed<F> {
    fn load(&self, camera: usize, frame: usize) -> Result<Frame> {
        (self.change)(&self.capture, camera, frame)
    }

    fn place(&self, camera: usize, frame: usize) -> String {
        self.capture.place(camera, frame)
    }
}

fn changed<F>(capture: &Capture, cameras: Vec<overlook_engine::capture::Camera>, change: F) -> Capture
where
    F: Fn(&Capture, usize, usize) -> Result<Frame> + Send + Sync + 'static,
{
    let source = Arc::new(Changed { capture: capture.clone(), change });
    let parts = CaptureParts {
        name: capture.name.clone(),
        cameras,
        frame_numbers: capture.frame_numbers.clone(),
        up_in_world: capture.up_in_world,
        has_normals: capture.has_normals,
        antialiased_color: capture.antialiased_color,
        warnings: Vec::new(),
        source,
    };
    Capture::new(parts, 64 << 20)
}

/// Every frame is the first. Each camera is left out in turn.
pub(crate) fn still(frames: usize) -> Scene {
    let capture = orrery(frames).capture;
    let cameras = capture.cameras.clone();
    let first = |capture: &Capture, camera, _| Ok((*capture.frame(camera, 0)?).clone());
    Scene { capture: changed(&capture, cameras, first), truth: Truth::HoldOut }
}

/// Every pixel, black ones too, is brighter in every frame than in the one before. Each camera is left out in turn.
pub(crate) fn flashing(frames: usize) -> Scene {
    let capture = orrery(frames).capture;
    let cameras = capture.cameras.clone();
    let flash = |capture: &Capture, camera, frame: usize| {
        let mut recorded = (*capture.frame(camera, frame)?).clone();
        let added = 0.15 * frame as f32;
        for color in recorded.color.as_mut_slice() {
            *color = color.map(|value| half::f16::from_f32(value.to_f32() * 0.5 + added));
        }
        Ok(recorded)
    };
    Scene { capture: changed(&capture, cameras, flash), truth: Truth::HoldOut }
}

/// A fourth camera stands where one of the others stands, and sees what that sees.
pub(crate) fn one_too_many(frames: usize) -> Scene {
    let Scene { capture, truth } = orrery(frames);
    let mut cameras = capture.cameras.clone();
    let mut again = cameras[1].clone();
    "redundant".clone_into(&mut again.name);
    cameras.push(again);
    let twice = |capture: &Capture, camera: usize, frame| {
        Ok((*capture.frame(if camera == 3 { 1 } else { camera }, frame)?).clone())
    };
    Scene { capture: changed(&capture, cameras, twice), truth }
}
