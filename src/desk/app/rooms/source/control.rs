//! Carries out what concerns the source view.

use std::sync::Arc;

use crate::app::control::OverlookApp;
use crate::app::model::command::SourceCommand;
use crate::app::model::picture::{SourceKey, SourcePicture};
use crate::app::model::window::DockView;
use crate::app::model::{ShownPicture, Texture};
use crate::app::rooms::source::SourceLook;

impl OverlookApp {
    /// Carries out what concerns the source view.
    pub(crate) fn apply_to_source(&mut self, command: SourceCommand) {
        let state = &mut self.state;
        match command {
            SourceCommand::Camera(camera) => {
                if state.doc.scene.as_ref().is_some_and(|scene| camera < scene.cameras.len()) {
                    state.source.camera = camera;
                    state.source.chosen_at = Some(self.ctx.cumulative_frame_nr());
                    state.source.against = state.source.against.filter(|&against| against != camera);
                    self.show_in_list();
                }
            }
            SourceCommand::Look(look) => {
                let SourceLook { camera, chosen_at, .. } = state.source;
                state.source = SourceLook { camera, chosen_at, ..look };
            }
            SourceCommand::Isolate(camera) => state.doc.isolated = camera,
        }
    }

    /// Takes in a picture of the source view.
    pub(crate) fn source_painted(&mut self, key: SourceKey, picture: Arc<SourcePicture>) {
        let shown = &mut self.state.doc.source_shown;
        let replaced = shown.take().map(|shown| shown.texture);
        // The source view shows single pixels sharply; the live view is interpolated.
        let texture = Texture::send(&self.ctx, "source", Texture::PIXELS, &picture.image, replaced);
        *shown = Some(ShownPicture { key, picture, texture });
    }

    /// Where no view shows the picture of the camera that was chosen, brings the panel with the list of cameras to the front. What
    /// somebody hid, or left by maximizing a view, stays away.
    fn show_in_list(&mut self) {
        let look = &self.state.look;
        let visible = self.visible_views();
        let is_seen = [DockView::Source, DockView::Cameras].iter().any(|view| visible.contains(view));
        let is_shown = self.dock.area_of(DockView::View).is_none_or(|area| look.shows(area));
        if !is_seen && is_shown && look.maximized.is_none() && self.dock.holds(DockView::View) {
            self.dock.open(DockView::View);
        }
    }
}
