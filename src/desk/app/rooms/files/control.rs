//! Opens what was asked for, and takes in what was opened and saved.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::address::{self, ViewAddress};
use crate::app::control::OverlookApp;
use crate::app::model::camera::OrbitCamera;
use crate::app::model::command::{FileCommand, Opening, ViewCommand, WindowCommand};
use crate::app::model::look::Display;
use crate::app::model::picture::{ColorBy, Overlay};
use crate::app::model::purpose::Purpose;
use crate::app::model::setting_names::SettingPairs;
use crate::app::model::window::{DockView, NoticeKind, Workspace};
use crate::app::model::{self, Command, Document, OpenScene, SceneSource};
use crate::app::rooms::compare::state::CompareVantage;
use crate::app::rooms::files::paths::lasting;
use crate::app::rooms::files::remembered::remember_recent;
use crate::app::rooms::files::state::Session;
use crate::app::rooms::source::SourceLook;
use crate::app::work::OpenRequest;
use crate::app::work::worker::AnySlot;
use overlook_engine::capture::Camera;
use overlook_engine::demo::DemoSpec;
use overlook_engine::plural::{counted, either};
use overlook_engine::settings::Settings;

impl OverlookApp {
    /// Opens something, after a question where a camera path or measured points are lost by it.
    pub(crate) fn ask_to_open(&mut self, opening: Opening) {
        match opening {
            _ if self.state.unsaved_work().is_none() => self.open(opening),
            // First whether there is anything: nobody should give up work for a path that does not exist.
            Opening::Path(path) => {
                self.workers.check.submit((Purpose::OpenFile, lasting(path)));
            }
            opening => self.state.open_after_question = Some(opening),
        }
    }

    pub(crate) fn open(&mut self, opening: Opening) {
        match opening {
            Opening::Demo(scene) => self.open_demo(DemoSpec::new(scene)),
            Opening::Room => {
                self.state.opening = Some("room".to_owned());
                self.workers.open.submit(OpenRequest::Room);
            }
            Opening::Path(path) => self.open_path(&path),
            Opening::Reading(otherwise) => self.open_reading(otherwise),
        }
    }

    /// Closes, or opens something else, without another question.
    pub(crate) fn go_on_anyway(&mut self) {
        let opens = self.state.open_after_question.take();
        if self.state.inspector.closing.asks {
            self.state.inspector.closing.anyway = true;
            self.ctx.send_viewport_cmd(egui::ViewportCommand::Close);
        } else if let Some(opening) = opens {
            self.open(opening);
        }
    }

    pub(crate) fn open_demo(&mut self, spec: DemoSpec) {
        self.state.opening = Some(model::words(&spec.scene));
        self.workers.open.submit(OpenRequest::Demo { spec, settings: self.state.settings.capture.clone() });
    }

    /// Opens a capture or a store, at the view that an address names.
    pub(crate) fn open_path(&mut self, path: &Path) {
        let (path, view) = address::of_path(path);
        let path = lasting(path);
        self.address_to_open = view.map(|view| (path.clone(), view));
        self.open_with_keys(path, Vec::new());
    }
}

impl OverlookApp {
    pub(crate) fn opened(&mut self, scene: &Arc<OpenScene>, session: Option<&Session>) {
        self.state.remember_picture(&self.ctx);
        self.forget_closed_scene(scene);
        self.look_at_first(scene);
        self.show_views_of_scene();
        self.notify_of_opened(scene, session.is_some());
        // Work for the closed scene stops, except for files that are being written.
        self.workers.slots().into_iter().for_each(AnySlot::stop);
        self.workers.study.cancel();
        if let Some(session) = session {
            self.take_session(session, scene);
        }
        if let Some((path, view)) = self.address_to_open.take()
            && scene.origin == SceneSource::Path(path)
        {
            self.go_to_view(scene, &view);
        }
        let plays_once_open = std::mem::take(&mut self.state.timeline.plays_once_open);
        self.state.timeline.playing |= plays_once_open && scene.frame_count() > 1;
    }

