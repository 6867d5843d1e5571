//! A camera path: keys taken from the live view, which plays it, and pictures or a film exported from it.
//!
//! Between keys the camera moves by [`overlook_engine::render::film::pose_at`]. Every leg takes the same number of pictures, and time
//! and lens change evenly from key to key.

use super::command::KeyNeighbor;
use crate::app::rooms::live::model::orbit_camera::OrbitCamera;
use crate::app::rooms::settings::model::undo::Steps;
use overlook_engine::capture::Intrinsics;
use overlook_engine::capture::transforms::PathView;
use overlook_engine::render::Vantage;
use overlook_engine::render::film;

/// Why a path of fewer than two keys cannot be exported.
pub(crate) const NO_KEYS: &str =
    "A camera path needs two keys at least; add them in the Camera path view (K).";

/// The most pictures from one key to the next.
pub(crate) const MOST_ON_A_LEG: usize = 2000;

/// A place on the path.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SavedPathKey {
    pub orbit: OrbitCamera,
    pub frame: usize,
}

/// A camera path.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CameraPath {
    /// The keys, in order.
    pub keys: Vec<SavedPathKey>,
    /// Pictures from one key to the next.
    pub pictures_per_leg: usize,
    /// The key that was gone to or added last; the next one is added behind it, without one at the end.
    pub selected: Option<usize>,
    /// Columns and rows of exported pictures, where they were chosen.
    pub size: Option<[u32; 2]>,
    /// The keys as they were saved or opened last.
    pub saved: Vec<SavedPathKey>,
    /// The picture that is played; `None` while it does not play.
    pub playing: Option<f32>,
    /// What the keys were before each change, and what was taken back.
    pub changes: KeyChanges,
}

/// Earlier keys of a path, and those that were taken back.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct KeyChanges {
    steps: Steps<Vec<SavedPathKey>>,
    /// The key that was moved last, if nothing followed: while it is dragged, all its moves are one change.
    moved: Option<usize>,
    /// Whether nothing else that can be taken back was changed since.
    pub is_latest: bool,
}

impl Default for CameraPath {
    fn default() -> Self {
        Self {
            keys: Vec::new(),
            pictures_per_leg: 48,
            selected: None,
            size: None,
            saved: Vec::new(),
            playing: None,
            changes: KeyChanges::default(),
        }
    }
}

impl CameraPath {
    /// Pictures of the whole path; 0 with fewer than two keys.
    pub(crate) fn pictures(&self) -> usize {
        match self.keys.len() {
            0 | 1 => 0,
            keys => (keys - 1) * self.pictures_per_leg + 1,
        }
    }

    /// Legs from key to key.
    fn legs(&self) -> usize {
        self.keys.len().saturating_sub(1)
    }

    /// Seconds of the whole path at so many pictures a second.
    pub(crate) fn seconds(&self, rate: f64) -> f64 {
        self.pictures() as f64 / rate
    }

    /// Makes the whole path as long as some seconds at so many pictures a second, or as near to it as whole pictures on every leg allow.
    pub(crate) fn set_seconds(&mut self, seconds: f64, rate: f64) {
        let legs = self.legs().max(1);
        let pictures = (seconds * rate).round() - 1.0;
        self.set_pictures_per_leg((pictures / legs as f64).round() as usize);
    }

    /// Sets how many pictures lie on each leg.
    pub(crate) fn set_pictures_per_leg(&mut self, pictures: usize) {
        self.pictures_per_leg = pictures.clamp(1, MOST_ON_A_LEG);
    }

    /// The frame at which all keys lie, if there is one and there are two keys or more: time stands still along the path.
    pub(crate) fn only_frame(&self) -> Option<usize> {
        let first = self.keys.first().filter(|_| self.keys.len() > 1)?.frame;
        self.keys.iter().all(|key| key.frame == first).then_some(first)
    }

    /// The pose of the view at a picture, and its frame; `None` without keys.
    pub(crate) fn at(&self, picture: f32) -> Option<SavedPathKey> {
        let last = self.keys.len().checked_sub(1)?;
        let time = f64::from(picture / self.pictures_per_leg as f32).clamp(0.0, last as f64);
        let timed = self.keys.iter().enumerate().map(|(index, key)| film::PathKey {
            time: index as f64,
            world_from_camera: key.orbit.world_from_camera,
        });
        let world_from_camera = film::pose_at(&timed.collect::<Vec<_>>(), time)?;
        let leg = (time as usize).min(last.saturating_sub(1));
        let share = time - leg as f64;
        let (from, to) = (&self.keys[leg], &self.keys[(leg + 1).min(last)]);
        let between = |from: f64, to: f64| from + (to - from) * share;
        let mut orbit = from.orbit.clone();
        orbit.world_from_camera = world_from_camera;
        orbit.lens = lens_between([from.orbit.lens, to.orbit.lens], share);
        orbit.pivot_distance = between(from.orbit.pivot_distance, to.orbit.pivot_distance);
        Some(SavedPathKey { orbit, frame: between(from.frame as f64, to.frame as f64).round() as usize })
    }

