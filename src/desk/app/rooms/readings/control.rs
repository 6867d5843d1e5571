//! Carries out what concerns the readings of a capture: comparing them, and opening it under the other one.

use std::path::PathBuf;
use std::sync::Arc;

use egui::TextureOptions;

use crate::app::control::OverlookApp;
use crate::app::model::command::ReadingCommand;
use crate::app::model::window::NoticeKind;
use crate::app::model::{self, Command, SceneSource};
use crate::app::rooms::readings::state::{ReadingImages, ReadingPictures};
use crate::app::work::OpenRequest;
use overlook_engine::capture::conventions::Finding;

impl OverlookApp {
    pub(crate) fn apply_to_readings(&mut self, command: ReadingCommand) {
        match command {
            ReadingCommand::Compare(open) => {
                let is_possible = self.state.why_no_readings().is_none();
                self.state.doc.readings.is_open = open && is_possible;
            }
            ReadingCommand::CopyKeys => {
                self.ctx.copy_text(self.state.doc.readings.keys());
                let text = "Paste them into the manifest, before \"frames\".";
                self.state.notify(NoticeKind::Done, "Keys copied", text);
            }
        }
    }

    /// Opens the scene again, under the other reading or under the one of its files.
    pub(crate) fn open_reading(&mut self, otherwise: bool) {
        let Some(scene) = &self.state.doc.scene else { return };
        let SceneSource::Path(path) = &scene.origin else { return };
        let readings = &mut self.state.doc.readings;
        let keys = match readings.alternative() {
            Some(other) if otherwise => other.keys.clone(),
            _ => Vec::new(),
        };
        readings.is_open = false;
        self.open_with_keys(path.clone(), keys);
    }

    /// Opens a capture under the reading that `keys` of a manifest express; without keys under the one of its files.
    pub(crate) fn open_with_keys(&mut self, path: PathBuf, keys: Vec<(String, String)>) {
        self.state.opening = Some(path.display().to_string());
        let settings = self.state.settings.capture.clone();
        self.workers.open.submit(OpenRequest::Path { path, settings, keys });
    }

    /// Takes in the finding about the agreement between views. It changes no reading.
    pub(crate) fn readings_checked(&mut self, finding: Result<Arc<Finding>, String>) {
        let readings = &mut self.state.doc.readings;
        // A capture opened under the other reading keeps the keys of its files.
        let is_reread = self.state.doc.scene.as_ref().is_some_and(|scene| scene.is_reread);
        if readings.alternative().is_some() || is_reread {
            return;
        }
        match finding {
            Ok(finding) => readings.finding = Some(finding),
            Err(trouble) => readings.trouble = Some(trouble),
        }
        let warning = readings.finding.as_ref().and_then(|finding| finding.warning());
        let Some(warning) = warning else { return };
        let told = format!("{warning}. Nothing was changed");
        let title = "Check the capture: another reading fits better";
        let link = ("Compare readings…", Command::Reading(ReadingCommand::Compare(true)));
        self.state.notify_with_link(NoticeKind::Warning, title, model::sentence(&told), link);
    }

    /// Takes in the pictures of both readings.
    pub(crate) fn readings_shown(&mut self, images: Result<ReadingImages, String>) {
        let readings = &mut self.state.doc.readings;
        match images {
            Ok(ReadingImages { camera, pictures, votes }) => {
                let texture = |image| self.ctx.load_texture("reading", image, TextureOptions::LINEAR);
                readings.shown = Some(ReadingPictures { camera, pictures: pictures.map(texture), votes });
            }
            Err(trouble) => readings.trouble = Some(trouble),
        }
    }
}