    /// What a person's own data is looked at in first: not the comparison or the charts of the scene before, and upright pictures whole.
    fn look_at_first(&mut self, scene: &OpenScene) {
        if !matches!(scene.origin, SceneSource::Path(_)) {
            return;
        }
        if matches!(self.state.look.workspace, Workspace::Compare | Workspace::Measure) {
            self.apply(Command::Window(WindowCommand::Workspace(Workspace::Explore)));
        }
        let is_upright =
            scene.cameras.first().is_some_and(|camera| camera.intrinsics.height > camera.intrinsics.width);
        self.state.live.guides.locks_aspect |= is_upright;
    }

    /// Puts back to its start what belonged to the scene before `scene`.
    fn forget_closed_scene(&mut self, scene: &Arc<OpenScene>) {
        let state = &mut self.state;
        if let SceneSource::Path(path) = &scene.origin {
            remember_recent(&mut state.recent, path);
        }
        if self.workers.open.is_idle() {
            state.opening = None;
        }
        let readings = scene.is_reread.then(|| std::mem::take(&mut state.doc.readings));
        let charts = std::mem::take(&mut state.doc.charts).at_scene();
        state.doc = Document { charts, ..Document::of(scene.clone(), &state.settings) };
        state.doc.readings = readings.unwrap_or_default();
        state.inspector.history.forget_scene();
        state.close_pictures(|_| true);
        state.inspector.compare.choice.from = CompareVantage::Live;
        state.share.close_scene();
        state.timeline = state.timeline.at_start();
        state.live = state.live.at_scene(scene);
        state.take_chosen_up(scene);
        state.source = SourceLook { overlay: state.source.overlay, ..SourceLook::default() };
        state.display = Display::default();
        if state.overlays().all(|(overlay, ..)| overlay != state.source.overlay) {
            state.source.overlay = Overlay::default();
        }
        if state.live_colors().all(|(color_by, ..)| color_by != state.live.color_by) {
            state.live.color_by = ColorBy::Picture;
        }
        state.notices.retain(|notice| notice.kind != NoticeKind::Error && notice.scene.is_none());
    }

    /// Reports warnings about a scene that was opened, and settings that differ from the defaults.
    fn notify_of_opened(&mut self, scene: &OpenScene, by_session: bool) {
        let state = &mut self.state;
        for warning in scene.capture().iter().flat_map(|capture| &capture.warnings) {
            state.warn_of_scene("While opening", warning.clone());
        }
        if let Some(playback) = scene.playback() {
            for warning in &playback.store().info().warnings {
                state.warn_of_scene("While opening", warning.clone());
            }
            state.report_damage(&playback.store().damage());
        }
        let changed = SettingPairs::new(&state.settings, &Settings::default()).differing().count();
        if changed > 0 && scene.capture().is_some() {
            let text = format!(
                "{} {} from the defaults, as set before; Reset all in the Settings view takes the defaults.",
                counted(changed, "setting"),
                either(changed, "differs", "differ")
            );
            let link = ("Show in Settings", Command::Window(WindowCommand::OpenView(DockView::Thresholds)));
            state.notify_with_link(NoticeKind::Done, "Settings were kept", text, link);
        }
        state.inspector.log(NoticeKind::Done, format!("Opened {}", scene.name));
        if !by_session {
            self.ask_for_up(scene);
        }
    }

    /// Asks once of a capture whose up was taken from the cameras whether it is right.
    fn ask_for_up(&mut self, scene: &OpenScene) {
        let SceneSource::Path(path) = &scene.origin else { return };
        let is_known = self.state.chosen_ups.iter().any(|(known, _)| known == path);
        if scene.up_is_estimated && !is_known {
            self.state.chosen_ups.push((path.clone(), None));
            let text = "The files do not say which way is up; it was taken from the cameras.";
            let link = ("Set which way is up", Command::View(ViewCommand::FindUp));
            let title = "Does it lie on its side?";
            self.state.notify_with_link(NoticeKind::Done, title, text.to_owned(), link);
        }
    }