    /// Moves a key to a frame. Keys that follow each other in time go on doing so: a neighbor stops it.
    pub(crate) fn move_key(&mut self, index: usize, frame: usize) {
        let Some(own) = self.keys.get(index).map(|key| key.frame) else { return };
        let neighbor = |index: Option<usize>| Some(self.keys.get(index?)?.frame);
        let before = neighbor(index.checked_sub(1)).filter(|before| *before <= own);
        let after = neighbor(index.checked_add(1)).filter(|after| *after >= own);
        self.keys[index].frame = frame.clamp(before.unwrap_or(0), after.unwrap_or(usize::MAX));
        self.playing = None;
    }

    /// Adds a key behind the selected one, or at the end; it is then the selected one. Gives its index.
    pub(crate) fn add_key(&mut self, key: SavedPathKey) -> usize {
        let index = self.selected.map_or(self.keys.len(), |selected| (selected + 1).min(self.keys.len()));
        self.keys.insert(index, key);
        (self.selected, self.playing) = (Some(index), None);
        index
    }

    /// Removes a key; the selected one is then none, or the same as before.
    pub(crate) fn remove_key(&mut self, index: usize) {
        if index < self.keys.len() {
            self.keys.remove(index);
            let selected = self.selected.filter(|selected| *selected != index);
            self.selected = selected.map(|selected| selected - usize::from(selected > index));
            self.playing = None;
        }
    }

    /// Exchanges the view of a key with that of the key before it or behind it. Frames stay in their order, so that time does not turn.
    pub(crate) fn exchange_key(&mut self, index: usize, with: KeyNeighbor) {
        let other = match with {
            KeyNeighbor::Before => index.checked_sub(1),
            KeyNeighbor::Behind => index.checked_add(1),
        };
        let Some(other) = other.filter(|other| index.max(*other) < self.keys.len()) else { return };
        let orbit = self.keys[index].orbit.clone();
        self.keys[index].orbit = std::mem::replace(&mut self.keys[other].orbit, orbit);
        (self.selected, self.playing) = (Some(other), None);
    }

    /// Notes that the keys were `before`, if they changed; `moved` is the key that was moved.
    pub(crate) fn note_change(&mut self, before: Vec<SavedPathKey>, moved: Option<usize>) {
        let changes = &mut self.changes;
        if before == self.keys {
            return;
        }
        let goes_on = moved.is_some() && changes.moved == moved && changes.is_latest;
        changes.steps.record(before, !goes_on);
        (changes.moved, changes.is_latest) = (moved, true);
    }

    /// Takes the last change of the keys back, or does it again; false where there is none, or something else was changed since.
    pub(crate) fn step(&mut self, undo: bool) -> bool {
        let changes = &mut self.changes;
        if !changes.is_latest {
            return false;
        }
        let Some(keys) = changes.steps.step(undo, self.keys.clone()) else { return false };
        self.keys = keys;
        changes.moved = None;
        (self.selected, self.playing) = (None, None);
        true
    }

    /// Whether all keys are in a file.
    pub(crate) fn is_saved(&self) -> bool {
        self.keys.is_empty() || self.keys == self.saved
    }

    /// Takes over how many pictures lie between keys, and their size, from the pictures of a path.
    pub(crate) fn take_pace_of(&mut self, views: &[PathView]) {
        let mut keys = views.iter().enumerate().filter(|(_, view)| view.is_key).map(|(index, _)| index);
        if let (Some(first), Some(second)) = (keys.next(), keys.next())
            && second > first + 1
        {
            self.pictures_per_leg = second - first;
        }
        self.size = views.first().map(|view| [view.camera.intrinsics.width, view.camera.intrinsics.height]);
    }

