//! Carries out the commands of the inspector: the pixel, settings as they were, the camera path.

use crate::app::control::overlook_app::OverlookApp;
use crate::app::model::{Command, HelpPage};
use crate::app::rooms::frame::model::DockView;
use crate::app::rooms::frame::model::NoticeKind;
use crate::app::rooms::path::model::SavedPathKey;
use crate::app::rooms::pixel::model::{Spot, verdict_text};
use crate::app::rooms::report::model::{Table, TableForm, table_text};
use crate::app::rooms::settings::model::setting_names;
use crate::app::rooms::source::model::PictureZoom;
use overlook_engine::settings::Settings;

/// Changes of settings that a message lists one by one.
const CHANGES: usize = 5;

impl OverlookApp {
    /// Carries out what belongs to the inspector; gives back what does not.
    pub(crate) fn apply_to_inspector(&mut self, command: Command) -> Option<Command> {
        let state = &mut self.state;
        match command {
            Command::Probe(spot) => state.inspector.probe.spot = spot,
            Command::Pin(pinned) => self.pin(pinned),
            Command::ShowPointIn(camera) => self.show_point_in(camera),
            Command::LogFrameTimes => {
                if let Some(times) = std::mem::take(&mut state.inspector.meter).summary() {
                    log::info!("frame times, {times}");
                }
            }
            Command::Compare(look) => {
                let before = &state.inspector.compare.choice;
                if (look.choice.sides, look.choice.from) != (before.sides, before.from) {
                    state.inspector.compare_error = None;
                }
                state.inspector.compare = *look;
            }
            Command::ClosePictures(id) => state.inspector.close_pictures(|folder| folder.id == id),
            Command::Palette(palette) => state.inspector.palette = palette,
            Command::Isolate(camera) => state.inspector.isolated = camera,
            Command::CopyTable(table, form) => self.copy_table(table, form),
            Command::Help(page) => {
                state.inspector.help = page;
                if page == Some(HelpPage::About) {
                    state.inspector.held_memory = state.held_memory();
                    let window = self.window.as_ref();
                    let memory = window.and_then(|window| window.device.generate_allocator_report());
                    state.inspector.graphics_memory = memory.map(|memory| memory.total_allocated_bytes);
                }
            }
            Command::FoundSetting => state.inspector.find_setting = None,
            Command::FindSetting(path) => {
                state.inspector.find_setting = Some(path);
                self.dock.open(DockView::Thresholds);
            }
            Command::Introduced => state.inspector.introduced = true,
            Command::RoomExplained => state.inspector.room_explained = true,
            Command::Stay => {
                state.inspector.closing.asks = false;
                state.open_after_question = None;
            }
            Command::GoOnAnyway => self.go_on_anyway(),
            Command::Study(study) => self.study(study),
            Command::Chart(command) => self.apply_to_charts(command),
            Command::ChartAxes(axes) => state.inspector.charts.set_axes(axes),
            Command::Disturbance(name) => state.inspector.charts.disturbance = name,
            Command::TakeSettings(settings) => self.take_point(*settings),
            Command::CopyExplanation => self.copy_explanation(),
            Command::CopyPicture => self.copy_picture(),
            Command::FramePoint => self.frame_point(),
            other => return Some(other),
        }
        None
    }

    /// Keeps the selected pixel, or lets it go.
    fn pin(&mut self, pinned: bool) {
        let probe = &mut self.state.inspector.probe;
        probe.pinned = pinned && probe.spot.is_some();
        // Pinning stops playback: the pixel is one of this frame, and its verdict takes longer than a frame.
        self.state.timeline.playing &= !probe.pinned;
        if !pinned {
            (probe.spot, probe.shown) = (None, None);
        } else if let Some(probed) = probe.shown.as_ref().filter(|probed| Some(probed.spot) == probe.spot) {
            // The surface point is kept: a pixel of the live picture shows another point once the view turns.
            let (camera, x, y) = (probed.camera, probed.x, probed.y);
            probe.spot = Some(Spot::Source { camera, x, y });
        } else {
            // The pixel may have been found to be a hole before it was pinned.
            self.scheduler.probe = None;
        }
    }

    /// Shows the selected point in the middle of a camera's picture.
    fn show_point_in(&mut self, camera: usize) {
        let Some(scene) = &self.state.scene else { return };
        let Some(intrinsics) = scene.cameras.get(camera).map(|camera| camera.intrinsics) else { return };
        let probed = self.state.inspector.probe.shown.clone();
        self.apply(Command::SourceCamera(camera));
        let probe = &mut self.state.inspector.probe;
        if let Some(probed) = &probed {
            probe.pinned = true;
            probe.spot = Some(Spot::Source { camera: probed.camera, x: probed.x, y: probed.y });
        }
        let cameras = self.state.scene.as_ref().map_or(&[][..], |scene| &scene.cameras);
        let place = probed.and_then(|probed| probed.in_camera(cameras, camera));
        if let Some((at, _)) = place {
            let center = egui::vec2(at.x / intrinsics.width as f32, at.y / intrinsics.height as f32);
            self.state.source.part = PictureZoom::new(self.state.source.part.zoom.max(4.0), center);
        }
    }

