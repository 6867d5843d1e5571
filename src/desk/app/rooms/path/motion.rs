//! Where the camera of a path is at each picture.
//!
//! Between keys the camera moves by [`overlook_engine::render::film::pose_at`]. Legs take the same number of pictures, or one of their
//! own; lens and place change from key to key by [`Easing`] of the whole path, time evenly. A closed path leads back to its first key,
//! while time goes on as fast as on the legs before on average: the film begins again where it ends.

use glam::{DAffine3, DVec3};

use crate::app::model::camera::OrbitCamera;
use crate::app::rooms::path::{CameraPath, SavedPathKey};
use overlook_engine::capture::transforms::{Easing, PathView};
use overlook_engine::capture::{Camera, Intrinsics};
use overlook_engine::render::{Vantage, film};

impl CameraPath {
    /// Pictures of the whole path; 0 with fewer than two keys. The last one of a closed path is just before its first.
    pub(crate) fn pictures(&self) -> usize {
        match self.starts().last() {
            Some(&last) if last > 0 => last + usize::from(!self.is_closed),
            _ => 0,
        }
    }

    /// The picture at each key, and at the end of a closed path; empty without keys.
    pub(crate) fn starts(&self) -> Vec<usize> {
        let add = |at: &mut usize, leg| {
            *at += self.pictures_of_leg(leg);
            Some(*at)
        };
        let ends = (0..self.legs()).scan(0, add);
        self.keys.first().map(|_| 0).into_iter().chain(ends).collect()
    }

    /// Legs from key to key, with the way back of a closed path.
    pub(crate) fn legs(&self) -> usize {
        let between = self.keys.len().saturating_sub(1);
        between + usize::from(self.is_closed && between > 0)
    }

    /// Pictures from a key to the next.
    pub(crate) fn pictures_of_leg(&self, leg: usize) -> usize {
        self.keys.get(leg).and_then(|key| key.pictures).unwrap_or(self.pictures_per_leg)
    }

    /// The frame at which all keys lie, if there is one and there are two keys or more: time stands still along the path.
    pub(crate) fn only_frame(&self) -> Option<usize> {
        let first = self.keys.first().filter(|_| self.keys.len() > 1)?.frame;
        self.keys.iter().all(|key| key.frame == first).then_some(first)
    }

    /// The pose of the view at a picture, and its frame; `None` without keys.
    pub(crate) fn at(&self, picture: f32) -> Option<SavedPathKey> {
        let starts = self.starts();
        let end = *starts.last()? as f64;
        let time = f64::from(picture).clamp(0.0, end);
        let eased = if end > 0.0 { end * self.easing.way(time / end) } else { time };
        let ([from, to], share) = self.leg_at(&starts, eased);
        let mut orbit = from.orbit.clone();
        orbit.world_from_camera = film::pose_at(&self.timed_keys(&starts), eased)?;
        orbit.lens = lens_between([from.orbit.lens, to.orbit.lens], share);
        orbit.pivot_distance = between(from.orbit.pivot_distance, to.orbit.pivot_distance, share);
        if let Some(target) = self.looks_at {
            look_at(&mut orbit, target);
        }
        Some(SavedPathKey { orbit, frame: self.frame_at(&starts, time), pictures: None })
    }

    /// The keys before and behind a time in pictures, and its share of the way from one to the other.
    fn leg_at(&self, starts: &[usize], time: f64) -> ([&SavedPathKey; 2], f64) {
        let leg = starts.partition_point(|start| *start as f64 <= time).saturating_sub(1);
        let leg = leg.min(self.legs().saturating_sub(1));
        let [from, to] = [leg, leg + 1].map(|key| &self.keys[key % self.keys.len()]);
        let length = starts.get(leg + 1).map_or(0, |end| end - starts[leg]);
        let share = if length > 0 { (time - starts[leg] as f64) / length as f64 } else { 0.0 };
        ([from, to], share)
    }

    fn frame_at(&self, starts: &[usize], time: f64) -> usize {
        let ([from, to], share) = self.leg_at(starts, time);
        let back = starts.get(self.keys.len() - 1).is_some_and(|last| time > *last as f64);
        let to_frame = if back {
            let [first, last] = [&self.keys[0], &self.keys[self.keys.len() - 1]].map(|key| key.frame as f64);
            (last + (last - first) / (self.keys.len() - 1) as f64).max(0.0)
        } else {
            to.frame as f64
        };
        between(from.frame as f64, to_frame, share).round() as usize
    }

    /// The keys at their times in pictures. A closed path has those beyond its ends, too, so that it goes on there as elsewhere.
    fn timed_keys(&self, starts: &[usize]) -> Vec<film::PathKey> {
        let at = |time: f64, key: &SavedPathKey| film::PathKey {
            time,
            world_from_camera: key.orbit.world_from_camera,
        };
        let own = self.keys.iter().zip(starts).map(|(key, start)| at(*start as f64, key));
        let mut timed: Vec<_> = own.collect();
        if self.legs() == self.keys.len() {
            let (last, end) = (self.keys.len() - 1, starts[self.keys.len()] as f64);
            timed.insert(0, at(-(self.pictures_of_leg(last) as f64), &self.keys[last]));
            timed.push(at(end, &self.keys[0]));
            timed.push(at(end + self.pictures_of_leg(0) as f64, &self.keys[1]));
        }
        timed
    }

