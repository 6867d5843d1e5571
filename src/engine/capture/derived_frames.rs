//! Captures whose frames are made on demand of the frames of another capture. All else is as in the original.
//!
//! Decoded frames stay in the cache of the original; each derived capture keeps a few of those that it made.

use std::path::PathBuf;
use std::sync::Arc;

use super::depth_claim::DepthClaim;
use super::frame::Frame;
use super::parts::{Capture, CaptureParts, FrameSource};
use super::pose_convention::PoseConvention;
use super::values::ValueChannel;
use crate::error::Result;

/// Frames made of the frames of a capture.
struct DerivedFrames<R, M> {
    original: Capture,
    /// Given a camera and the index of a frame: the indices of that camera's frames that it is made of, at least one. It goes by the
    /// name of the first.
    read: R,
    /// Given the same and the frames that were read: the frame.
    make: M,
}

impl<R, M> FrameSource for DerivedFrames<R, M>
where
    R: Fn(usize, usize) -> Vec<usize> + Send + Sync,
    M: Fn(usize, usize, &[Arc<Frame>]) -> Frame + Send + Sync,
{
    fn load(&self, camera: usize, frame: usize) -> Result<Frame> {
        let read = (self.read)(camera, frame).into_iter();
        let read = read.map(|index| self.original.frame(camera, index)).collect::<Result<Vec<_>>>()?;
        Ok((self.make)(camera, frame, &read))
    }

    fn place(&self, camera: usize, frame: usize) -> String {
        self.original.place(camera, (self.read)(camera, frame)[0])
    }

    fn transparent_pixels(&self, camera: usize, frame: usize) -> Result<Option<usize>> {
        self.original.transparent_pixels(camera, (self.read)(camera, frame)[0])
    }

    fn frames_are_ranked(&self) -> bool {
        self.original.frames_are_ranked()
    }

    fn depth_claim(&self) -> DepthClaim {
        self.original.source.depth_claim()
    }

    fn is_rendered(&self) -> Option<bool> {
        // What was changed may be wrong now, and its word is not its own.
        self.original.source.is_rendered().filter(|is_rendered| !is_rendered)
    }

    fn value_channels(&self) -> &[ValueChannel] {
        self.original.value_channels()
    }

    fn pose_convention(&self) -> PoseConvention {
        self.original.source.pose_convention()
    }

    fn forget_frames(&self) {
        self.original.forget_frames();
    }

    fn files(&self, camera: usize, frame: usize) -> Vec<PathBuf> {
        let read = (self.read)(camera, frame).into_iter();
        read.flat_map(|index| self.original.files_of(camera, index)).collect()
    }
}

/// The capture with each frame changed; `change` is given its camera and index. `cache_bytes` of the changed frames
/// are kept.
pub fn with_changed_frames(
    capture: &Capture,
    cache_bytes: usize,
    change: impl Fn(usize, usize, &Frame) -> Frame + Send + Sync + 'static,
) -> Capture {
    let make = move |camera: usize, frame: usize, read: &[Arc<Frame>]| change(camera, frame, &read[0]);
    with_frames_made_of(capture, cache_bytes, |_, frame| vec![frame], make)
}

/// The capture with other frames in place of its own. `read` gets a camera and the index of a frame, and gives the frames of that
/// camera that it is made of; the first is the one that it mostly shows. `make` makes the frame of them. `cache_bytes` of the frames
/// are kept.
pub(crate) fn with_frames_made_of(
    capture: &Capture,
    cache_bytes: usize,
    read: impl Fn(usize, usize) -> Vec<usize> + Send + Sync + 'static,
    make: impl Fn(usize, usize, &[Arc<Frame>]) -> Frame + Send + Sync + 'static,
) -> Capture {
    let source = Arc::new(DerivedFrames { original: capture.clone(), read, make });
    Capture::new(CaptureParts { source, ..CaptureParts::clone(capture) }, cache_bytes)
}

