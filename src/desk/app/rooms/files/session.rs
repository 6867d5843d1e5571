//! Sessions: writing what is open and set, and taking it in again.

use std::path::Path;
use std::sync::Arc;

use crate::address::ViewAddress;
use crate::app::control::OverlookApp;
use crate::app::dock::Dock;
use crate::app::model::command::FileCommand;
use crate::app::model::purpose::Purpose;
use crate::app::model::window::NoticeKind;
use crate::app::model::{Command, Message, OpenScene};
use crate::app::rooms::files::state::{Session, SessionLook};
use crate::app::rooms::path::{CameraPath, SavedPathKey};
use overlook_engine::edits::EditList;
use overlook_engine::whole_file;

impl OverlookApp {
    pub(crate) fn save_session(&mut self, place: &Path) {
        let Some(session) = self.session() else { return };
        let (keys, list) = (self.state.doc.path.keys.clone(), self.state.doc.edits.list.clone());
        self.save(place.to_path_buf(), move |path, _| {
            whole_file::write_all(path, session.to_text(path)?)?;
            Ok(Message::SessionSaved { path: path.to_path_buf(), keys, list })
        });
    }

    /// Takes in that a session was written: what is in it is saved, and the next one goes there without a question.
    pub(crate) fn session_saved(&mut self, place: &Path, keys: Vec<SavedPathKey>, list: EditList) {
        let doc = &mut self.state.doc;
        (doc.path.saved, doc.edits.saved) = (keys, list);
        doc.session_place = Some(place.to_path_buf());
        self.state.notify(NoticeKind::Done, "Session saved", place.display().to_string());
    }

    /// Saves the session where it was saved last, or asks where.
    pub(crate) fn save_session_again(&mut self) {
        match self.state.doc.session_place.clone() {
            Some(place) => self.save_session(&place),
            None => self.apply(Command::File(FileCommand::AskPath(Purpose::SaveSession))),
        }
    }

    /// Copies the command that prunes the same without a window.
    pub(crate) fn copy_command_line(&mut self) {
        if self.refuses(Purpose::SaveSession) {
            return;
        }
        if !self.state.has_capture() {
            let text = "A store is pruned already; open the capture that it was made from.";
            return self.state.warn_of_scene("No command to copy", text);
        }
        let Some(session) = self.session() else { return };
        self.ctx.copy_text(session.command_line());
        let text = if session.has_edits() {
            "Save the edits as edits.toml first (Save > Save edits…), where the command is run."
        } else {
            "Paste it into a terminal: it prunes the same into a store."
        };
        self.state.notify(NoticeKind::Done, "Command copied", text);
    }

    /// The session of a scene that has a path.
    fn session(&self) -> Option<Session> {
        let state = &self.state;
        let (scene, opens) = (state.doc.scene.as_ref()?, state.opened_path()?);
        let path = &state.doc.path;
        let path = if path.pictures() > 0 {
            // Keys as they are: what the camera looks at instead is said beside them.
            CameraPath { looks_at: None, ..path.clone() }.views(state.export_size(), &scene.frame_numbers)
        } else {
            Vec::new()
        };
        Some(Session {
            opens: opens.clone(),
            settings: state.settings.clone(),
            edits: state.doc.edits.list.clone(),
            path,
            path_easing: state.doc.path.easing,
            path_looks_at: state.doc.path.looks_at,
            up_in_world: state.up_in_world(),
            view: self.view_address()?.to_string(),
            layout: self.dock.to_json(),
            look: Some(SessionLook::of(state, scene)),
            kept_views: state.doc.kept_views.clone(),
        })
    }

    /// Takes in what a session says of the scene that it opened.
    pub(crate) fn take_session(&mut self, session: &Session, scene: &Arc<OpenScene>) {
        if session.settings != self.state.settings {
            self.change_settings(session.settings.clone());
        }
        self.dock = Dock::from_json(&session.layout);
        self.state.look.workspace = self.dock.workspace();
        self.show_areas_that_fit();
        if let Some(look) = &session.look {
            look.put(&mut self.state, scene);
        }
        let up = session.up_in_world;
        self.state.live.up = (up != scene.up_in_world).then_some(up);
        self.state.doc.path = CameraPath::default();
        self.take_path_views(scene, &session.path, session.path_easing);
        self.state.doc.path.looks_at = session.path_looks_at;
        self.state.doc.kept_views.clone_from(&session.kept_views);
        self.state.take_edits(session.edits.clone());
        if let Ok(view) = session.view.parse::<ViewAddress>() {
            self.go_to_view(scene, &view);
        }
    }
}
