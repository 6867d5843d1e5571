//! Carries out what concerns the dialog of all ways out, and writes what is shared.

use std::path::{Path, PathBuf};

use egui::TextureOptions;

use crate::app::control::OverlookApp;
use crate::app::model;
use crate::app::model::command::{ExportTarget, Exported};
use crate::app::model::purpose::{FigureOf, FigureOptions, Purpose};
use crate::app::model::ways_out::ShareCommand;
use crate::app::model::window::{DockView, NoticeKind, and_others};
use crate::app::model::{Texture, WorkKind};
use crate::app::rooms::files::paths::{no_figure, no_scene};
use crate::app::rooms::share::state::{ShareOutcome, SharePreview, SharePreviewKey, ShownPreview};
use crate::app::work::{Export, ExportRequest, FigureExport, PathExport};
use overlook_engine::error::Error;
use overlook_engine::page::{PageOptions, PagePath};
use overlook_engine::render::film::FilmSource;
use overlook_engine::splats::{SplatAmount, SplatOptions};

impl OverlookApp {
    /// Carries out what concerns the dialog.
    pub(crate) fn apply_to_share(&mut self, command: ShareCommand) {
        let share = &mut self.state.share;
        match command {
            ShareCommand::Open(way) => {
                share.is_open = self.state.doc.scene.is_some();
                share.options.way = way.unwrap_or(share.options.way);
                share.outcome = None;
                // Nothing below keeps the keyboard.
                let below = self.ctx.memory(egui::Memory::focused);
                self.ctx.memory_mut(|memory| below.into_iter().for_each(|id| memory.surrender_focus(id)));
                // Sizes are those of the frame that is shown.
                self.state.timeline.playing = false;
                self.state.doc.path.playing = None;
                if self.state.doc.scene.is_none() {
                    self.state.warn_of_scene("Nothing to share yet", "Open a capture or a store first.");
                }
            }
            ShareCommand::Close => share.is_open = false,
            ShareCommand::Change(options) => {
                if options.way != share.options.way {
                    share.outcome = None;
                }
                share.options = *options;
            }
            ShareCommand::CopyFigure(of) => {
                let of = of.unwrap_or_else(|| self.view_of_figure());
                self.copy_view_as(of, Export::CopyFigure);
            }
            ShareCommand::CopyPicture(FigureOf::Live) => self.copy_picture(),
            ShareCommand::CopyPicture(of) => self.copy_view_as(of, Export::CopyPicture),
            ShareCommand::Stop => {
                let is_export = |busy: &model::Busy| busy.work == WorkKind::Export;
                if self.state.busy.iter().any(is_export) {
                    self.workers.export.cancel();
                } else {
                    self.workers.file.cancel();
                }
            }
            ShareCommand::ShowInFolder(path) => self.workers.show_in_folder.submit(path),
        }
    }

    /// Takes in what the live view looks like within the budget of what is shared.
    pub(crate) fn share_previewed(&mut self, key: SharePreviewKey, preview: Option<SharePreview>) {
        let shown = &mut self.state.share.preview;
        let replaced = shown.take().and_then(|shown| shown.picture);
        let picture = preview.map(|SharePreview { image, decibels }| {
            let replaced = replaced.map(|(texture, _)| texture);
            (Texture::send(&self.ctx, "preview", TextureOptions::LINEAR, &image, replaced), decibels)
        });
        *shown = Some(ShownPreview { key, picture });
    }

    /// Notes where something is written that the dialog was asked for.
    pub(crate) fn begin_sharing(&mut self, purpose: Purpose, path: &Path) {
        if purpose.is_shared() {
            self.state.share.asked = Some(path.to_path_buf());
            self.state.share.outcome = None;
        }
    }

    /// Writes what becomes of all samples, with what is chosen in the dialog.
    pub(crate) fn export(&mut self, purpose: Purpose, path: PathBuf) {
        let Some(samples) = self.state.whole_samples().cloned() else { return };
        let Some(what) = self.exported_as(purpose) else { return };
        let edited = self.state.edited_samples().cloned();
        let playback = self.state.doc.scene.as_ref().and_then(|scene| scene.playback().cloned());
        let playback = playback.filter(|_| edited.is_none());
        let samples = edited.unwrap_or(samples);
        let source = playback.map_or_else(
            || {
                // As a store does, a page takes the rendering settings of now.
                let mut samples = (*samples).clone();
                samples.settings.render = self.state.settings.render.clone();
                FilmSource::Memory(samples.into())
            },
            FilmSource::Disk,
        );
        self.workers.export.submit(ExportRequest { path, source, what });
    }