    /// The pictures of the path as a manifest holds them, of a scene whose frames have these numbers.
    pub(crate) fn views(&self, size: [u32; 2], frame_numbers: &[i64]) -> Vec<PathView> {
        let vantages = self.vantages(size, frame_numbers.len()).into_iter().enumerate();
        let view = |(index, Vantage { camera, frame }): (usize, Vantage)| PathView {
            camera,
            frame_number: frame_numbers.get(frame).copied().unwrap_or_default(),
            is_key: index % self.pictures_per_leg == 0,
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
    use glam::DVec3;
    use overlook_engine::capture::Projection;

    fn path(positions: &[DVec3]) -> CameraPath {
        let keys = positions.iter().enumerate().map(|(index, position)| {
            let mut orbit = OrbitCamera::for_tests();
            orbit.world_from_camera.translation = *position;
            SavedPathKey { orbit, frame: index * 10 }
        });
        CameraPath { keys: keys.collect(), pictures_per_leg: 8, ..CameraPath::default() }
    }

    #[test]
    fn the_path_goes_through_its_keys() {
        let positions = [DVec3::ZERO, DVec3::X, DVec3::new(2.0, 1.0, 0.0)];
        let path = path(&positions);
        assert_eq!(path.pictures(), 17);
        for (index, position) in positions.into_iter().enumerate() {
            let key = path.at(index as f32 * 8.0).unwrap();
            assert!((key.orbit.world_from_camera.translation - position).length() < 1e-9);
            assert_eq!(key.frame, index * 10);
        }
        assert_eq!(path.at(4.0).unwrap().frame, 5);
        assert_eq!(path.at(1e9), path.at(16.0), "beyond the end it stays");
    }

    #[test]
    fn the_lens_zooms_from_each_key_to_the_next_and_the_last_one_is_reached() {
        let mut path = path(&[DVec3::ZERO, DVec3::X]);
        let wide = path.keys[0].orbit.lens;
        let zoomed = Intrinsics {
            fx: 6.0 * wide.fx,
            fy: 6.0 * wide.fy,
            cx: 96.0,
            cy: 72.0,
            width: 192,
            height: 144,
            projection: Projection::Perspective,
        };
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
    fn each_frame_that_passes_along_the_path_has_a_place_on_it() {
        let mut path = path(&[DVec3::ZERO, DVec3::X, DVec3::new(2.0, 1.0, 0.0)]);
        let places = path.vantage_of_each_frame([64, 48], 100);
        assert!(places.iter().map(|vantage| vantage.frame).eq(0..=20));
        assert!((places[20].camera.position_in_world() - DVec3::new(2.0, 1.0, 0.0)).length() < 1e-9);
        path.keys.iter_mut().for_each(|key| key.frame = 3);
        assert!(path.vantage_of_each_frame([64, 48], 100).is_empty(), "it stays at a moment");
    }

    #[test]
    fn a_key_is_moved_between_its_neighbors() {
        let mut path = path(&[DVec3::ZERO, DVec3::X, DVec3::Y]);
        for (index, frame, reached) in
            [(1, 4, 4), (1, 33, 20), (2, 25, 25), (0, 90, 20), (0, 0, 0), (7, 3, 0)]
        {
            path.move_key(index, frame);
            assert_eq!(path.keys.get(index).map_or(0, |key| key.frame), reached, "key {index} to {frame}");
        }
        assert!(!path.is_saved());
    }

    #[test]
    fn keys_are_added_behind_the_selected_one_and_exchanged_while_frames_stay_in_order() {
        let x = |path: &CameraPath| -> Vec<f64> {
            path.keys.iter().map(|key| key.orbit.world_from_camera.translation.x).collect()
        };
        let frames = |path: &CameraPath| path.keys.iter().map(|key| key.frame).collect::<Vec<_>>();
        let mut path = path(&[DVec3::ZERO, DVec3::X, 2.0 * DVec3::X]);
        let mut between = path.keys[0].clone();
        between.orbit.world_from_camera.translation = 0.5 * DVec3::X;
        between.frame = 5;
        path.selected = Some(0);
        assert_eq!(path.add_key(between), 1);
        assert_eq!((x(&path), frames(&path)), (vec![0.0, 0.5, 1.0, 2.0], vec![0, 5, 10, 20]));
        path.exchange_key(1, KeyNeighbor::Behind);
        assert_eq!((x(&path), frames(&path)), (vec![0.0, 1.0, 0.5, 2.0], vec![0, 5, 10, 20]));
        assert_eq!(path.selected, Some(2));
        path.exchange_key(0, KeyNeighbor::Before);
        path.exchange_key(3, KeyNeighbor::Behind);
        path.exchange_key(9, KeyNeighbor::Before);
        assert_eq!(x(&path), [0.0, 1.0, 0.5, 2.0], "there is nothing before the first, nor behind the last");
        path.remove_key(0);
        assert_eq!(path.selected, Some(1));
        path.remove_key(1);
        assert_eq!((path.selected, x(&path)), (None, vec![1.0, 2.0]));
    }

    #[test]
    fn the_length_is_set_in_seconds_and_pictures_on_each_leg_follow() {
        let mut path = path(&[DVec3::ZERO, DVec3::X, DVec3::Y]);
        path.set_seconds(4.0, 24.0);
        assert_eq!((path.pictures_per_leg, path.pictures()), (48, 97));
        assert!((path.seconds(24.0) - 97.0 / 24.0).abs() < 1e-12);
        path.set_seconds(0.0, 24.0);
        assert_eq!(path.pictures_per_leg, 1);
        path.set_seconds(1e9, 24.0);
        assert_eq!(path.pictures_per_leg, MOST_ON_A_LEG);
    }

    #[test]
    fn time_stands_still_where_all_keys_lie_at_one_frame() {
        let mut path = path(&[DVec3::ZERO, DVec3::X]);
        assert_eq!(path.only_frame(), None);
        path.keys[1].frame = 0;
        assert_eq!(path.only_frame(), Some(0));
        path.keys.pop();
        assert_eq!(path.only_frame(), None, "one key is no path");
    }

    #[test]
    fn a_path_needs_two_keys() {
        assert_eq!(path(&[]).at(0.0), None);
        assert_eq!(path(&[DVec3::X]).pictures(), 0);
        assert!(path(&[DVec3::X]).at(3.0).is_some());
    }
}
