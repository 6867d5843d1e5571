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
                self.state.doc.kept_views.push(KeptView { name, view, picture: None });
                self.picture_kept_views();
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

    /// Gives kept views that are shown and have no picture yet a small one.
    pub(super) fn picture_kept_views(&mut self) {
        let state = &self.state;
        if state.doc.live_carried.is_some() || state.doc.kept_views.iter().all(|kept| kept.picture.is_some())
        {
            return;
        }
        let here = state.doc.live_shown.as_ref().map(|shown| &shown.key.vantage);
        let is_here =
            here.is_some_and(|here| here.frame == state.timeline.frame && state.looks_from(&here.camera));
        let Some((view, picture)) = self.view_address().zip(state.shown_picture()).filter(|_| is_here) else {
            return;
        };
        let picture = smaller(picture);
        let kept = self.state.doc.kept_views.iter_mut();
        for kept in kept.filter(|kept| kept.picture.is_none() && kept.view == view) {
            kept.picture = Some(self.ctx.load_texture("kept view", picture.clone(), TextureOptions::LINEAR));
        }
    }
}
