//! The camera path.

pub(crate) mod control;
mod motion;
pub(crate) mod ui;

use glam::{DVec2, DVec3};

use crate::app::model::camera::OrbitCamera;
use overlook_engine::capture::transforms::{Easing, PathView};

/// Why a path of fewer than two keys cannot be exported.
pub(crate) const NO_KEYS: &str =
    "A camera path needs two keys at least; add them in the Camera path view (K).";

/// The most pictures from one key to the next.
pub(crate) const MOST_ON_A_LEG: usize = 2000;

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
}

impl Default for CameraPath {
    fn default() -> Self {
        Self {
            keys: Vec::new(),
            pictures_per_leg: 48,
            is_closed: false,
            easing: Easing::Linear,
            looks_at: None,
            turntable: Turntable { keys: 12, seconds: 8.0, passes_time: false },
            selected: None,
            size: None,
            saved: Vec::new(),
            playing: None,
        }
    }
}

impl CameraPath {
    /// What of it can be taken back, as it is now.
    pub(crate) fn shape(&self) -> PathShape {
        PathShape { keys: self.keys.clone(), is_closed: self.is_closed }
    }

    /// Makes the whole path as long as some seconds at so many pictures a second, or as near to it as whole pictures on every leg allow;
    /// legs keep their shares of it.
    pub(crate) fn set_seconds(&mut self, seconds: f64, rate: f64) {
        let Some(now) = self.starts().last().copied().filter(|now| *now > 0) else { return };
        let wanted = (seconds * rate).round() - f64::from(u8::from(!self.is_closed));
        let own = self.keys.iter_mut().filter_map(|key| key.pictures.as_mut());
        for pictures in own.chain([&mut self.pictures_per_leg]) {
            *pictures = within_leg(*pictures as f64 * wanted / now as f64);
        }
    }

    /// Gives the way from a key to the next a length of its own, or that of the others.
    pub(crate) fn set_leg(&mut self, leg: usize, pictures: Option<f64>) {
        if let Some(key) = self.keys.get_mut(leg) {
            key.pictures = pictures.map(within_leg).filter(|pictures| *pictures != self.pictures_per_leg);
        }
    }

    /// Makes the path a turn around the pivot of a view, from the first to the last frame of `played`.
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
        self.pictures_per_leg = within_leg(seconds * rate / keys as f64);
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

    /// Exchanges the view of a key with that of another one, which is then selected. Frames stay in their order, so that time does not turn.
    pub(crate) fn exchange_keys(&mut self, index: usize, other: usize) {
        let orbit = self.keys[index].orbit.clone();
        self.keys[index].orbit = std::mem::replace(&mut self.keys[other].orbit, orbit);
        (self.selected, self.playing) = (Some(other), None);
    }

    /// Makes it what it was.
    pub(crate) fn take_shape(&mut self, PathShape { keys, is_closed }: PathShape) {
        (self.keys, self.is_closed) = (keys, is_closed);
        (self.selected, self.playing) = (None, None);
    }

