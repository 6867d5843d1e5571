//! Takes in the answers of the workers.

use std::sync::Arc;

use egui::TextureOptions;

use crate::app::control::overlook_app::OverlookApp;
use crate::app::model;
use crate::app::model::{Accuracy, Message, ShownPicture, Texture, Whole, WorkKind, method_of};
use crate::app::rooms::frame::model::{DockView, NoticeKind, NoticeLink};
use crate::app::rooms::share::model::{SharePreview, ShownPreview};
use overlook_engine::error::Error;
use overlook_engine::preprocess::diagnostics::Suspect;
use overlook_engine::preprocess::{PreparedScan, Preprocessed};
use overlook_engine::settings::Settings;

impl OverlookApp {
    /// Takes in one answer, unless it is about a scene that is no longer open.
    pub(crate) fn receive(&mut self, message: Message) {
        let current = self.state.doc.scene.as_ref().map(|scene| scene.id);
        if message.scene().is_some_and(|scene| Some(scene) != current) {
            return;
        }
        let Self { state, ctx, .. } = self;
        match message {
            Message::Opened(scene) => self.opened(&scene),
            Message::Scanned { scan, .. } => self.scanned(scan),
            Message::Pruned { settings, result, read_seconds, .. } => {
                self.pruned(settings, &result, read_seconds);
            }
            Message::Inspected { inspected, .. } => {
                state.doc.inspected = Some(inspected);
                state.doc.failed_frame = None;
            }
            Message::SourcePainted { key, picture } => {
                let replaced = state.doc.source_shown.take().map(|shown| shown.texture);
                // The source view shows single pixels sharply; the live view is interpolated.
                let texture = Texture::send(ctx, "source", Texture::PIXELS, &picture.image, replaced);
                state.doc.source_shown = Some(ShownPicture { key, picture, texture });
            }
            Message::LivePainted { key, picture } => self.live_painted(key, picture),
            Message::LiveCarried { carried, key } => self.live_carried(&key.to, carried),
            Message::Measured { settings, accuracy, .. } => self.measured(&settings, accuracy),
            Message::Probed { spot, probed, is_hole, .. } => self.probed(spot, probed, is_hole),
            Message::Thumbnails { pictures, .. } => {
                let textures =
                    pictures.into_iter().map(|it| ctx.load_texture("thumbnail", it, TextureOptions::LINEAR));
                state.doc.thumbs = textures.collect();
            }
            Message::Histograms { histograms, .. } => state.doc.histograms = histograms,
            Message::ValuesCounted { values, .. } => state.doc.values = Some(values),
            Message::Compared { key, outcome } => self.compared(&key, outcome),
            Message::MemoryMapped { cameras, .. } => state.doc.memory = Some(cameras),
            Message::Saved { path, bytes, holds } => self.saved(&path, bytes, holds),
            Message::Swept { point, known, .. } => state.doc.charts.add(*point, known),
            Message::Stressed { point, known, .. } => state.doc.charts.add_stressed(*point, known),
            Message::Studied { left, .. } => self.studied(left),
            Message::FigureDrawn { image, width_mm } => self.figure_drawn(image, width_mm),
            Message::ChartDrawn { study, image } => self.chart_drawn(study, image),
            Message::Exported { path, exported } => self.exported(&path, &exported),
            Message::PathSaved { path, saved } => self.path_saved(&path, saved),
            Message::PathLoaded { path, file, .. } => self.path_loaded(&path, &file),
            Message::PicturesOpened { folder, .. } => self.pictures_opened(folder),
            Message::Edited { key, edited } => self.edited(*key, edited),
            Message::EditsSaved { path, list } => self.edits_saved(&path, list),
            Message::EditsLoaded { path, list, .. } => self.edits_loaded(&path, list),
            Message::SettingsLoaded { path, settings } => self.settings_loaded(&path, settings),
            Message::PathChosen { purpose, path } => self.path_chosen(purpose, path),
            Message::DestinationChecked { destination, taken } => {
                self.destination_checked(&destination, taken);
            }
            Message::ReadingsChecked { finding, .. } => self.readings_checked(finding),
            Message::ReadingsShown { images, .. } => self.readings_shown(images),
            Message::Stopped { title, text } => self.stopped_writing(title, text),
            Message::SizesMeasured { facts, .. } => state.share.facts = Some(facts),
            Message::SharePreviewed { key, preview } => {
                let replaced = state.share.preview.take().and_then(|shown| shown.picture);
                let picture = preview.map(|SharePreview { image, decibels }| {
                    let replaced = replaced.map(|(texture, _)| texture);
                    (Texture::send(ctx, "preview", TextureOptions::LINEAR, &image, replaced), decibels)
                });
                state.share.preview = Some(ShownPreview { key, picture });
            }
            Message::Failed { work, error } => self.failed(work, &error),
            // Nobody sees it, or the system shows it.
            Message::Prepared | Message::FolderShown => {}
        }
    }