    /// The pictures of the path as a manifest holds them, of a scene whose frames have these numbers. They go at an even pace; the
    /// manifest says the easing.
    pub(crate) fn views(&self, size: [u32; 2], frame_numbers: &[i64]) -> Vec<PathView> {
        let even = Self { easing: Easing::Linear, ..self.clone() };
        let vantages = even.vantages(size, frame_numbers.len()).into_iter().enumerate();
        let starts = self.starts();
        let view = |(index, Vantage { camera, frame }): (usize, Vantage)| PathView {
            camera,
            frame_number: frame_numbers.get(frame).copied().unwrap_or_default(),
            is_key: starts.binary_search(&index).is_ok(),
        };
        vantages.map(view).collect()
    }

    /// Where the path is as frame after frame passes, for pictures of `size` of a scene of `frames` frames: the first vantage at each frame
    /// from the first key's to the last key's. Empty where time does not pass along the path.
    pub(crate) fn vantage_of_each_frame(&self, size: [u32; 2], frames: usize) -> Vec<Vantage> {
        let vantages = self.vantages(size, frames);
        let (Some(first), Some(last)) = (vantages.first(), vantages.last()) else { return Vec::new() };
        if last.frame <= first.frame {
            return Vec::new();
        }
        let reached = |frame| vantages.iter().find(|vantage| vantage.frame >= frame);
        (first.frame..=last.frame)
            .filter_map(|frame| Some(Vantage { frame, ..reached(frame)?.clone() }))
            .collect()
    }

    /// Every picture's vantage, for pictures of `width` by `height` pixels of a scene of `frames` frames.
    pub(crate) fn vantages(&self, [width, height]: [u32; 2], frames: usize) -> Vec<Vantage> {
        let keys = (0..self.pictures()).filter_map(|picture| self.at(picture as f32));
        let last = frames.saturating_sub(1);
        keys.map(|key| Vantage { camera: key.orbit.camera(width, height), frame: key.frame.min(last) })
            .collect()
    }
}

fn between(from: f64, to: f64, share: f64) -> f64 {
    from + (to - from) * share
}

/// Turns a view to a point, with a level horizon; straight above and below the point it stays as it is.
fn look_at(orbit: &mut OrbitCamera, target: DVec3) {
    let DAffine3 { translation: eye, .. } = orbit.world_from_camera;
    let (way, up) = (target - eye, orbit.up_in_world);
    if way.cross(up).length() > 1e-9 * way.length() {
        orbit.world_from_camera = Camera::look_at("", orbit.lens, eye, target, up).world_from_camera;
        orbit.pivot_distance = way.length();
    }
}

