//! A camera path: keys taken from the live view, which plays it, and pictures or a film exported from it.
//!
//! Between keys the camera moves by [`overlook_engine::render::film::pose_at`]. Legs take the same number of pictures, or one of their
//! own; lens and place change from key to key by [`Easing`] of the whole path, time evenly. A closed path leads back to its first key,
//! while time goes on as fast as on the legs before on average: the film begins again where it ends.

use super::command::KeyNeighbor;
use crate::app::rooms::live::model::orbit_camera::OrbitCamera;
use crate::app::rooms::settings::model::undo::Steps;
use glam::{DAffine3, DVec2, DVec3};
use overlook_engine::capture::transforms::{Easing, PathView};
use overlook_engine::capture::{Camera, Intrinsics};
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
    /// Pictures from here to the next key; `None` for those of the path.
    pub pictures: Option<usize>,
}

/// What of a path can be taken back.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct PathShape {
    pub keys: Vec<SavedPathKey>,
    pub is_closed: bool,
}

/// A turn around the pivot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Turntable {
    pub keys: usize,
    pub seconds: f64,
    /// Whether the played frames pass meanwhile, or the one that is shown stays.
    pub passes_time: bool,
}

impl Default for Turntable {
    fn default() -> Self {
        Self { keys: 12, seconds: 8.0, passes_time: false }
    }
}

/// A camera path.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CameraPath {
    /// The keys, in order.
    pub keys: Vec<SavedPathKey>,
    /// Pictures from one key to the next, where the key has none of its own.
    pub pictures_per_leg: usize,
    /// Whether the camera goes back to the first key.
    pub is_closed: bool,
    /// How it sets off and arrives over the whole path.
    pub easing: Easing,
    /// The point in world space that it looks at all the way, wherever keys look.
    pub looks_at: Option<DVec3>,
    /// The turn that would be added.
    pub turntable: Turntable,
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
    steps: Steps<PathShape>,
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
            is_closed: false,
            easing: Easing::Linear,
            looks_at: None,
            turntable: Turntable::default(),
            selected: None,
            size: None,
            saved: Vec::new(),
            playing: None,
            changes: KeyChanges::default(),
        }
    }
}

impl CameraPath {
    /// What of it can be taken back, as it is now.
    pub(crate) fn shape(&self) -> PathShape {
        PathShape { keys: self.keys.clone(), is_closed: self.is_closed }
    }

    /// Pictures of the whole path; 0 with fewer than two keys. The last one of a closed path is just before its first.
    pub(crate) fn pictures(&self) -> usize {
        match self.starts().last() {
            Some(&last) if last > 0 => last + usize::from(!self.is_closed),
            _ => 0,
        }
    }

    /// The picture at each key, and at the end of a closed path; empty without keys.
    fn starts(&self) -> Vec<usize> {
        let add = |at: &mut usize, leg| {
            *at += self.pictures_of_leg(leg);
            Some(*at)
        };
        let ends = (0..self.legs()).scan(0, add);
        self.keys.first().map(|_| 0).into_iter().chain(ends).collect()
    }

    /// Legs from key to key, with the way back of a closed path.
    fn legs(&self) -> usize {
        let between = self.keys.len().saturating_sub(1);
        between + usize::from(self.is_closed && between > 0)
    }

    /// Pictures from a key to the next.
    pub(crate) fn pictures_of_leg(&self, leg: usize) -> usize {
        self.keys.get(leg).and_then(|key| key.pictures).unwrap_or(self.pictures_per_leg)
    }

    /// Whether the camera goes on from a key.
    pub(crate) fn has_leg(&self, leg: usize) -> bool {
        leg < self.legs()
    }

    /// Seconds of the whole path at so many pictures a second.
    pub(crate) fn seconds(&self, rate: f64) -> f64 {
        self.pictures() as f64 / rate
    }

    /// Makes the whole path as long as some seconds at so many pictures a second, or as near to it as whole pictures on every leg allow;
    /// legs keep their shares of it.
    pub(crate) fn set_seconds(&mut self, seconds: f64, rate: f64) {
        let Some(now) = self.starts().last().copied().filter(|now| *now > 0) else { return };
        let wanted = (seconds * rate).round() - f64::from(u8::from(!self.is_closed));
        let scaled = |pictures: usize| within_leg(pictures as f64 * wanted / now as f64);
        self.pictures_per_leg = scaled(self.pictures_per_leg);
        for key in &mut self.keys {
            key.pictures = key.pictures.map(scaled);
        }
    }

    /// Sets how many pictures lie on each leg that has no number of its own.
    pub(crate) fn set_pictures_per_leg(&mut self, pictures: usize) {
        self.pictures_per_leg = pictures.clamp(1, MOST_ON_A_LEG);
    }

    /// Gives the way from a key to the next a length of its own, or that of the others.
    pub(crate) fn set_leg(&mut self, leg: usize, pictures: Option<f64>) {
        if let Some(key) = self.keys.get_mut(leg) {
            key.pictures = pictures.map(within_leg);
        }
    }

