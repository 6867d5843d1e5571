//! Keeps views, and goes back to them.

use egui::TextureOptions;

use crate::app::control::overlook_app::OverlookApp;
use crate::app::rooms::files::model::smaller;
use crate::app::rooms::live::model::{KeptView, KeptViewCommand, next_name};

impl OverlookApp {
    /// Carries out what concerns views that are kept.
    pub(super) fn apply_to_kept_views(&mut self, command: KeptViewCommand) {
        let kept = &mut self.state.doc.kept_views;
        match command {
            KeptViewCommand::Keep => {
                let name = next_name(kept);
                let Some(view) = self.view_address() else { return };
                self.state.doc.kept_views.push(KeptView { name, view });
                self.picture_view();
            }
            KeptViewCommand::GoTo(index) => {
                let Some((scene, kept)) = self.state.doc.scene.clone().zip(kept.get(index)) else { return };
                let view = kept.view.clone();
                self.go_to_view(&scene, &view);
            }
            KeptViewCommand::Rename(index, name) => {
                if let Some(kept) = kept.get_mut(index) {
                    kept.name = name;
                }
            }
            KeptViewCommand::Remove(index) => {
                if index < kept.len() {
                    kept.remove(index);
                }
            }
        }
    }

    /// Gives the view that is shown a small picture, where it is one that has one.
    pub(crate) fn picture_view(&mut self) {
        let state = &self.state;
        let (Some(shown), None) = (&state.doc.live_shown, &state.doc.live_carried) else { return };
        let here = &shown.key.vantage;
        if here.frame != state.timeline.frame || !state.looks_from(&here.camera) {
            return;
        }
        let Some((view, picture)) = self.view_address().zip(state.shown_picture()) else { return };
        let wanted = state.pictured_views();
        if state.doc.view_pictures.of(&view).is_some() || !wanted.contains(&view) {
            return;
        }
        let picture = self.ctx.load_texture("view", smaller(picture), TextureOptions::LINEAR);
        self.state.doc.view_pictures.keep(view, picture, &wanted);
    }
}