/// The lens on the way from one to another: its field of view changes evenly, for pictures of any size.
fn lens_between([from, to]: [Intrinsics; 2], share: f64) -> Intrinsics {
    if from == to {
        return from;
    }
    let between = |of: &dyn Fn(&Intrinsics) -> f64| of(&from) + (of(&to) - of(&from)) * share;
    let width = between(&|lens| f64::from(lens.width)).round();
    let height = between(&|lens| f64::from(lens.height)).round();
    Intrinsics {
        width: width as u32,
        height: height as u32,
        // Both by the width, so that square pixels stay square when a side is rounded.
        fx: width * between(&|lens| lens.fx / f64::from(lens.width)),
        fy: width * between(&|lens| lens.fy / f64::from(lens.width)),
        cx: width * between(&|lens| lens.cx / f64::from(lens.width)),
        cy: height * between(&|lens| lens.cy / f64::from(lens.height)),
        projection: from.projection,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::rooms::path::Turntable;

    #[test]
    fn the_path_goes_through_its_keys() {
        let positions = [DVec3::ZERO, DVec3::X, DVec3::new(2.0, 1.0, 0.0)];
        let path = CameraPath::for_tests(&positions);
        assert_eq!(path.pictures(), 17);
        for (index, position) in positions.into_iter().enumerate() {
            let key = path.at(index as f32 * 8.0).unwrap();
            assert!((key.orbit.world_from_camera.translation - position).length() < 1e-9);
            assert_eq!(key.frame, index * 10);
        }
        assert_eq!(path.at(4.0).unwrap().frame, 5);
        assert_eq!(path.at(1e9), path.at(16.0), "beyond the end it stays");
        let one = CameraPath::for_tests(&[DVec3::X]);
        assert!(one.at(3.0).is_some() && one.pictures() == 0, "a path needs two keys");
        assert_eq!(CameraPath::for_tests(&[]).at(0.0), None);
    }

    #[test]
    fn the_lens_zooms_from_each_key_to_the_next_and_the_last_one_is_reached() {
        let mut path = CameraPath::for_tests(&[DVec3::ZERO, DVec3::X]);
        let wide = path.keys[0].orbit.lens;
        let zoomed = Intrinsics { fy: 6.0 * wide.fy, ..Intrinsics::centered(192, 144, 6.0 * wide.fx) };
        path.keys[1].orbit.lens = zoomed;
        let focal = |picture: f32| {
            let camera = path.at(picture).unwrap().orbit.camera(640, 480);
            assert_eq!([camera.intrinsics.cx, camera.intrinsics.cy], [320.0, 240.0]);
            assert!((camera.intrinsics.fx - camera.intrinsics.fy).abs() < 1e-9);
            camera.intrinsics.fx / (10.0 * wide.fx)
        };
        for (picture, expected) in [(0.0, 1.0), (4.0, 1.5), (8.0, 2.0), (99.0, 2.0)] {
            assert!((focal(picture) - expected).abs() < 1e-9, "{picture}: {}", focal(picture));
        }
        assert_eq!(path.at(8.0).unwrap().orbit.lens.width, 192);
    }

    #[test]
    fn each_frame_that_passes_along_the_path_has_a_place_on_it_unless_all_keys_lie_at_one() {
        let mut path = CameraPath::for_tests(&[DVec3::ZERO, DVec3::X, DVec3::new(2.0, 1.0, 0.0)]);
        let places = path.vantage_of_each_frame([64, 48], 100);
        assert!(places.iter().map(|vantage| vantage.frame).eq(0..=20));
        assert!((places[20].camera.position_in_world() - DVec3::new(2.0, 1.0, 0.0)).length() < 1e-9);
        assert_eq!(path.only_frame(), None);
        path.keys.iter_mut().for_each(|key| key.frame = 3);
        assert!(path.vantage_of_each_frame([64, 48], 100).is_empty(), "it stays at a moment");
        assert_eq!(path.only_frame(), Some(3));
        path.keys.truncate(1);
        assert_eq!(path.only_frame(), None, "one key is no path");
    }

    #[test]
    fn a_turn_around_the_pivot_is_closed_keeps_its_distance_and_looks_at_it() {
        let view = OrbitCamera::for_tests();
        let pivot = view.world_from_camera.transform_point3(DVec3::Z * view.pivot_distance);
        let turntable = Turntable { keys: 12, seconds: 6.0, passes_time: true };
        let mut path = CameraPath { turntable, ..CameraPath::default() };
        path.turn_around(&view, [0, 24], 24.0);
        assert_eq!((path.keys.len(), path.pictures(), path.is_closed), (12, 144, true));
        let radius = view.world_from_camera.translation.distance(pivot);
        for picture in 0..144 {
            let SavedPathKey { orbit, frame, .. } = path.at(picture as f32).unwrap();
            let eye = orbit.world_from_camera.translation;
            assert!((eye.distance(pivot) - radius).abs() < 0.005 * radius, "picture {picture}");
            let ahead = orbit.world_from_camera.matrix3.z_axis;
            assert!(ahead.dot((pivot - eye).normalize_or_zero()) > 0.9999, "picture {picture}");
            assert!(frame.abs_diff(picture / 6) <= 1, "picture {picture} at frame {frame}");
        }
        let [first, last] = [0.0, 143.0].map(|picture| path.at(picture).unwrap().orbit.world_from_camera);
        let step = path.at(1.0).unwrap().orbit.world_from_camera.translation.distance(first.translation);
        let seam = last.translation.distance(first.translation);
        assert!((seam / step - 1.0).abs() < 0.02, "it goes on where it begins: {seam} beside {step}");
    }

    #[test]
    fn easing_moves_the_camera_and_not_the_time_and_the_ends_stay() {
        let mut path = CameraPath::for_tests(&[DVec3::ZERO, DVec3::X]);
        path.easing = Easing::InOut;
        let x = |picture: f32| path.at(picture).unwrap().orbit.world_from_camera.translation.x;
        assert!(x(0.0).abs() < 1e-12 && (x(8.0) - 1.0).abs() < 1e-12);
        assert!((x(2.0) - Easing::InOut.way(0.25)).abs() < 1e-9);
        assert_eq!(path.at(4.0).unwrap().frame, 5);
    }

    #[test]
    fn the_camera_looks_at_one_point_all_the_way() {
        let mut path = CameraPath::for_tests(&[DVec3::new(-3.0, -4.0, 1.0), DVec3::new(3.0, -4.0, 2.0)]);
        let target = DVec3::new(0.5, 1.0, 0.0);
        path.looks_at = Some(target);
        for picture in 0..path.pictures() {
            let orbit = path.at(picture as f32).unwrap().orbit;
            let seen = orbit.world_from_camera.inverse().transform_point3(target);
            assert!(seen.truncate().length() < 1e-9 && (seen.z - orbit.pivot_distance).abs() < 1e-9);
        }
    }
}
