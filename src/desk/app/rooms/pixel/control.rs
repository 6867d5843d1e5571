//! Carries out what concerns the selected pixel.

use std::sync::Arc;

use crate::app::control::OverlookApp;
use crate::app::model::Command;
use crate::app::model::command::{PixelCommand, SourceCommand};
use crate::app::model::picture::PictureZoom;
use crate::app::model::window::NoticeKind;
use crate::app::rooms::pixel::explanation;
use crate::app::rooms::pixel::state::{Probed, Spot};
use crate::app::work::worker::AnySlot;

impl OverlookApp {
    /// Carries out what concerns the selected pixel.
    pub(crate) fn apply_to_pixel(&mut self, command: PixelCommand) {
        match command {
            PixelCommand::Probe(spot) => self.state.doc.probe.spot = spot,
            PixelCommand::Pin(pinned) => self.pin(pinned),
            PixelCommand::ShowPointIn(camera) => self.show_point_in(camera),
            PixelCommand::CopyExplanation => self.copy_explanation(),
        }
    }

    /// Keeps the selected pixel, or lets it go.
    fn pin(&mut self, pinned: bool) {
        let probe = &mut self.state.doc.probe;
        probe.pinned = pinned && probe.spot.is_some();
        // Pinning stops playback: the pixel is one of this frame, and its verdict takes longer than a frame.
        self.state.timeline.playing &= !probe.pinned;
        if !pinned {
            (probe.spot, probe.shown) = (None, None);
        } else if let Some(probed) = probe.shown.as_ref().filter(|probed| Some(probed.spot) == probe.spot) {
            probe.spot = Some(probed.recorded_at());
        } else {
            // The pixel may have been found to be a hole before it was pinned.
            self.workers.probe.forget();
        }
    }

    /// Shows the selected point in the middle of a camera's picture.
    fn show_point_in(&mut self, camera: usize) {
        let Some(scene) = self.state.doc.scene.clone().filter(|scene| camera < scene.cameras.len()) else {
            return;
        };
        self.apply(Command::Source(SourceCommand::Camera(camera)));
        let probe = &mut self.state.doc.probe;
        let Some(probed) = &probe.shown else { return };
        (probe.pinned, probe.spot) = (true, Some(probed.recorded_at()));
        if let Some((at, _)) = probed.in_camera(&scene.cameras, camera) {
            let (columns, rows) = scene.cameras[camera].intrinsics.size();
            let center = at.to_vec2() / egui::vec2(columns as f32, rows as f32);
            self.state.source.part = PictureZoom::new(self.state.source.part.zoom.max(4.0), center);
        }
    }

    fn copy_explanation(&mut self) {
        let shown = self.state.doc.scene.as_ref().zip(self.state.doc.probe.shown.as_ref());
        let Some((scene, probed)) = shown else { return };
        self.ctx.copy_text(explanation(scene, probed));
        self.state.notify(NoticeKind::Done, "Copied", "The explanation of the pixel is on the clipboard.");
    }

    /// Takes in what is known of a pixel.
    pub(crate) fn probed(&mut self, spot: Spot, probed: Option<Arc<Probed>>, is_hole: bool) {
        let probe = &mut self.state.doc.probe;
        // An answer about a spot that the pointer has left is better than none while the next is on its way.
        if probe.spot.is_none() {
            return;
        }
        let is_kept = probe.pinned && probe.spot == Some(spot) && matches!(spot, Spot::Live { .. });
        match &probed {
            Some(probed) if is_kept => probe.spot = Some(probed.recorded_at()),
            // A hole cannot be pinned: a sample that appears there later is another pixel.
            None if is_kept && is_hole => (probe.pinned, probe.spot) = (false, None),
            _ => {}
        }
        probe.shown = probed;
    }
}
