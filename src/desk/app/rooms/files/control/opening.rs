//! Opens what was asked for, after a question where something is lost by it.

use std::path::Path;

use super::path_names::lasting;
use crate::address;
use crate::app::control::overlook_app::OverlookApp;
use crate::app::model;
use crate::app::rooms::files::model::{Destination, Opening, Purpose};
use crate::app::work::OpenRequest;
use overlook_engine::demo::DemoSpec;

impl OverlookApp {
    /// Opens something, after a question where a camera path or measured points are lost by it.
    pub(crate) fn ask_to_open(&mut self, opening: Opening) {
        match opening {
            _ if self.state.unsaved_work().is_none() => self.open(opening),
            // First whether there is anything: nobody should give up work for a path that does not exist.
            Opening::Path(path) => {
                let path = lasting(path);
                self.workers.check.submit(Destination { purpose: Purpose::OpenFile, path });
            }
            opening => self.state.open_after_question = Some(opening),
        }
    }

    pub(crate) fn open(&mut self, opening: Opening) {
        match opening {
            Opening::Demo(scene) => {
                self.open_demo(DemoSpec::new(scene));
            }
            Opening::Room => self.open_room(),
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
            return;
        }
        if let Some(opening) = opens {
            self.open(opening);
        }
    }

    /// Opens a built-in scene.
    pub(crate) fn open_demo(&mut self, spec: DemoSpec) {
        self.state.opening = Some(model::words(&spec.scene));
        self.workers.open.submit(OpenRequest::Demo { spec, settings: self.state.settings.capture.clone() });
    }

    /// Opens the room that comes with the program.
    pub(crate) fn open_room(&mut self) {
        self.state.opening = Some("room".to_owned());
        self.workers.open.submit(OpenRequest::Room);
    }

    /// Opens a capture or a store, at the view that an address names.
    pub(crate) fn open_path(&mut self, path: &Path) {
        let (path, view) = address::of_path(path);
        let path = lasting(path);
        self.address_to_open = view.map(|view| (path.clone(), view));
        self.open_with_keys(path, Vec::new());
    }
}
