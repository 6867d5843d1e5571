//! Alignment of hundreds of cameras, group by group, in memory that does not grow with their number.
//!
//! ```text
//! cameras ─▶ groups of neighbors ─▶ each aligned, beside neighbors that are decided and stay ─▶ corrections of all cameras
//! ```
//!
//! Purpose: the pictures of all cameras are looked at again and again, 15 bytes a pixel, and the work of solving for all poses at once
//! grows with the cube of their number.
//!
//! Source: local bundle adjustment with cameras that stay (E. Mouragnon, M. Lhuillier, M. Dhome, F. Dekeyser, P. Sayd, *Real Time
//! Localization and 3D Reconstruction*, CVPR 2006). What differs: the unknowns are those of a capture without groups, and the new cameras
//! of a group are brought to the exposure of those that stay.

use super::capture_correction::{CameraCorrection, CameraCorrections, CaptureCorrection, FrameCorrection};
use super::color_lens_search::LensCorrection;
use super::report::{AlignedCamera, AlignedLens, AlignedPair, Alignment};
use super::together::{Aligned, Asked, aligned_beside_lenses, problem};
use crate::capture::overlap::{Neighbors, nearest_first};
use crate::capture::{Camera, Capture};
use crate::error::Result;
use crate::job::Job;

/// Cameras that are aligned together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct CameraGroup {
    /// Those that no group before has, ascending.
    new: Vec<usize>,
    /// Those of groups before that hold them where they are, ascending.
    decided: Vec<usize>,
}

/// One camera of this many in a group is of those before it.
const DECIDED_SHARE: usize = 4;

/// Cuts cameras that look at things `typical_depth` away into groups of at most `most`.
pub(super) fn groups(cameras: &[Camera], typical_depth: f64, most: usize) -> Vec<CameraGroup> {
    let neighbors = Neighbors::new(cameras, typical_depth);
    let mut is_first = true;
    let new =
        neighbors.groups(|_| if std::mem::take(&mut is_first) { most } else { most - most / DECIDED_SHARE });
    let mut decided: Vec<usize> = Vec::new();
    let group = |mut new: Vec<usize>| {
        let known = decided.iter().copied();
        let mut beside = nearest_first(known, |camera| neighbors.beside(camera, &new));
        beside.truncate(most.saturating_sub(new.len()));
        decided.extend(&new);
        beside.sort_unstable();
        new.sort_unstable();
        CameraGroup { new, decided: beside }
    };
    new.into_iter().map(group).collect()
}

/// What is known of all cameras while one group after the other is aligned.
struct DecidedCameras {
    correction: CaptureCorrection,
    cameras: Vec<AlignedCamera>,
    pairs: Vec<AlignedPair>,
    refused: Vec<String>,
    measured: Vec<String>,
}

impl DecidedCameras {
    /// That all cameras are as they claim to be, but for their lenses.
    fn nothing(seen: &Capture, lenses: &[LensCorrection]) -> Self {
        let named = |camera: &Camera| AlignedCamera { name: camera.name.clone(), ..AlignedCamera::default() };
        Self {
            correction: CaptureCorrection {
                cameras: seen.cameras.clone(),
                frames: vec![FrameCorrection::NONE; seen.cameras.len()],
                late_frames: vec![0; seen.cameras.len()],
                ..CaptureCorrection::of_lenses(lenses)
            },
            cameras: seen.cameras.iter().map(named).collect(),
            pairs: Vec::new(),
            refused: Vec::new(),
            measured: Vec::new(),
        }
    }

    /// Takes over what was found of the new cameras of a group.
    fn take(&mut self, group: &CameraGroup, held: &[usize], found: Aligned) {
        let is_new = |camera: usize| group.new.binary_search(&camera).is_ok();
        let CaptureCorrection { cameras, frames, late_frames, .. } = found.correction;
        let alignment = found.alignment.unwrap_or_default();
        self.refused.extend(alignment.refused.iter().cloned());
        self.measured.extend(alignment.measured.iter().cloned());
        if !alignment.is_of_cameras() {
            return;
        }
        for (nth, &camera) in held.iter().enumerate().filter(|(_, camera)| is_new(**camera)) {
            self.correction.cameras[camera] = cameras[nth].clone();
            self.correction.frames[camera] = frames[nth].clone();
            self.correction.late_frames[camera] = late_frames.get(nth).copied().unwrap_or(0);
            self.cameras[camera] = alignment.cameras[nth].clone();
        }
        let of_all = alignment.pairs.into_iter().map(|pair| AlignedPair {
            source: held[pair.source],
            target: held[pair.target],
            ..pair
        });
        self.pairs.extend(of_all.filter(|pair| is_new(pair.source)));
    }
}