    /// Makes the path a turn around the pivot of a view, of which `played` are the first and the last frame.
    pub(crate) fn turn_around(&mut self, view: &OrbitCamera, played: [usize; 2], rate: f64) {
        let Turntable { keys, seconds, .. } = self.turntable;
        let [first, last] = played.map(|frame| frame as f64);
        let key = |nth: usize| {
            let share = nth as f64 / keys as f64;
            let mut orbit = view.clone();
            orbit.orbit(DVec2::new(std::f64::consts::TAU * share, 0.0));
            let frame = (first + (last - first) * share).round() as usize;
            SavedPathKey { orbit, frame, pictures: None }
        };
        self.keys = (0..keys).map(key).collect();
        (self.is_closed, self.selected, self.playing) = (true, None, None);
        self.set_pictures_per_leg((seconds * rate / keys as f64).round() as usize);
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
        let from_frame = from.frame as f64;
        let to_frame = if back {
            let [first, last] = [&self.keys[0], &self.keys[self.keys.len() - 1]].map(|key| key.frame as f64);
            (last + (last - first) / (self.keys.len() - 1) as f64).max(0.0)
        } else {
            to.frame as f64
        };
        between(from_frame, to_frame, share).round() as usize
    }

    /// The keys at their times in pictures. A closed path has those beyond its ends, too, so that it goes on there as elsewhere.
    fn timed_keys(&self, starts: &[usize]) -> Vec<film::PathKey> {
        let at = |time: f64, key: &SavedPathKey| film::PathKey {
            time,
            world_from_camera: key.orbit.world_from_camera,
        };
        let own = self.keys.iter().zip(starts).map(|(key, start)| at(*start as f64, key));
        let mut timed: Vec<_> = own.collect();
        if self.has_leg(self.keys.len() - 1) {
            let (last, end) = (self.keys.len() - 1, starts[self.keys.len()] as f64);
            timed.insert(0, at(-(self.pictures_of_leg(last) as f64), &self.keys[last]));
            timed.push(at(end, &self.keys[0]));
            timed.push(at(end + self.pictures_of_leg(0) as f64, &self.keys[1]));
        }
        timed
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

    /// Notes that the path was `before`, if it changed; `moved` is the key that was moved.
    pub(crate) fn note_change(&mut self, before: PathShape, moved: Option<usize>) {
        if before == self.shape() {
            return;
        }
        let changes = &mut self.changes;
        let goes_on = moved.is_some() && changes.moved == moved && changes.is_latest;
        changes.steps.record(before, !goes_on);
        (changes.moved, changes.is_latest) = (moved, true);
    }

    /// Takes the last change of the keys back, or does it again; false where there is none, or something else was changed since.
    pub(crate) fn step(&mut self, undo: bool) -> bool {
        let now = self.shape();
        let changes = &mut self.changes;
        if !changes.is_latest {
            return false;
        }
        let Some(PathShape { keys, is_closed }) = changes.steps.step(undo, now) else { return false };
        changes.moved = None;
        (self.keys, self.is_closed) = (keys, is_closed);
        (self.selected, self.playing) = (None, None);
        true
    }

    /// Whether all keys are in a file.
    pub(crate) fn is_saved(&self) -> bool {
        self.keys.is_empty() || self.keys == self.saved
    }

    /// Takes over how many pictures lie between keys, and their size, from the pictures of a path whose keys these are. Pictures behind
    /// the last key lead back to the first.
    pub(crate) fn take_pace_of(&mut self, views: &[PathView]) {
        let mut ends: Vec<usize> = (0..views.len()).filter(|index| views[*index].is_key).collect();
        self.is_closed = ends.len() > 1 && views.last().is_some_and(|view| !view.is_key);
        if self.is_closed {
            ends.push(views.len());
        }
        let legs = ends.windows(2).map(|ends| ends[1] - ends[0]);
        // A list of another program has places and no pictures between them.
        if legs.clone().any(|pictures| pictures > 1) {
            self.pictures_per_leg = legs.clone().next().unwrap_or(self.pictures_per_leg);
            for (key, pictures) in self.keys.iter_mut().zip(legs) {
                key.pictures = (pictures != self.pictures_per_leg).then_some(pictures);
            }
        }
        self.size = views.first().map(|view| [view.camera.intrinsics.width, view.camera.intrinsics.height]);
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

/// A number of pictures on a leg, as it can be.
fn within_leg(pictures: f64) -> usize {
    (pictures.round() as usize).clamp(1, MOST_ON_A_LEG)
}

fn between(from: f64, to: f64, share: f64) -> f64 {
    from + (to - from) * share
}

/// Turns a view to a point, with a level horizon; straight above and below the point it stays as it is.
fn look_at(orbit: &mut OrbitCamera, target: DVec3) {
    let DAffine3 { translation: eye, .. } = orbit.world_from_camera;
    let (way, up) = (target - eye, orbit.up_in_world());
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
    use glam::DVec3;
    use overlook_engine::capture::Projection;

    fn path(positions: &[DVec3]) -> CameraPath {
        let keys = positions.iter().enumerate().map(|(index, position)| {
            let mut orbit = OrbitCamera::for_tests();
            orbit.world_from_camera.translation = *position;
            SavedPathKey { orbit, frame: index * 10, pictures: None }
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
    fn a_turn_around_the_pivot_is_closed_keeps_its_distance_and_looks_at_it() {
        let view = OrbitCamera::for_tests();
        let pivot = view.world_from_camera.transform_point3(DVec3::Z * view.pivot_distance);
        let mut path = CameraPath::default();
        path.turntable = Turntable { keys: 12, seconds: 6.0, passes_time: true };
        path.turn_around(&view, [0, 24], 24.0);
        assert_eq!((path.keys.len(), path.pictures(), path.is_closed), (12, 144, true));
        let radius = view.world_from_camera.translation.distance(pivot);
        for picture in 0..144 {
            let SavedPathKey { orbit, frame, .. } = path.at(picture as f32).unwrap();
            let eye = orbit.world_from_camera.translation;
            assert!((eye.distance(pivot) - radius).abs() < 0.005 * radius, "picture {picture}");
            let ahead = orbit.world_from_camera.matrix3.z_axis;
            assert!(ahead.dot((pivot - eye).normalize()) > 0.9999, "picture {picture}");
            assert!(frame.abs_diff(picture / 6) <= 1, "picture {picture} at frame {frame}");
        }
        let [first, last] = [0.0, 143.0].map(|picture| path.at(picture).unwrap().orbit.world_from_camera);
        let step = path.at(1.0).unwrap().orbit.world_from_camera.translation.distance(first.translation);
        let seam = last.translation.distance(first.translation);
        assert!((seam / step - 1.0).abs() < 0.02, "it goes on where it begins: {seam} beside {step}");
    }

    #[test]
    fn a_leg_of_its_own_length_is_slow_motion_and_scales_with_the_whole() {
        let mut path = path(&[DVec3::ZERO, DVec3::X, 2.0 * DVec3::X]);
        path.set_leg(1, Some(24.0));
        assert_eq!(path.pictures(), 33);
        assert_eq!((path.at(8.0).unwrap().frame, path.at(20.0).unwrap().frame), (10, 15));
        path.set_seconds(65.0, 1.0);
        assert_eq!((path.pictures_per_leg, path.keys[1].pictures, path.pictures()), (16, Some(48), 65));
        path.set_leg(1, None);
        assert_eq!(path.pictures(), 33);
    }

    #[test]
    fn easing_moves_the_camera_and_not_the_time_and_the_ends_stay() {
        let mut path = path(&[DVec3::ZERO, DVec3::X]);
        path.easing = Easing::InOut;
        let x = |picture: f32| path.at(picture).unwrap().orbit.world_from_camera.translation.x;
        assert!(x(0.0).abs() < 1e-12 && (x(8.0) - 1.0).abs() < 1e-12);
        assert!((x(2.0) - Easing::InOut.way(0.25)).abs() < 1e-9);
        assert_eq!(path.at(4.0).unwrap().frame, 5);
    }

    #[test]
    fn the_camera_looks_at_one_point_all_the_way() {
        let mut path = path(&[DVec3::new(-3.0, -4.0, 1.0), DVec3::new(3.0, -4.0, 2.0)]);
        let target = DVec3::new(0.5, 1.0, 0.0);
        path.looks_at = Some(target);
        for picture in 0..path.pictures() {
            let orbit = path.at(picture as f32).unwrap().orbit;
            let seen = orbit.world_from_camera.inverse().transform_point3(target);
            assert!(seen.truncate().length() < 1e-9 && (seen.z - orbit.pivot_distance).abs() < 1e-9);
        }
    }

    #[test]
    fn a_closed_path_with_legs_of_their_own_comes_back_from_its_pictures() {
        let mut path = path(&[DVec3::ZERO, DVec3::X, DVec3::Y]);
        path.is_closed = true;
        path.set_leg(2, Some(5.0));
        let views = path.views([64, 48], &(0..40).collect::<Vec<_>>());
        assert_eq!(views.len(), path.pictures());
        let mut again = path.clone();
        again.keys.iter_mut().for_each(|key| key.pictures = None);
        (again.is_closed, again.pictures_per_leg) = (false, 48);
        again.take_pace_of(&views);
        assert_eq!((again.shape(), again.pictures_per_leg), (path.shape(), 8));
    }

    #[test]
    fn a_path_needs_two_keys() {
        assert_eq!(path(&[]).at(0.0), None);
        assert_eq!(path(&[DVec3::X]).pictures(), 0);
        assert!(path(&[DVec3::X]).at(3.0).is_some());
    }
}