    /// Applies the settings of a chart's point, and lists what changes.
    fn take_point(&mut self, settings: Settings) {
        let changes = setting_names::changes(&self.state.settings, &settings);
        if changes.is_empty() {
            self.state.notify(NoticeKind::Done, "Already applied", "These are the current settings.");
            return;
        }
        let (told, others) = changes.split_at(changes.len().min(CHANGES));
        let more = if others.is_empty() { String::new() } else { format!("; and {} more", others.len()) };
        let text = format!("{}{more} (Ctrl+Z undoes)", told.join("; "));
        self.change_settings(settings);
        self.state.notify(NoticeKind::Done, "Settings applied", text);
    }

    fn copy_explanation(&mut self) {
        let shown = self.state.scene.as_ref().zip(self.state.inspector.probe.shown.as_ref());
        let Some((scene, probed)) = shown else { return };
        self.ctx.copy_text(verdict_text::explanation(scene, probed));
        self.state.notify(NoticeKind::Done, "Copied", "The explanation of the pixel is on the clipboard.");
    }

    fn copy_table(&mut self, table: Table, form: TableForm) {
        let Some(text) = table_text(table, form, &self.state) else {
            let text = format!("There is no {} yet.", table.name());
            return self.state.warn_of_scene("Nothing to copy", text);
        };
        self.ctx.copy_text(text);
        let text = format!("The {} is on the clipboard as {}.", table.name(), form.name());
        self.state.notify(NoticeKind::Done, "Copied", text);
    }

    fn copy_picture(&mut self) {
        if self.state.live_shown.is_none() {
            return;
        }
        let Some(image) = self.state.shown_picture() else { return self.notify_in_motion() };
        self.ctx.copy_image(image.as_ref().clone());
        self.state.notify(NoticeKind::Done, "Copied", "The picture of the live view is on the clipboard.");
    }

    /// Pictures in motion may stay on the graphics card, out of reach.
    pub(crate) fn notify_in_motion(&mut self) {
        let text = "The live view is playing; pause it first, and try again.";
        self.state.warn_of_scene("No picture yet", text);
    }

    /// Centers the live view on the selected point.
    fn frame_point(&mut self) {
        let probed = self.state.inspector.probe.shown.clone();
        let point = probed.as_ref().and_then(|probed| probed.point_in_world);
        if let (Some(point), Some(orbit)) = (point, &mut self.state.live.orbit) {
            orbit.look_at(point);
            return;
        }
        let (title, text) = match probed {
            Some(_) => ("No point here", "This pixel is infinitely far away; point at another one."),
            None => ("Point at a pixel first", "F then centers the live view on it."),
        };
        self.state.warn_of_scene(title, text);
    }

    fn add_key(&mut self, key: SavedPathKey) {
        let keys = &mut self.state.inspector.path.keys;
        keys.push(key);
        let added = format!("Key {} added", keys.len());
        if !self.visible_views().contains(&DockView::Path) {
            self.state.notify(NoticeKind::Done, added, "The Camera path view plays and exports the path.");
        }
    }

    pub(crate) fn apply_to_path(&mut self, command: Command) -> Option<Command> {
        let path = &mut self.state.inspector.path;
        match command {
            Command::AddKey
            | Command::RemoveKey(_)
            | Command::ReplaceKey(_)
            | Command::MoveKey { .. }
            | Command::ClearPath => self.change_keys(&command),
            Command::GoToKey(index) => {
                if let Some(key) = path.keys.get(index).cloned() {
                    self.go_to_key(key);
                }
            }
            Command::PicturesPerLeg(pictures) => path.pictures_per_leg = pictures.clamp(1, 2000),
            Command::PictureSize(size) => path.size = Some(size),
            Command::PlayPath(play) => path.playing = (play && path.pictures() > 0).then_some(0.0),
            other => return Some(other),
        }
        None
    }

    /// Carries out a command that changes the keys of the path.
    fn change_keys(&mut self, command: &Command) {
        let frame = self.state.timeline.frame;
        let here = self.state.live.orbit.clone().map(|orbit| SavedPathKey { orbit, frame });
        let path = &mut self.state.inspector.path;
        let before = path.keys.clone();
        let mut moved = None;
        match *command {
            Command::AddKey => {
                if let Some(key) = here {
                    self.add_key(key);
                }
            }
            Command::RemoveKey(index) if index < path.keys.len() => {
                path.keys.remove(index);
                path.playing = None;
            }
            Command::ReplaceKey(index) => {
                if let (Some(key), Some(here)) = (path.keys.get_mut(index), here) {
                    *key = here;
                }
            }
            Command::MoveKey { index, frame } => {
                path.move_key(index, frame);
                moved = Some(index);
            }
            Command::ClearPath => {
                path.keys.clear();
                path.playing = None;
            }
            _ => {}
        }
        self.keys_changed(before, moved);
    }

    /// Notes what the keys of the path were, so that the change can be taken back.
    pub(crate) fn keys_changed(&mut self, before: Vec<SavedPathKey>, moved: Option<usize>) {
        let path = &mut self.state.inspector.path;
        let changes = path.keys != before;
        path.note_change(before, moved);
        self.state.edits.is_latest &= !changes;
    }

    /// Moves the view to a key of the path.
    pub(crate) fn go_to_key(&mut self, key: SavedPathKey) {
        self.state.live.orbit = Some(key.orbit);
        self.state.timeline.frame = key.frame.min(self.state.frame_count().saturating_sub(1));
    }
}
