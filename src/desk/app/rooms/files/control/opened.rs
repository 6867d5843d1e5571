//! Takes in what was opened and saved.

use std::path::Path;
use std::sync::Arc;

use super::remembered::remember_recent;
use crate::app::control::overlook_app::OverlookApp;
use crate::app::model;
use crate::app::model::{Document, OpenScene, SceneSource};
use crate::app::rooms::colors::model::Display;
use crate::app::rooms::compare::model::CompareVantage;
use crate::app::rooms::frame::model::{DockView, NoticeKind, NoticeLink};
use crate::app::rooms::live::model::ColorBy;
use crate::app::rooms::settings::model::SettingPairs;
use crate::app::rooms::source::model::{Overlay, SourceLook};
use crate::app::work::slot::AnySlot;
use overlook_engine::plural::{counted, either};
use overlook_engine::settings::Settings;

impl OverlookApp {
    pub(crate) fn opened(&mut self, scene: &Arc<OpenScene>) {
        self.state.remember_picture();
        self.forget_closed_scene(scene);
        self.show_views_of_scene();
        self.notify_of_opened(scene);
        // Work for the closed scene stops, except for files that are being written.
        self.workers.slots().into_iter().for_each(AnySlot::stop);
        self.workers.study.cancel();
        if let Some(session) = &scene.session {
            self.take_session(session, scene);
        }
        self.go_to_opened_address(scene);
        let plays_once_open = std::mem::take(&mut self.state.timeline.plays_once_open);
        self.state.timeline.playing |= plays_once_open && scene.frame_count() > 1;
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
    fn notify_of_opened(&mut self, scene: &OpenScene) {
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
            state.notify_with_link("Settings were kept", text, NoticeLink::View(DockView::Thresholds));
        }
        state.inspector.log(NoticeKind::Done, format!("Opened {}", scene.name));
        self.ask_for_up(scene);
    }

    /// Asks once of a capture whose up was taken from the cameras whether it is right.
    fn ask_for_up(&mut self, scene: &OpenScene) {
        let SceneSource::Path(path) = &scene.origin else { return };
        let is_known = self.state.chosen_ups.iter().any(|(known, _)| known == path);
        if scene.up_is_estimated && !is_known && scene.session.is_none() {
            self.state.chosen_ups.push((path.clone(), None));
            let text = "The files do not say which way is up; it was taken from the cameras.";
            self.state.notify_with_link("Does it lie on its side?", text, NoticeLink::Up);
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
