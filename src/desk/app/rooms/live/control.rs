//! Carries out what concerns the live view's camera and what surrounds its picture.

use std::path::Path;

use super::model::{FLY_SPEEDS, OrbitCamera, ViewCommand};
use crate::address;
use crate::app::control::overlook_app::OverlookApp;
use crate::app::model::{Command, OpenScene};
use crate::app::rooms::frame::model::NoticeKind;
use crate::app::rooms::path::model::{CameraPath, SavedPathKey};
use overlook_engine::capture::transforms::{PathView, path_from_json, path_to_json};
use overlook_engine::plural::counted;

/// Bytes of a copied view that are read at most: thousands of times what one takes.
const MOST_PASTED: usize = 1 << 20;

impl OverlookApp {
    /// Carries out what concerns the live view's camera; gives back what does not.
    pub(crate) fn apply_to_view(&mut self, command: Command) -> Option<Command> {
        let Command::View(command) = command else { return Some(command) };
        let live = &mut self.state.live;
        match command {
            ViewCommand::Copy => self.copy_view(),
            ViewCommand::CopyAddress => self.copy_address(),
            ViewCommand::GoToAddress(text) => self.go_to_address(&text),
            ViewCommand::Back => self.step_view(true),
            ViewCommand::Forward => self.step_view(false),
            ViewCommand::Paste => self.ctx.send_viewport_cmd(egui::ViewportCommand::RequestPaste),
            ViewCommand::Pasted(text) => self.paste_view(&text),
            ViewCommand::Guides(guides) => live.guides = guides,
            ViewCommand::FlySpeed(speed) => {
                live.fly_speed = speed.clamp(*FLY_SPEEDS.start(), *FLY_SPEEDS.end());
            }
            ViewCommand::Unit(unit) => live.unit = unit,
            ViewCommand::Up(up) => {
                live.up = up;
                let up = self.state.up_in_world();
                if let Some(orbit) = &mut self.state.live.orbit {
                    orbit.set_up(up);
                    orbit.level();
                }
            }
            ViewCommand::CameraOn(camera, true) => {
                live.cameras.off.remove(&camera);
            }
            ViewCommand::CameraOn(camera, false) => {
                live.cameras.off.insert(camera);
            }
            ViewCommand::Solo(camera) => live.cameras.solo = camera,
            ViewCommand::AllCameras(on) => {
                let count = self.state.scene.as_ref().map_or(0, |scene| scene.cameras.len());
                live.cameras.solo = None;
                live.cameras.off = if on { 0..0 } else { 0..count }.collect();
            }
            ViewCommand::Measure(active) => {
                live.ruler.active = active;
                live.ruler.points.clear();
            }
            ViewCommand::PickPoint(point) => live.ruler.pick(point),
            pose => self.pose_view(&pose),
        }
        None
    }

    fn step_view(&mut self, back: bool) {
        let Some(now) = self.state.live.orbit.clone() else { return };
        if let Some(view) = self.state.inspector.views.step(back, now) {
            self.state.live.orbit = Some(view);
        }
    }

    fn pose_view(&mut self, command: &ViewCommand) {
        let Some(orbit) = &mut self.state.live.orbit else { return };
        match *command {
            ViewCommand::AngleOfView(angle) => orbit.set_angle_of_view(angle),
            ViewCommand::Position(position) => orbit.world_from_camera.translation = position,
            ViewCommand::Angles(angles) => orbit.set_angles(angles),
            ViewCommand::LookAlong(direction) => orbit.look_along(direction),
            _ => {}
        }
    }

    /// Copies the pose of the live view as a manifest of one view, which the window pastes and `render --views` takes.
    fn copy_view(&mut self) {
        let (Some(scene), Some(orbit)) = (&self.state.scene, &self.state.live.orbit) else { return };
        let camera = orbit.camera(orbit.lens.width, orbit.lens.height);
        let frame_number = scene.frame_numbers.get(self.state.timeline.frame).copied().unwrap_or_default();
        let view = PathView { camera, frame_number, is_key: true };
        match path_to_json(self.state.up_in_world(), &[view]) {
            Ok(text) => {
                self.ctx.copy_text(text);
                self.state.notify(
                    NoticeKind::Done,
                    "View copied",
                    "Ctrl+V moves the view here again, in any window.",
                );
            }
            Err(error) => self.state.notify(NoticeKind::Error, "View not copied", error.to_string()),
        }
    }

    fn paste_view(&mut self, text: &str) {
        let Some(scene) = self.state.scene.clone() else { return };
        if text.len() <= MOST_PASTED && address::split(text).is_some() {
            return self.go_to_address(text);
        }
        let bytes = text.as_bytes();
        let views = if bytes.len() > MOST_PASTED {
            Err("it is too long for a view".to_owned())
        } else {
            path_from_json(bytes, Path::new("clipboard")).map_err(|error| error.to_string())
        };
        match views.map(|views| views.into_iter().next()) {
            Ok(Some(view)) => {
                let key = key_of(&scene, &view);
                self.go_to_key(key);
            }
            Ok(None) => {}
            Err(why) => {
                let text = format!(
                    "What was copied is no view and no address of one: {why}. Copy one in the View panel (Ctrl+C)."
                );
                self.state.warn_of_scene("Nothing to paste", text);
            }
        }
    }

    /// Takes in the keys of a path that was read: after those that are there.
    pub(crate) fn path_loaded(&mut self, place: &Path, views: &[PathView]) {
        let Some(scene) = self.state.scene.clone() else { return };
        let count = self.take_path_views(&scene, views);
        let text = format!("{} from {}", counted(count, "key"), place.display());
        self.state.notify(NoticeKind::Done, "Camera path opened", text);
    }

    /// Takes the keys among some views after those that are there; gives how many.
    pub(crate) fn take_path_views(&mut self, scene: &OpenScene, views: &[PathView]) -> usize {
        let path = &mut self.state.inspector.path;
        let (is_new, before) = (path.keys.is_empty(), path.keys.clone());
        let keys: Vec<SavedPathKey> =
            views.iter().filter(|view| view.is_key).map(|view| key_of(scene, view)).collect();
        let count = keys.len();
        path.keys.extend(keys);
        path.playing = None;
        if is_new {
            path.take_pace_of(views);
            path.saved = path.keys.clone();
        }
        self.keys_changed(before, None);
        count
    }

    /// Takes in that a path was written.
    pub(crate) fn path_saved(&mut self, place: &Path, saved: CameraPath) {
        self.state.inspector.path.saved = saved.keys;
        self.state.notify(NoticeKind::Done, "Saved", place.display().to_string());
    }
}

/// The key of a view: at the frame of its number, or at the nearest one.
fn key_of(scene: &OpenScene, view: &PathView) -> SavedPathKey {
    let numbers = scene.frame_numbers.iter().enumerate();
    let nearest = numbers.min_by_key(|(_, number)| number.abs_diff(view.frame_number));
    SavedPathKey {
        orbit: OrbitCamera::at_camera(scene, &view.camera),
        frame: nearest.map_or(0, |(index, _)| index),
    }
}
