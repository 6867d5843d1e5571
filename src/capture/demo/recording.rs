//! A demo as the source of a capture: frames are retraced from what each camera sees of the solids at rest.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::Demo;
use super::camera_noise::CameraNoise;
use super::retrace::{self, Moment};
use super::still::{Allowance, StillPicture};
use super::trace::{self, CameraRays};
use super::world::World;
use crate::capture::{Frame, FrameSource};
use crate::error::Result;

/// Most bytes kept of all cameras together: nine of 640×480 fit. Frames of cameras beyond are traced in full.
const KEPT_BYTES: usize = 384 * 1024 * 1024;

/// A recording of a demo.
pub(super) struct Recording {
    demo: Demo,
    at_rest: World,
    /// One for each camera.
    stills: Vec<Slot>,
    allowance: Allowance,
}

/// A still picture that the second to ask for it traces.
#[derive(Default)]
struct Slot {
    asked: AtomicUsize,
    picture: OnceLock<StillPicture>,
}

impl Recording {
    /// Records a demo.
    pub(super) fn new(demo: Demo) -> Self {
        Self::keeping(KEPT_BYTES, demo)
    }

    fn keeping(bytes: usize, demo: Demo) -> Self {
        let at_rest = demo.world(0).at_rest();
        let stills = demo.cameras.iter().map(|_| Slot::default()).collect();
        Self { demo, at_rest, stills, allowance: Allowance::new(bytes) }
    }

    /// What a camera sees of the solids at rest. `None` for a camera's first frame, which may be its only one and is
    /// waited for; where pictures at rest would take too many bytes; and while another thread traces this one. Waiting
    /// for that thread could be for ever: it may need this one.
    fn still(&self, camera: usize, view: &CameraRays) -> Option<&StillPicture> {
        let slot = &self.stills[camera];
        if let Some(picture) = slot.picture.get() {
            return Some(picture);
        }
        if slot.asked.fetch_add(1, Ordering::Relaxed) != 1 {
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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::{KEPT_BYTES, Recording};
    use crate::capture::demo::camera_noise::CameraNoise;
    use crate::capture::demo::still::StillPicture;
    use crate::capture::demo::{Demo, DemoSpec, SCENES, trace};
    use crate::capture::{Frame, FrameSource};

    fn demo(scene: usize, size: (u32, u32)) -> Demo {
        let scene = SCENES[scene].0.to_owned();
        Demo::new(&DemoSpec { scene, cameras: None, frames: None, size: Some(size), noise: Some(0.02) })
            .unwrap()
    }

    fn traced_in_full(demo: &Demo, camera: usize, frame: usize) -> Frame {
        let noise = CameraNoise::new(demo.noise, demo.scene.seed, camera, frame);
        trace::picture(&demo.world(frame), &demo.cameras[camera], demo.wanted(noise))
    }

    /// Depths, normals and colors as they lie in memory: equality of numbers passes over the sign of zero.
    fn bits(frame: &Frame) -> (Vec<[u16; 3]>, Vec<u32>, Vec<[u32; 3]>) {
        let normals = frame.normal_in_world.as_ref().map_or(&[][..], |normals| normals.as_slice());
        (
            frame.color.as_slice().iter().map(|color| color.map(half::f16::to_bits)).collect(),
            frame.inverse_depth.as_slice().iter().map(|depth| depth.to_bits()).collect(),
            normals.iter().map(|normal| normal.map(f32::to_bits)).collect(),
        )
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(12))]

        #[test]
        fn retraced_frames_are_those_traced_in_full_bit_by_bit(
            camera in 0..9_usize,
            frames in prop::array::uniform3(0..120_usize),
            width in 20..76_u32,
        ) {
            for scene in 0..SCENES.len() {
                let demo = demo(scene, (width, width * 3 / 4));
                let camera = camera % demo.cameras.len();
                let recording = Recording::new(demo.clone());
                for frame in frames {
                    let retraced = recording.load(camera, frame).unwrap();
                    prop_assert!(bits(&retraced) == bits(&traced_in_full(&demo, camera, frame)));
                }
                prop_assert!(recording.stills[camera].picture.get().is_some());
            }
        }
    }

    #[test]
    fn what_may_be_kept_does_not_change_the_picture() {
        for scene in 0..SCENES.len() {
            let demo = demo(scene, (44, 33));
            let picture_alone = StillPicture::most_bytes(44 * 33);
            for bytes in [0, picture_alone, picture_alone + 20_000, KEPT_BYTES] {
                let recording = Recording::keeping(bytes, demo.clone());
                for frame in [0, 11, 40] {
                    let recorded = recording.load(0, frame).unwrap();
                    assert!(bits(&recorded) == bits(&traced_in_full(&demo, 0, frame)));
                }
                assert_eq!(recording.stills[0].picture.get().is_some(), bytes >= picture_alone);
            }
        }
    }

    #[test]
    fn some_pixels_at_rest_show_two_solids_at_one_place() {
        let recording = Recording::new(demo(1, (120, 90)));
        for frame in 0..2 {
            recording.load(6, frame).unwrap();
        }
        let still = recording.stills[6].picture.get().unwrap();
        assert!(still.tiles.as_slice().iter().any(|tile| tile.has_ties), "the shelf's side and back");
        assert!(still.tiles.as_slice().iter().any(|tile| !tile.has_ties));
    }
}
