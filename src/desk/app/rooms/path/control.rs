//! Carries out what concerns the camera path.

use std::path::Path;

use crate::app::control::OverlookApp;
use crate::app::model::camera::OrbitCamera;
use crate::app::model::command::PathCommand;
use crate::app::model::window::{DockView, NoticeKind};
use crate::app::model::{OpenScene, Part, State, Undoable};
use crate::app::rooms::path::{CameraPath, SavedPathKey};
use overlook_engine::capture::transforms::{Easing, PathFile, PathView};
use overlook_engine::plural::counted;

impl OverlookApp {
    pub(crate) fn apply_to_path(&mut self, command: PathCommand) {
        let path = &mut self.state.doc.path;
        let before = Undoable::Path(path.shape());
        let mut bit_by_bit = None;
        match command {
            PathCommand::AddKey => {
                if let Some(key) = self.state.key_here() {
                    self.add_key(key);
                }
            }
            PathCommand::GoToKey(index) => {
                if let Some(key) = path.keys.get(index).cloned() {
                    path.selected = Some(index);
                    self.go_to_key(key);
                }
            }
            PathCommand::Change(changed, key) => (*path, bit_by_bit) = (*changed, key),
            PathCommand::TurnAround => self.turn_around(),
        }
        self.state.note_change(before, bit_by_bit.map(Part::PathKey));
    }

    fn add_key(&mut self, key: SavedPathKey) {
        let added = format!("Key {} added", self.state.doc.path.add_key(key) + 1);
        self.picture_view();
        if !self.visible_views().contains(&DockView::Path) {
            self.state.notify(NoticeKind::Done, added, "The Camera path view plays and exports the path.");
        }
    }

    /// Makes the path a turn around the pivot of the view.
    fn turn_around(&mut self) {
        let rate = f64::from(self.state.timeline.frames_per_second);
        let Some(view) = self.state.live.orbit.clone() else { return };
        let (timeline, frames) = (&self.state.timeline, self.state.frame_count());
        let path = &mut self.state.doc.path;
        let played = if path.turntable.passes_time { timeline.played(frames) } else { [timeline.frame; 2] };
        let replaced = path.keys.len();
        path.turn_around(&view, played, rate);
        if replaced > 0 {
            let text = format!("{} before are gone; Ctrl+Z brings them back.", counted(replaced, "key"));
            self.state.notify(NoticeKind::Done, "The path is a turn", text);
        }
        self.picture_view();
    }

    /// Moves the view to a key of the path.
    pub(crate) fn go_to_key(&mut self, key: SavedPathKey) {
        self.state.live.orbit = Some(key.orbit);
        self.state.timeline.go_to(key.frame, self.state.frame_count());
    }

    /// Takes in the keys of a path that was read: after those that are there.
    pub(crate) fn path_loaded(&mut self, place: &Path, file: &PathFile) {
        let Some(scene) = self.state.doc.scene.clone() else { return };
        let count = self.take_path_views(&scene, &file.views, file.easing);
        let text = format!("{} from {}", counted(count, "key"), place.display());
        self.state.notify(NoticeKind::Done, "Camera path opened", text);
    }

    /// Takes the keys among some views after those that are there; gives how many.
    pub(crate) fn take_path_views(&mut self, scene: &OpenScene, views: &[PathView], easing: Easing) -> usize {
        let path = &mut self.state.doc.path;
        let (before, keys) = (Undoable::Path(path.shape()), path.keys.len());
        path.keys.extend(views.iter().filter(|view| view.is_key).map(|view| key_of(scene, view)));
        let count = path.keys.len() - keys;
        (path.selected, path.playing) = (None, None);
        if keys == 0 {
            path.take_pace_of(views);
            path.easing = easing;
            path.saved = path.keys.clone();
        }
        self.state.note_change(before, None);
        count
    }

    /// Takes in that a path was written.
    pub(crate) fn path_saved(&mut self, place: &Path, saved: CameraPath) {
        self.state.doc.path.saved = saved.keys;
        self.state.notify(NoticeKind::Done, "Saved", place.display().to_string());
    }
}

impl State {
    /// The view as a key.
    pub(crate) fn key_here(&self) -> Option<SavedPathKey> {
        let orbit = self.live.orbit.clone()?;
        Some(SavedPathKey { orbit, frame: self.timeline.frame, pictures: None })
    }
}

/// The key of a view: at the frame of its number, or at the nearest one.
pub(crate) fn key_of(scene: &OpenScene, view: &PathView) -> SavedPathKey {
    let numbers = scene.frame_numbers.iter().enumerate();
    let nearest = numbers.min_by_key(|(_, number)| number.abs_diff(view.frame_number));
    SavedPathKey {
        orbit: OrbitCamera::at_camera(scene, &view.camera),
        frame: nearest.map_or(0, |(index, _)| index),
        pictures: None,
    }
}