    pub(crate) fn saved(&mut self, path: &Path, bytes: Option<u64>, holds: Option<(u64, Settings)>) {
        // Thresholds may have been changed while it was written, and another capture opened.
        let scene = self.state.doc.scene.as_ref().map(|scene| scene.id);
        if let Some((_, settings)) = holds.filter(|(of, _)| Some(*of) == scene) {
            self.state.doc.saved = Some(settings);
        }
        if bytes.is_some() {
            remember_recent(&mut self.state.recent, path);
        }
        let place = path.display();
        let (said, text) = match bytes.map(model::bytes) {
            Some(size) => (format!("a store of {size}"), format!("{place} ({size})")),
            None => ("saved".to_owned(), place.to_string()),
        };
        self.written("Saved", path, &said, text);
    }
}

impl OverlookApp {
    /// Copies the address of the view. The view becomes the one that the address says, a trillionth from where it was: whoever opens it
    /// sees the same to the last bit.
    pub(crate) fn copy_address(&mut self) {
        let (Some(scene), Some(view)) = (self.state.doc.scene.clone(), self.view_address()) else { return };
        let place = self.state.opened_path().map_or_else(String::new, |path| path.display().to_string());
        self.ctx.copy_text(format!("{place}{view}"));
        self.go_to_view(&scene, &view);
        let text = "Paste it into a window of Overlook (Ctrl+V), give it to overlook open, or append what follows the # to a page.";
        self.state.notify(NoticeKind::Done, "Address copied", text);
    }

    /// The address of the view, without the scene's; `None` while nothing is shown.
    pub(crate) fn view_address(&self) -> Option<ViewAddress> {
        let state = &self.state;
        state.address_of(state.live.orbit.as_ref()?, state.timeline.frame)
    }

    /// Goes to the view of an address. A scene that is not open is opened first; a page and an address without a scene mean what is open.
    pub(crate) fn go_to_address(&mut self, text: &str) {
        let Some((place, view)) = address::split(text) else {
            let text = "An address ends like #view=…&frame=…; a page and this window copy them.";
            return self.state.warn_of_scene("No address", text);
        };
        let path = lasting(PathBuf::from(&place));
        let names_scene = !place.is_empty() && !address::is_page(&place);
        match self.state.doc.scene.clone() {
            Some(scene) if !names_scene || scene.origin == SceneSource::Path(path) => {
                self.go_to_view(&scene, &view);
            }
            _ if names_scene => {
                self.apply(Command::File(FileCommand::Open(Opening::Path(format!("{place}{view}").into()))));
            }
            _ => {}
        }
    }

    pub(crate) fn go_to_view(&mut self, scene: &OpenScene, view: &ViewAddress) {
        if let Some(orbit) = orbit_of(scene, view) {
            self.state.live.orbit = Some(orbit);
        }
        if let Some(number) = view.frame_number {
            let frame = scene.frame_numbers.partition_point(|known| *known < number);
            self.state.timeline.go_to(frame, scene.frame_count());
            self.state.timeline.playing = false;
        }
        let up = self.state.up_in_world();
        if let Some(orbit) = &mut self.state.live.orbit {
            orbit.up_in_world = up;
        }
    }
}

/// The view that an address says; `None` where it says none, or names a camera that is not there.
fn orbit_of(scene: &OpenScene, view: &ViewAddress) -> Option<OrbitCamera> {
    let first = scene.cameras.first()?;
    let named =
        view.camera.as_ref().and_then(|name| scene.cameras.iter().find(|camera| camera.name == *name));
    let Some((world_from_camera, pivot_distance)) = view.pose() else {
        return named.map(|camera| OrbitCamera::at_camera(scene, camera));
    };
    let lens = view.lens.unwrap_or(first.intrinsics);
    let camera = Camera { name: "address".to_owned(), intrinsics: lens, world_from_camera };
    let mut orbit = OrbitCamera::at_camera(scene, &camera);
    orbit.pivot_distance = pivot_distance;
    Some(orbit)
}