    /// Writes a figure of the view that is chosen in the dialog, as it is shown.
    pub(crate) fn export_figure(&mut self, path: PathBuf) {
        let Some((figure, source)) = self.figure(self.state.share.options.figure_of) else { return };
        self.workers.export.submit(ExportRequest { path, source, what: Export::Figure(Box::new(figure)) });
    }

    /// Writes what the live view shows in another size than on the screen; false where that cannot be.
    pub(crate) fn export_view(&mut self, path: PathBuf, size: [u32; 2]) -> bool {
        let key = self.state.live_key(size, self.state.dark);
        let Some((key, samples)) = key.zip(self.state.samples_here().cloned()) else { return false };
        // The key has its samples itself.
        let (source, what) = (FilmSource::Memory(samples), Export::View(Box::new(key)));
        self.workers.export.submit(ExportRequest { path, source, what });
        true
    }

    /// The view that a figure is of where none is named.
    fn view_of_figure(&self) -> FigureOf {
        match self.state.look.maximized.or_else(|| self.dock.pointed_at()) {
            Some(DockView::Source) => FigureOf::Source,
            Some(DockView::Compare) => FigureOf::Compared,
            _ => FigureOf::Live,
        }
    }

    /// Copies the figure that the dialog would write of a view, with the options that were chosen last, or its picture alone.
    fn copy_view_as(&mut self, of: FigureOf, export: impl FnOnce(Box<FigureExport>) -> Export) {
        let missing = no_scene(&self.state).or_else(|| no_figure(&self.state, of));
        match self.figure(of) {
            Some((figure, source)) if missing.is_none() => {
                let what = export(Box::new(figure));
                self.workers.export.submit(ExportRequest { path: PathBuf::new(), source, what });
            }
            _ => {
                let why = missing.unwrap_or("There is no picture yet; try again once the view rests.");
                self.state.warn_of_scene("Nothing to copy", why);
            }
        }
    }

    /// Takes in a figure that was drawn to be copied, so many millimeters wide, or a picture alone.
    pub(crate) fn figure_drawn(&mut self, image: egui::ColorImage, width_mm: Option<f64>) {
        let [columns, rows] = image.size;
        self.ctx.copy_image(image);
        let size = format!("{columns}×{rows} pixels");
        let text = match width_mm.map(model::significant) {
            Some(width) => format!("The figure is on the clipboard: {size}, {width} mm wide."),
            None => format!("The picture is on the clipboard: {size}."),
        };
        self.state.notify(NoticeKind::Done, "Copied", text);
    }

    /// A figure of a view as it is shown, and what the view shows; `None` while there is no picture.
    fn figure(&self, of: FigureOf) -> Option<(FigureExport, FilmSource)> {
        let state = &self.state;
        let options = FigureOptions { unit: state.live.unit, ..state.share.options.figure.clone() };
        let scene = state.doc.scene.as_ref()?;
        let figure = match of {
            FigureOf::Live => {
                let key = state.live_key(state.figure_size(), options.is_dark)?;
                FigureExport::Live { key: Box::new(key), options }
            }
            FigureOf::Source => {
                let key = state.doc.source_shown.as_ref()?.key.clone();
                FigureExport::Source { scene: scene.clone(), key, options }
            }
            FigureOf::Compared => {
                FigureExport::Compared { compared: Box::new(state.compared_figure()?), options }
            }
        };
        let samples = state.samples_here()?.clone();
        let source =
            scene.playback().map_or(FilmSource::Memory(samples), |store| FilmSource::Disk(store.clone()));
        Some((figure, source))
    }