    fn scanned(&mut self, scan: Arc<PreparedScan>) {
        let settings = &self.state.settings;
        // Its settings were taken back, and the scan for the settings on the sliders is here already.
        let late =
            !scan.serves(settings) && self.state.doc.scan.as_ref().is_some_and(|scan| scan.serves(settings));
        if !late {
            self.state.doc.scan = Some(scan);
        }
    }

    fn pruned(&mut self, settings: Settings, result: &Preprocessed, read_seconds: Option<f64>) {
        let state = &mut self.state;
        state.doc.read_seconds = read_seconds.or(state.doc.read_seconds);
        // As above.
        if state.is_whole_ready() && method_of(&settings) != method_of(&state.settings) {
            return;
        }
        let report = &result.report;
        for (suspect, warning) in report.suspects() {
            // A notice of its own reports that another reading fits better.
            let is_told = suspect == Suspect::Depth && report.conventions.is_some();
            if is_told && state.why_no_readings().is_none() {
                continue;
            }
            let title = format!("Check the capture: {}", suspect.name().to_lowercase());
            state.warn_with_link(title, model::sentence(&warning), NoticeLink::View(DockView::Matrix));
        }
        let line = format!(
            "Pruned the capture: {} of {} kept. {}",
            model::count(report.samples_kept),
            model::count_of(report.samples_in, "sample"),
            model::took(read_seconds, report.seconds)
        );
        state.inspector.log(NoticeKind::Done, line);
        state.doc.accuracy = None;
        let (samples, report) = (result.samples.clone(), Arc::new(report.clone()));
        state.doc.whole = Some(Whole { samples, report, settings });
    }

    fn measured(&mut self, settings: &Settings, accuracy: Option<Accuracy>) {
        if *settings != self.state.settings {
            return;
        }
        self.state.doc.accuracy = accuracy;
    }

    /// Updates whether something is being opened or measured: superseded work sends no message of its end.
    pub(crate) fn refresh_busy(&mut self) {
        if self.workers.open.is_idle() {
            self.state.opening = None;
        }
        self.state.doc.charts.studying = !self.workers.study.is_idle();
    }

    fn failed(&mut self, work: WorkKind, error: &Error) {
        if matches!(work, WorkKind::Open | WorkKind::Study) {
            self.refresh_busy();
        }
        if matches!(error, Error::Cancelled) {
            if work == WorkKind::Study {
                self.notify_stopped_study();
            }
            return;
        }
        match work {
            WorkKind::Prune if self.workers.whole.worker.is_idle() => self.state.doc.stopped = true,
            WorkKind::InspectFrame if self.workers.inspect.worker.is_idle() => {
                self.state.doc.failed_frame = self.workers.inspect.asked().map(|request| request.frame);
                // Nothing goes on from here by itself.
                self.state.doc.stopped |= self.state.doc.inspected.is_none();
            }
            _ => {}
        }
        if !self.failed_in_dialog(work, error) {
            self.state.notify_of_failure(work.failure(), error);
        }
        self.type_again(work, error);
    }
}
