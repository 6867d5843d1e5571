//! A demo as the source of a capture: frames are retraced from what each camera sees of the solids at rest.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use super::Demo;
use super::camera_noise::CameraNoise;
use super::retrace::{self, Moment};
use super::still::{Allowance, StillPicture};
use super::trace::{self, CameraRays};
use super::world::World;
use crate::capture::{Frame, FrameSource};
use crate::error::Result;

/// Most bytes kept of all cameras together: twice what nine cameras of 640×480 take. Frames of cameras beyond are traced
/// in full.
const KEPT_BYTES: usize = 384 * 1024 * 1024;

/// A recording of a demo.
pub(super) struct Recording {
    demo: Demo,
    at_rest: World,
    /// One for each camera.
    stills: Vec<Slot>,
    allowance: Allowance,
}

/// A still picture that the first to ask for it traces.
#[derive(Default)]
struct Slot {
    is_claimed: AtomicBool,
    picture: OnceLock<StillPicture>,
}

impl Recording {
    /// Records a demo.
    pub(super) fn new(demo: Demo) -> Self {
        let at_rest = demo.world(0).at_rest();
        let stills = demo.cameras.iter().map(|_| Slot::default()).collect();
        Self { demo, at_rest, stills, allowance: Allowance::new(KEPT_BYTES) }
    }

    /// What a camera sees of the solids at rest: `None` where that is not worth keeping, or not there yet because
    /// another thread traces it. Waiting for that thread could be for ever: it may need this one.
    fn still(&self, camera: usize, view: &CameraRays) -> Option<&StillPicture> {
        let slot = &self.stills[camera];
        if let Some(picture) = slot.picture.get() {
            return Some(picture);
        }
        if self.demo.frames < 2 || slot.is_claimed.swap(true, Ordering::Relaxed) {
            return None;
        }
        let most_bytes = StillPicture::most_bytes(view.camera.intrinsics.pixel_count());
        if !self.allowance.take(most_bytes) {
            return None;
        }
        let picture = StillPicture::new(&self.at_rest, view, self.demo.scene.antialiased);
        Some(slot.picture.get_or_init(|| picture))
    }
}

impl FrameSource for Recording {
    fn load(&self, camera: usize, frame: usize) -> Result<Frame> {
        let Demo { scene, cameras, noise, .. } = &self.demo;
        let wanted = self.demo.wanted(CameraNoise::new(*noise, scene.seed, camera, frame));
        let world = &self.demo.world(frame);
        let view = CameraRays::new(&cameras[camera]);
        let Some(still) = self.still(camera, &view) else {
            return Ok(trace::picture(world, &cameras[camera], wanted));
        };
        let moment = Moment { still, at_rest: &self.at_rest, world, view, allowance: &self.allowance };
        Ok(retrace::picture(&moment, wanted))
    }

    fn place(&self, camera: usize, frame: usize) -> String {
        let Demo { scene, cameras, .. } = &self.demo;
        format!("demo {}, camera '{}', frame {frame}", scene.name, cameras[camera].name)
    }
}
