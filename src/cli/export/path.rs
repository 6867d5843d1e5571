//! A camera path: the views of a manifest as keys, and every frame of a store between them.

use std::path::Path;

use glam::{DAffine3, DMat3, DQuat, DVec3};

use crate::capture::{Camera, View, transforms};
use crate::error::{Error, Result};

/// A place on the path: where from, and which frame of the store.
#[derive(Clone, Debug)]
pub(super) struct Stop {
    pub(super) camera: Camera,
    pub(super) frame: usize,
    pub(super) number: i64,
}

/// One stop for every frame of the store from the first key to the last.
///
/// Between two keys the position moves evenly on a straight line and the direction turns evenly; size and focal length are those of the first
/// key, so that all pictures fit into one film. A single key is a camera that stands still through all frames.
///
/// # Errors
/// Whatever the manifest gives; `Invalid` where it has no view, two at one frame, or none that the store has.
pub(super) fn along(manifest: &Path, frame_numbers: &[i64]) -> Result<Vec<Stop>> {
    let mut keys = transforms::open_views(manifest)?;
    keys.sort_by_key(|view| view.frame_number);
    let invalid = |what: &str| Err(Error::invalid(manifest.display(), what));
    if let Some(pair) = keys.windows(2).find(|pair| pair[0].frame_number == pair[1].frame_number) {
        let time = pair[0].frame_number;
        return invalid(&format!("two views at time {time}; a camera path has one place at a time"));
    }
    let (Some(first), Some(last)) = (keys.first(), keys.last()) else { return invalid("has no view") };
    let all = keys.len() == 1;
    let range = first.frame_number..=last.frame_number;
    let frames = frame_numbers.iter().enumerate();
    let stops: Vec<Stop> = frames
        .filter(|(_, number)| all || range.contains(*number))
        .map(|(frame, &number)| Stop { camera: between(&keys, number), frame, number })
        .collect();
    if stops.is_empty() { invalid("no view lies at a time that the store has") } else { Ok(stops) }
}

fn between(keys: &[View], number: i64) -> Camera {
    let after = keys.partition_point(|view| view.frame_number <= number).clamp(1, keys.len().max(2) - 1);
    let before = &keys[after - 1];
    let Some(after) = keys.get(after) else { return before.camera.clone() };
    let length = (after.frame_number - before.frame_number) as f64;
    let share = ((number - before.frame_number) as f64 / length).clamp(0.0, 1.0);
    let [from, to] = [before, after].map(|view| view.camera.world_from_camera);
    let [turn_from, turn_to] = [from, to].map(|pose| DQuat::from_mat3(&pose.matrix3));
    Camera {
        world_from_camera: DAffine3 {
            matrix3: DMat3::from_quat(turn_from.slerp(turn_to, share)),
            translation: DVec3::lerp(from.translation, to.translation, share),
        },
        ..keys[0].camera.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::Intrinsics;

    fn key(frame_number: i64, x: f64, angle: f64) -> View {
        let camera = Camera {
            name: "path".to_owned(),
            intrinsics: Intrinsics::from_horizontal_angle(8, 6, 1.0),
            world_from_camera: DAffine3::from_rotation_translation(
                DQuat::from_rotation_y(angle),
                DVec3::new(x, 0.0, 0.0),
            ),
        };
        View { file_path: String::new(), camera, frame_number, truth: None }
    }

    #[test]
    fn a_path_moves_and_turns_evenly_between_its_keys() {
        let keys = [key(0, 0.0, 0.0), key(10, 1.0, 1.0), key(12, 5.0, 1.0)];
        for (number, x, angle) in
            [(0, 0.0, 0.0), (5, 0.5, 0.5), (10, 1.0, 1.0), (11, 3.0, 1.0), (12, 5.0, 1.0)]
        {
            let pose = between(&keys, number).world_from_camera;
            assert!((pose.translation.x - x).abs() < 1e-12);
            let axis = pose.transform_vector3(DVec3::Z);
            assert!((axis.x.atan2(axis.z) - angle).abs() < 1e-9, "{number}");
        }
        assert_eq!(between(&keys[..1], 7), keys[0].camera);
    }
}
