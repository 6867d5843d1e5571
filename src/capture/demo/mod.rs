//! Built-in scenes, traced on demand: exact depth and normals at pixel centers, truth for any vantage.

use super::{Camera, Capture, Frame, View};
use crate::settings::CaptureSettings;

/// Names and one-line descriptions of the built-in scenes, the default first.
pub const SCENES: &[(&str, &str)] = &[("orrery", ""), ("nine-cameras", ""), ("four-cameras", "")];

/// Which scene, and how it is recorded. `None` keeps the scene's own value.
#[derive(Clone, Debug, PartialEq)]
pub struct DemoSpec {
    /// One of [`SCENES`].
    pub scene: String,
    /// Number of cameras.
    pub cameras: Option<usize>,
    /// Number of frames.
    pub frames: Option<usize>,
    /// Columns and rows of every camera.
    pub size: Option<(u32, u32)>,
    /// Relative standard deviation of the renderer-like color noise.
    pub noise: Option<f32>,
}

/// A built-in scene with its recording decided.
#[derive(Clone, Debug)]
pub struct Demo {}

impl Demo {
    /// # Errors
    /// `Invalid` for an unknown scene or an absurd count.
    pub fn new(spec: &DemoSpec) -> crate::error::Result<Self> {
        let _ = spec;
        todo!()
    }

    /// The scene as a capture whose frames are traced when asked for.
    #[must_use]
    pub fn capture(&self, settings: &CaptureSettings) -> Capture {
        let _ = settings;
        todo!()
    }

    /// Vantages where no camera stands, with truth.
    #[must_use]
    pub fn truth_views(&self) -> Vec<View> {
        todo!()
    }

    /// What a camera anywhere would record: exact, without noise.
    #[must_use]
    pub fn render(&self, camera: &Camera, frame: usize) -> Frame {
        let _ = (camera, frame);
        todo!()
    }
}
