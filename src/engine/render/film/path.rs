//! A camera path: the pose of the camera between keys.
//!
//! Positions follow a cubic Hermite curve through the keys. The velocity at a key is the mean from the key before to the key
//! after: for keys at equal times the curve of Catmull and Rom (*A class of local interpolating splines*, 1974). At the ends it
//! is that of the first and the last leg, so that two keys give an even motion on a straight line. What differs: the speed at a
//! key is at most three times the mean speed of the slower leg beside it, the bound that keeps a cubic between its end values
//! (Fritsch and Carlson, *Monotone piecewise cubic interpolation*, 1980). Without it a camera that waits before a long way would
//! first go backward. The speed is limited, not each coordinate, so that a path does not depend on the world's axes.
//! Directions turn evenly from key to key (Shoemake, *Animating rotation with quaternion curves*, 1985).

use glam::{DAffine3, DQuat, DVec3};

/// A pose on a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathKey {
    /// When the camera is there, in any unit; greater than that of the key before.
    pub time: f64,
    /// A rotation and a position.
    pub world_from_camera: DAffine3,
}

/// The pose at a time; before the first key that of the first, after the last that of the last. `None` without keys.
#[must_use]
pub fn pose_at(keys: &[PathKey], time: f64) -> Option<DAffine3> {
    let last = keys.len().checked_sub(1)?;
    let after = keys.partition_point(|key| key.time <= time);
    if after == 0 || after > last {
        return Some(keys[after.min(last)].world_from_camera);
    }
    let (from, to) = (&keys[after - 1], &keys[after]);
    let length = to.time - from.time;
    let share = (time - from.time) / length;
    let [a, b] = [from, to].map(|key| key.world_from_camera.translation);
    let position = hermite([a, b], [after - 1, after].map(|key| velocity(keys, key) * length), share);
    let [a, b] = [from, to].map(|key| DQuat::from_mat3(&key.world_from_camera.matrix3));
    Some(DAffine3::from_rotation_translation(a.slerp(b, share).normalize(), position))
}

/// The largest speed at a key, in mean speeds of the slower leg beside it.
const MAX_SPEED_RATIO: f64 = 3.0;

fn velocity(keys: &[PathKey], key: usize) -> DVec3 {
    let mean = |from: usize, to: usize| {
        let way = keys[to].world_from_camera.translation - keys[from].world_from_camera.translation;
        way / (keys[to].time - keys[from].time)
    };
    if key == 0 {
        return mean(0, 1);
    }
    if key + 1 == keys.len() {
        return mean(key - 1, key);
    }
    let slower = mean(key - 1, key).length().min(mean(key, key + 1).length());
    mean(key - 1, key + 1).clamp_length_max(MAX_SPEED_RATIO * slower)
}

fn hermite([a, b]: [DVec3; 2], [out_of_a, into_b]: [DVec3; 2], share: f64) -> DVec3 {
    let (s, s2, s3) = (share, share * share, share * share * share);
    a * (2.0 * s3 - 3.0 * s2 + 1.0)
        + out_of_a * (s3 - 2.0 * s2 + s)
        + b * (3.0 * s2 - 2.0 * s3)
        + into_b * (s3 - s2)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(time: f64, x: f64, y: f64, angle: f64) -> PathKey {
        let turn = DQuat::from_rotation_y(angle);
        PathKey { time, world_from_camera: DAffine3::from_rotation_translation(turn, DVec3::new(x, y, 0.0)) }
    }

    #[test]
    fn two_keys_give_an_even_motion_and_an_even_turn() {
        let keys = [key(0.0, 0.0, 0.0, 0.0), key(10.0, 1.0, 0.0, 1.0)];
        for (time, expected) in [(-1.0, 0.0), (0.0, 0.0), (2.5, 0.25), (5.0, 0.5), (10.0, 1.0), (99.0, 1.0)] {
            let pose = pose_at(&keys, time).unwrap();
            assert!((pose.translation.x - expected).abs() < 1e-12, "{time}");
            let axis = pose.transform_vector3(DVec3::Z);
            assert!((axis.x.atan2(axis.z) - expected).abs() < 1e-9, "{time}");
        }
        assert_eq!(pose_at(&keys[..1], 7.0), Some(keys[0].world_from_camera));
        assert_eq!(pose_at(&[], 7.0), None);
    }

    #[test]
    fn a_camera_that_waits_or_goes_slowly_before_a_long_way_never_goes_backward() {
        for (times, places) in [
            ([0.0, 50.0, 60.0], [0.0, 0.0, 10.0]),
            ([0.0, 100.0, 110.0], [0.0, 1.0, 11.0]),
            ([0.0, 1.0, 2.0], [0.0, 0.0, 10.0]),
            ([0.0, 10.0, 60.0], [0.0, 10.0, 10.0]),
        ] {
            let keys: Vec<_> = times.iter().zip(places).map(|(t, x)| key(*t, x, 0.0, 0.0)).collect();
            let steps = (0..=1000).map(|step| times[2] * f64::from(step) / 1000.0);
            let way: Vec<f64> = steps.map(|time| pose_at(&keys, time).unwrap().translation.x).collect();
            assert!(way.windows(2).all(|pair| pair[1] >= pair[0] - 1e-9), "{times:?} {places:?}");
            assert!(way.iter().all(|x| (-1e-9..=places[2] + 1e-9).contains(x)), "{times:?} {places:?}");
        }
    }

    #[test]
    fn a_path_goes_through_its_keys_without_a_sudden_turn_or_change_of_pace() {
        let keys = [
            key(0.0, 0.0, 0.0, 0.0),
            key(10.0, 1.0, 0.0, 1.0),
            key(12.0, 1.0, 2.0, 1.0),
            key(20.0, 5.0, 2.0, 0.0),
        ];
        for key in &keys {
            let there = pose_at(&keys, key.time).unwrap();
            assert!((there.translation - key.world_from_camera.translation).length() < 1e-12);
        }
        let position = |time: f64| pose_at(&keys, time).unwrap().translation;
        let step = 1e-4;
        for key in &keys[1..3] {
            let [before, here, after] = [-step, 0.0, step].map(|by| position(key.time + by));
            let change = ((after - here) - (here - before)).length() / step;
            assert!(change < 1e-3, "the velocity jumps by {change} at {}", key.time);
        }
    }
}