    /// Takes every key out.
    pub(crate) fn clear(&mut self) {
        self.take_shape(PathShape::default());
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

    /// Keys at these positions, ten frames apart, with eight pictures from one to the next.
    #[cfg(test)]
    pub(crate) fn for_tests(positions: &[DVec3]) -> Self {
        let keys = positions.iter().enumerate().map(|(index, position)| {
            let mut orbit = OrbitCamera::for_tests();
            orbit.world_from_camera.translation = *position;
            SavedPathKey { orbit, frame: index * 10, pictures: None }
        });
        Self { keys: keys.collect(), pictures_per_leg: 8, ..Self::default() }
    }
}

/// A number of pictures on a leg, as it can be.
fn within_leg(pictures: f64) -> usize {
    (pictures.round() as usize).clamp(1, MOST_ON_A_LEG)
}

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

impl PathShape {
    /// What was done to the path, in words.
    pub(crate) fn named_change_to(&self, after: &Self) -> String {
        let (before, keys) = (&self.keys, &after.keys);
        let is_other: Vec<bool> = before.iter().zip(keys).map(|(before, after)| before != after).collect();
        let first = is_other.iter().position(|is_other| *is_other);
        let number = first.unwrap_or(before.len().min(keys.len())) + 1;
        let differing = is_other.iter().filter(|is_other| **is_other).count();
        match (keys.len() as i64 - before.len() as i64, differing, self.is_closed == after.is_closed) {
            (0, 0, false) => if after.is_closed { "Close path" } else { "Open path" }.to_owned(),
            _ if keys.is_empty() => "Remove all keys".to_owned(),
            (1, _, true) => format!("Add key {number}"),
            (-1, _, true) => format!("Remove key {number}"),
            (0, 1, true) => format!("Change key {number}"),
            (0, 2, true) => format!("Exchange keys {number} and {}", number + 1),
            _ => "Other camera path".to_owned(),
        }
    }
}

/// A turn around the pivot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Turntable {
    pub keys: usize,
    pub seconds: f64,
    /// Whether the played frames pass meanwhile, or the one that is shown stays.
    pub passes_time: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_is_moved_between_its_neighbors() {
        let mut path = CameraPath::for_tests(&[DVec3::ZERO, DVec3::X, DVec3::Y]);
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
        let mut path = CameraPath::for_tests(&[DVec3::ZERO, DVec3::X, 2.0 * DVec3::X]);
        let mut between = path.keys[0].clone();
        between.orbit.world_from_camera.translation = 0.5 * DVec3::X;
        between.frame = 5;
        path.selected = Some(0);
        assert_eq!(path.add_key(between), 1);
        assert_eq!((x(&path), frames(&path)), (vec![0.0, 0.5, 1.0, 2.0], vec![0, 5, 10, 20]));
        path.exchange_keys(1, 2);
        assert_eq!((x(&path), frames(&path)), (vec![0.0, 1.0, 0.5, 2.0], vec![0, 5, 10, 20]));
        assert_eq!(path.selected, Some(2));
        path.remove_key(0);
        assert_eq!(path.selected, Some(1));
        path.remove_key(1);
        assert_eq!((path.selected, x(&path)), (None, vec![1.0, 2.0]));
    }

    #[test]
    fn the_length_is_set_in_seconds_and_pictures_on_each_leg_follow() {
        let mut path = CameraPath::for_tests(&[DVec3::ZERO, DVec3::X, DVec3::Y]);
        path.set_seconds(4.0, 24.0);
        assert_eq!((path.pictures_per_leg, path.pictures()), (48, 97));
        path.set_seconds(0.0, 24.0);
        assert_eq!(path.pictures_per_leg, 1);
        path.set_seconds(1e9, 24.0);
        assert_eq!(path.pictures_per_leg, MOST_ON_A_LEG);
    }

    #[test]
    fn a_leg_of_its_own_length_is_slow_motion_and_scales_with_the_whole() {
        let mut path = CameraPath::for_tests(&[DVec3::ZERO, DVec3::X, 2.0 * DVec3::X]);
        path.set_leg(1, Some(24.0));
        assert_eq!(path.pictures(), 33);
        assert_eq!((path.at(8.0).unwrap().frame, path.at(20.0).unwrap().frame), (10, 15));
        path.set_seconds(65.0, 1.0);
        assert_eq!((path.pictures_per_leg, path.keys[1].pictures, path.pictures()), (16, Some(48), 65));
        path.set_leg(1, None);
        assert_eq!(path.pictures(), 33);
    }

    #[test]
    fn a_closed_path_with_legs_of_their_own_comes_back_from_its_pictures() {
        let mut path = CameraPath::for_tests(&[DVec3::ZERO, DVec3::X, DVec3::Y]);
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
}