    fn exported_as(&self, purpose: Purpose) -> Option<Export> {
        let (state, options) = (&self.state, &self.state.share.options);
        let frames_per_second = f64::from(state.timeline.frames_per_second);
        let along_path = |film_rate, linear| {
            Export::Path(Box::new(PathExport {
                vantages: state.film_vantages(),
                compared: state.compared_film(),
                look: state.filmed_look(),
                settings: state.settings.render.clone(),
                display: state.display,
                size: state.export_size(),
                target: ExportTarget { film_rate, linear },
            }))
        };
        let some = |text: &str| (!text.trim().is_empty()).then(|| text.trim().to_owned());
        Some(match purpose {
            Purpose::ExportPage => Export::Page(PageOptions {
                scalar_bar: None,
                title: some(&options.title),
                text: some(&options.text),
                frames_per_second,
                path: self.page_path(),
                at_most: options.page_at_most(),
            }),
            Purpose::ExportSplats(format) => Export::Splats {
                options: SplatOptions {
                    format,
                    amount: SplatAmount { at_most: options.splats_at_most(), sky: options.sky },
                    frames_per_second,
                },
                frame: state.timeline.frame,
            },
            Purpose::ExportPoints => Export::Points { frame: Some(state.timeline.frame) },
            Purpose::ExportPointsOfFrames => Export::Points { frame: None },
            Purpose::ExportFilm => along_path(Some(frames_per_second), false),
            Purpose::ExportPictures => along_path(None, false),
            Purpose::ExportExr => along_path(None, true),
            _ => return None,
        })
    }

    /// The camera path as a page follows it: a pose for each frame.
    fn page_path(&self) -> Option<PagePath> {
        let path = &self.state.doc.path;
        let vantages = path.vantage_of_each_frame(self.state.export_size(), self.state.frame_count());
        let first = vantages.first()?;
        Some(PagePath {
            first_frame: first.frame,
            lens: first.camera.intrinsics,
            poses: vantages.iter().map(|vantage| vantage.camera.world_from_camera).collect(),
        })
    }

    /// Takes in that something is written; the dialog says it where it is open.
    pub(crate) fn written(&mut self, title: &str, path: &Path, said: &str, text: String) {
        let share = &mut self.state.share;
        let is_shared = share.asked.as_deref() == Some(path);
        if is_shared {
            share.asked = None;
            share.outcome =
                Some(ShareOutcome::Written { said: model::sentence(said), path: path.to_path_buf() });
        }
        if is_shared && self.state.share.is_open {
            self.state.inspector.log(NoticeKind::Done, format!("{title}: {text}"));
        } else {
            self.state.notify_of_file(title, text, path);
        }
    }

    /// Takes in that what all samples became is written.
    pub(crate) fn exported(&mut self, path: &Path, exported: &Exported) {
        let Exported { said, notice, damage } = exported;
        let place = path.display();
        self.written("Exported", path, said, format!("{said} in {place}"));
        if let Some(notice) = notice {
            let text = format!("Of {place}: {notice}");
            self.state.notify(NoticeKind::Warning, "Exported without the GPU", text);
        }
        if let Some((first, others)) = damage.split_first() {
            let text = format!("What is in {place} lacks it: {}", and_others(first, others.len()));
            self.state.notify(NoticeKind::Warning, "Exported from a damaged store", text);
        }
    }

    /// Takes in that something was stopped; the dialog says it where it is open and had asked for it.
    pub(crate) fn stopped_writing(&mut self, title: &str, text: String) {
        let share = &mut self.state.share;
        if share.asked.take().is_some() {
            share.outcome = Some(ShareOutcome::Failed(format!("{title}. {text}")));
        }
        if self.state.share.is_open {
            self.state.inspector.log(NoticeKind::Warning, format!("{title}: {text}"));
        } else {
            self.state.notify(NoticeKind::Warning, title, text);
        }
    }

    /// Takes in that work failed; true where the dialog says so.
    pub(crate) fn failed_in_dialog(&mut self, work: WorkKind, error: &Error) -> bool {
        let share = &mut self.state.share;
        let is_writing = matches!(work, WorkKind::File | WorkKind::Export) && share.asked.take().is_some();
        let is_said = share.is_open && (is_writing || work == WorkKind::ShowInFolder);
        if is_said {
            share.outcome = Some(ShareOutcome::Failed(format!("{}: {error}", work.failure())));
            self.state.inspector.log(NoticeKind::Error, format!("{}: {error}", work.failure()));
        }
        is_said
    }
}