/// Finds poses, exposures and clocks of a capture that is seen through its color lenses, as [`aligned_beside_lenses`] does of few cameras.
pub(super) fn aligned_in_groups(
    seen: &Capture,
    groups: &[CameraGroup],
    typical_depth: f64,
    lenses: &[LensCorrection],
    asked: &Asked<'_>,
    job: &Job,
) -> Result<Option<Aligned>> {
    let mut decided = DecidedCameras::nothing(seen, lenses);
    let mut so_far = seen.clone();
    for group in groups {
        let mut held = [group.new.as_slice(), group.decided.as_slice()].concat();
        held.sort_unstable();
        let part = so_far.with_cameras(|camera, _| held.binary_search(&camera).is_ok());
        let mut problem = problem(&part, None, job)?;
        problem.is_free = held.iter().map(|camera| group.new.binary_search(camera).is_ok()).collect();
        if let Some(found) = aligned_beside_lenses(&part, problem, &[], asked, job)? {
            decided.take(group, &held, found);
            so_far = decided.correction.applied_to_seen(seen);
        }
    }
    let DecidedCameras { mut correction, cameras, pairs, refused, measured } = decided;
    if lenses.is_empty() && cameras.iter().all(|camera| camera.sentence().is_none()) {
        return Ok(Aligned::left(seen, refused, measured));
    }
    if correction.late_frames.iter().all(|late| *late == 0) {
        correction.late_frames = Vec::new();
    }
    let of_camera = |index: usize| {
        let stops = cameras[index].exposure.as_ref().map_or([0.0; 3], |exposure| exposure.stops);
        let log_gain = stops.map(|stops| stops * std::f64::consts::LN_2);
        let [then, now] = [&seen.cameras[index], &correction.cameras[index]];
        CameraCorrection::new(seen.picture_stem(index, 0), then, now, log_gain)
    };
    let corrections = CameraCorrections::new((0..cameras.len()).map(of_camera).collect(), typical_depth);
    let lenses = lenses.iter().map(AlignedLens::new).collect();
    let alignment = Alignment { cameras, lenses, pairs, corrections, refused, measured, misread: None };
    Ok(Some(Aligned { capture: so_far, alignment: Some(alignment), correction }))
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DQuat};
    use half::f16;

    use super::*;
    use crate::capture::with_changed_frames;
    use crate::demo::{Demo, DemoSpec};
    use crate::settings::{AlignSettings, CaptureSettings, Correction};

    /// How much brighter a camera's pictures are than those of the first.
    fn stops(camera: usize) -> f64 {
        0.05 * camera as f64
    }

    #[test]
    fn groups_agree_with_each_other_about_exposure_and_a_wrong_pose_in_one_is_found() {
        const WRONG: usize = 13;
        let demo = Demo::new(&DemoSpec::new("orrery").cameras(24).frames(1).size((160, 120))).unwrap();
        let right = demo.capture(&CaptureSettings::default());
        let brightening = with_changed_frames(&right, 1 << 26, |camera, _, frame| {
            let gain = (stops(camera) - stops(12)).exp2() as f32;
            let mut exposed = frame.clone();
            for color in exposed.color.as_mut_slice() {
                *color = color.map(|value| f16::from_f32(f32::from(value) * gain));
            }
            exposed
        });
        let turn = DAffine3::from_quat(DQuat::from_rotation_y(0.5_f64.to_radians()));
        let wrong = brightening.with_changed_cameras(|index, camera| {
            if index == WRONG {
                camera.world_from_camera *= turn;
            }
        });
        let settings =
            AlignSettings { poses: Correction::Auto, exposure: Correction::Auto, ..AlignSettings::OFF };
        let groups = groups(&wrong.cameras, 4.0, 12);
        assert!(groups.len() > 1);
        let asked = Asked { settings: &settings, is_rendered: false };
        let found = aligned_in_groups(&wrong, &groups, 4.0, &[], &asked, &Job::new()).unwrap().unwrap();
        let alignment = found.alignment.unwrap();
        let off: Vec<f64> = (0..24)
            .map(|camera| {
                let exposure = alignment.cameras[camera].exposure.as_ref();
                stops(camera) + exposure.map_or(0.0, |exposure| exposure.stops[1])
            })
            .collect();
        let [least, most] = [f64::min, f64::max].map(|of| off.iter().copied().reduce(of).unwrap());
        println!("exposures that differed by {} stops differ by {:.3}", stops(23), most - least);
        assert!(most - least < 0.06, "{off:?}");
        for (camera, told) in alignment.cameras.iter().enumerate() {
            assert_eq!(told.pose.is_some(), camera == WRONG, "{}", told.name);
            let [now, then] = [&found.capture.cameras[camera], &right.cameras[camera]]
                .map(|camera| DQuat::from_mat3(&camera.world_from_camera.matrix3));
            assert!(now.angle_between(then).to_degrees() < 0.03, "{}", told.name);
        }
        assert!(alignment.pairs.iter().all(|pair| pair.source < 24 && pair.target < 24));
    }

    #[test]
    fn a_capture_that_is_right_is_left_alone_in_groups_too() {
        let demo = Demo::new(&DemoSpec::new("orrery").cameras(12).frames(1).size((120, 90))).unwrap();
        let right = demo.capture(&CaptureSettings::default());
        let settings =
            AlignSettings { poses: Correction::Auto, exposure: Correction::Auto, ..AlignSettings::OFF };
        let groups = groups(&right.cameras, 4.0, 6);
        let asked = Asked { settings: &settings, is_rendered: false };
        let found = aligned_in_groups(&right, &groups, 4.0, &[], &asked, &Job::new()).unwrap();
        assert!(found.is_none());
    }
}