/// The capture with frames in another order: `shown` gives the index of the frame of the same camera that is shown.
pub fn with_reindexed_frames(
    capture: &Capture,
    cache_bytes: usize,
    shown: impl Fn(usize, usize) -> usize + Send + Sync + 'static,
) -> Capture {
    let read = move |camera: usize, frame: usize| vec![shown(camera, frame)];
    with_frames_made_of(capture, cache_bytes, read, |_, _, read| Frame::clone(&read[0]))
}

#[cfg(test)]
mod tests {
    use super::super::camera::{Camera, Intrinsics};
    use super::*;
    use crate::grid::Grid;
    use glam::DVec3;

    /// Frames of one pixel whose inverse depth is their number, each in a file of its own.
    struct Numbered;

    impl FrameSource for Numbered {
        fn load(&self, camera: usize, frame: usize) -> Result<Frame> {
            Ok(Frame {
                color: Grid::filled(1, 1, [half::f16::ONE; 3]),
                inverse_depth: Grid::filled(1, 1, (10 * camera + frame) as f32),
                normal_in_world: None,
                depth_step_relative: 0.0,
                values: crate::capture::Values::default(),
            })
        }

        fn place(&self, camera: usize, frame: usize) -> String {
            format!("c{camera}/{frame}.exr")
        }

        fn frames_are_ranked(&self) -> bool {
            true
        }

        fn files(&self, camera: usize, frame: usize) -> Vec<PathBuf> {
            vec![PathBuf::from(self.place(camera, frame))]
        }
    }

    fn numbered() -> Capture {
        let lens = Intrinsics::from_horizontal_angle(1, 1, 1.0);
        let camera = |name: &str| Camera::look_at(name, lens, DVec3::ZERO, DVec3::Y, DVec3::Z);
        let parts = CaptureParts {
            name: "numbered".to_owned(),
            cameras: vec![camera("c0"), camera("c1"), camera("c2")],
            frame_numbers: (0..4).collect(),
            up_in_world: DVec3::Z,
            has_normals: false,
            antialiased_color: false,
            warnings: Vec::new(),
            source: Arc::new(Numbered),
        };
        Capture::new(parts, 1 << 20)
    }

    #[test]
    fn a_derived_capture_names_the_files_and_places_of_the_frames_that_its_own_are_made_of() {
        // One camera is left out: the derived capture's second camera is the recording's third.
        let capture = numbered().with_cameras(|index, _| index != 1);
        let sum = |_: usize, _: usize, read: &[Arc<Frame>]| {
            let sum = read.iter().map(|frame| frame.inverse_depth[(0, 0)]).sum();
            Frame { inverse_depth: Grid::filled(1, 1, sum), ..Frame::clone(&read[0]) }
        };
        let derived = with_frames_made_of(&capture, 1 << 20, |_, frame| vec![frame, 3], sum);
        assert_eq!(derived.frame(1, 2).unwrap().inverse_depth[(0, 0)], 22.0 + 23.0);
        assert_eq!(derived.place(1, 2), "c2/2.exr");
        assert_eq!(derived.files_of(1, 2), ["c2/2.exr", "c2/3.exr"].map(PathBuf::from));
        assert!(derived.frames_are_ranked());
        let reversed = with_reindexed_frames(&derived, 1 << 20, |_, frame| 3 - frame);
        assert_eq!(reversed.frame(0, 3).unwrap().inverse_depth[(0, 0)], 0.0 + 3.0);
        assert_eq!(reversed.files_of(0, 3), ["c0/0.exr", "c0/3.exr"].map(PathBuf::from));
        assert_eq!(reversed.picture_stem(0, 3).as_deref(), Some("0"));
    }

    #[test]
    fn frames_that_are_forgotten_are_decoded_again_and_so_are_those_that_they_were_made_of() {
        let capture = numbered();
        let derived = with_reindexed_frames(&capture, 1 << 20, |_, frame| 3 - frame);
        let frames = || [&capture, &derived].map(|capture| capture.frame(0, 1).unwrap());
        let before = frames();
        let are_held = || std::array::from_fn(|nth| Arc::ptr_eq(&before[nth], &frames()[nth]));
        assert_eq!(are_held(), [true; 2]);
        derived.forget_frames();
        assert_eq!(are_held(), [false; 2]);
    }
}
