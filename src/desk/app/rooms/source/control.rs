//! Carries out what concerns the source view.

use super::model::SourceCommand;
use crate::app::control::overlook_app::OverlookApp;

impl OverlookApp {
    /// Carries out what concerns the source view.
    pub(crate) fn apply_to_source(&mut self, command: SourceCommand) {
        let state = &mut self.state;
        match command {
            SourceCommand::Camera(camera) => {
                if state.doc.scene.as_ref().is_some_and(|scene| camera < scene.cameras.len()) {
                    state.source.camera = camera;
                    state.source.against = state.source.against.filter(|&against| against != camera);
                }
            }
            SourceCommand::Overlay(overlay) => state.source.overlay = overlay,
            SourceCommand::Against(against) => state.source.against = against,
            SourceCommand::Zoom(part) => state.source.part = part,
            SourceCommand::Isolate(camera) => state.doc.isolated = camera,
        }
    }
}
