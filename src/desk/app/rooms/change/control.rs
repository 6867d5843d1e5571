//! Notes what was known before a change of settings, and takes in what it did.

use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::{ColorImage, TextureOptions};

use crate::app::control::OverlookApp;
use crate::app::model::window::DockView;
use crate::app::model::{Inspected, Same, method_of};
use crate::app::rooms::change::state::{ChangeRequest, Figures, Glow};
use overlook_engine::settings::Settings;

/// Time between two pictures of what glows.
const STEP: Duration = Duration::from_millis(33);

impl OverlookApp {
    /// Notes what is known before settings change to `next`. A change lasts until all frames are pruned; turning it back ends it.
    pub(crate) fn note_figures_before(&mut self, next: &Settings) {
        let state = &mut self.state;
        let change = &state.doc.change;
        let is_over = change.before.is_none() || state.is_whole_ready();
        if is_over && state.has_capture() {
            state.doc.change.before = Some(Figures::of(state));
        } else if change.before.as_ref().is_some_and(|it| method_of(&it.settings) == method_of(next)) {
            state.doc.change.before = None;
        }
    }

    /// Takes in a pruned frame; what it lacks of the one before, or has more, is to be seen where only the settings differ.
    pub(crate) fn inspected(&mut self, inspected: Inspected) {
        // Out of sight it would hold an old pruning in memory.
        let is_seen = self.state.shows(DockView::Live);
        let doc = &mut self.state.doc;
        let before = doc.inspected.replace(inspected);
        doc.failed_frame = None;
        let (Some(before), Some(now)) = (before, &doc.inspected) else { return };
        let is_change = before.inspection.frame == now.inspection.frame
            && before.with_scan == now.with_scan
            && method_of(&before.settings) != method_of(&now.settings);
        let first = doc.change.unpainted.take().map(|[first, _]| first);
        if is_change && self.state.live.shows_changes && is_seen {
            let first = first.unwrap_or(Same(before.inspection));
            self.state.doc.change.unpainted = Some([first, Same(now.inspection.clone())]);
        }
    }

    /// Lets samples glow that went or came.
    pub(crate) fn change_painted(&mut self, request: &ChangeRequest, pictures: [Option<Arc<ColorImage>>; 2]) {
        let change = &mut self.state.doc.change;
        if let Some([first, last]) = &mut change.unpainted
            && *first == request.pair[0]
        {
            first.clone_from(&request.pair[1]);
            if first == last {
                change.unpainted = None;
            }
        }
        for (picture, came) in pictures.into_iter().zip([false, true]) {
            let Some(picture) = picture else { continue };
            let texture = self.ctx.load_texture("change", picture, TextureOptions::LINEAR);
            let camera = request.camera.clone();
            change.glows.push(Glow { texture, camera, came, since: Instant::now() });
        }
    }

    /// Lets go of what glows no more, and asks for the next picture of what does.
    pub(crate) fn fade_changes(&mut self) {
        let glows = &mut self.state.doc.change.glows;
        glows.retain(|glow| glow.age() < 1.0);
        if !glows.is_empty() {
            self.ctx.request_repaint_after(STEP);
        }
    }
}
