//! Carries out what concerns the dialog of all ways out, and writes what is shared.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use egui::TextureOptions;

use crate::app::control::OverlookApp;
use crate::app::model::purpose::ShareCommand;
use crate::app::model::window::{DockView, NoticeKind, and_others};
use crate::app::model::{self, Content, Message, Texture, WorkKind};
use crate::app::rooms::files::paths::{no_figure, no_scene};
use crate::app::rooms::files::work::{chart_image, color_image, save_picture};
use crate::app::rooms::share::PathExport;
use crate::app::rooms::share::state::{Exported, ShareOutcome, SharePreviewKey, ShownPreview};
use crate::app::rooms::share::work::pictures::{
    self, of_change, of_comparison, of_live_view, of_source_picture,
};
use crate::app::rooms::share::work::{write_path, write_view};
use crate::app::work::FileWork;
use crate::pruned_store::prune_into_store;
use crate::ways_out::cameras::CAMERAS;
use crate::ways_out::figure::{FIGURE, FigureOf, FigureOptions};
use crate::ways_out::film::VIDEO;
use crate::ways_out::pictures::{LINEAR_PICTURE, LINEAR_PICTURES, PICTURE, PICTURES};
use crate::ways_out::store::STORE;
use crate::ways_out::{FileKind, Frames, Shared, WAYS};
use overlook_engine::capture::transforms::write_cameras;
use overlook_engine::edited_store::write_edited_store;
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::page::PagePath;
use overlook_engine::plural::counted;
use overlook_engine::render::film::FilmSource;
use overlook_engine::store;
use overlook_engine::store::playback::Playback;
use overlook_lab::chart::Figure;

/// What draws a figure, and the stage of that.
type Drawing = Box<dyn FnOnce(&Job) -> Result<Figure> + Send>;
const DRAWING: &str = "Drawing the figure";

/// What is left of most files once writing them was stopped.
const NOTHING: &str = "Nothing was";

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
                self.copy_view_as(of, true);
            }
            ShareCommand::CopyPicture(FigureOf::Live) => self.copy_picture(),
            ShareCommand::CopyPicture(of) => self.copy_view_as(of, false),
            ShareCommand::Stop => {
                if self.state.busy.iter().any(|busy| busy.work == WorkKind::Export) {
                    self.workers.export.cancel();
                } else {
                    self.workers.file.cancel();
                }
            }
            ShareCommand::ShowInFolder(path) => self.workers.show_in_folder.submit(path),
        }
    }

    /// Takes in what the live view looks like within the budget of what is shared.
    pub(crate) fn share_previewed(
        &mut self,
        key: SharePreviewKey,
        preview: Option<(Arc<egui::ColorImage>, Option<f64>)>,
    ) {
        let shown = &mut self.state.share.preview;
        let replaced = shown.take().and_then(|shown| shown.picture).map(|(texture, _)| texture);
        let picture = preview.map(|(image, decibels)| {
            (Texture::send(&self.ctx, "preview", TextureOptions::LINEAR, &image, replaced), decibels)
        });
        *shown = Some(ShownPreview { key, picture });
    }

    /// Writes what was chosen in the dialog.
    pub(crate) fn share(&mut self, kind: &'static FileKind, path: PathBuf) {
        self.state.share.asked = Some(path.clone());
        self.state.share.outcome = None;
        match *kind {
            STORE => self.save_store(path),
            CAMERAS => self.save_cameras(path),
            PICTURE | LINEAR_PICTURE => self.save_picture(path),
            FIGURE => self.export_figure(path),
            VIDEO | PICTURES | LINEAR_PICTURES => self.export_pictures(kind, path),
            _ => self.export_samples(kind, path),
        }
    }

    fn save_store(&mut self, path: PathBuf) {
        let Some(scene) = self.state.doc.scene.clone() else { return };
        let (edits, settings) = (self.state.doc.edits.list.clone(), self.state.settings.clone());
        let written = |path: &Path, bytes, holds| {
            Ok(Message::Saved { path: path.to_path_buf(), bytes: Some(bytes), holds })
        };
        if let Content::Store { playback, .. } = &scene.content {
            let playback = playback.clone();
            self.save(path, move |path, job| {
                let store = playback.store();
                let bytes = if edits.is_idle() {
                    store::write_again(path, store, None, job)?
                } else {
                    write_edited_store(path, store, &edits, None, job)?.0
                };
                written(path, bytes, None)
            });
        } else {
            let before = self.state.pruned_before();
            self.save(path, move |path, job| {
                let (_, bytes) =
                    prune_into_store(scene.source()?, before.as_ref(), &settings, &edits, path, job)?;
                written(path, bytes, Some((scene.id, settings)))
            });
        }
    }

    /// Writes the cameras: as they were pruned, or as the capture has them.
    fn save_cameras(&mut self, path: PathBuf) {
        let state = &self.state;
        let Some(scene) = &state.doc.scene else { return };
        let cameras =
            state.current_whole().map_or_else(|| scene.cameras.clone(), |whole| whole.cameras.clone());
        let frame_number = scene.frame_numbers.get(state.timeline.frame).copied().unwrap_or_default();
        let up_in_world = state.up_in_world();
        self.save(path, move |path, _| {
            write_cameras(path, &cameras, frame_number, up_in_world)?;
            Ok(Message::Saved { path: path.to_path_buf(), bytes: None, holds: None })
        });
    }

    /// Writes what the live view shows, in another size than on the screen where one is chosen.
    fn save_picture(&mut self, path: PathBuf) {
        let state = &mut self.state;
        let key = state.share.options.picture_size.and_then(|size| state.live_key(size, state.dark));
        let shown = state.doc.live_shown.as_ref();
        let rendered = shown.and_then(|shown| shown.picture.rendered()).cloned();
        if let Some(key) = key.filter(|_| state.samples_here().is_some()) {
            self.export(path, None, NOTHING, move |path, job| write_view(path, &key, job));
        } else if let Some((picture, rendered)) = state.shown_picture().cloned().zip(rendered) {
            let display = state.display;
            self.save(path, move |path, _| {
                save_picture(path, &picture, &rendered, &display)?;
                Ok(Message::Saved { path: path.to_path_buf(), bytes: None, holds: None })
            });
        } else {
            state.share.asked = None;
            self.notify_in_motion();
        }
    }

    /// Writes a figure of the view that is chosen in the dialog, as it is shown.
    fn export_figure(&mut self, path: PathBuf) {
        let Some((options, draw)) = self.figure(self.state.share.options.figure_of) else { return };
        let scene = self.state.doc.scene.as_ref();
        let disk = scene.and_then(|scene| scene.playback().cloned());
        self.export(path, disk, NOTHING, move |path, job| {
            job.start(DRAWING, 0);
            let bytes = pictures::write(path, &draw(job)?)?;
            let millimeters = model::significant(options.width_mm());
            Ok((format!("a figure of {millimeters} mm, {}", model::bytes(bytes)), None))
        });
    }

    /// Writes a film of the camera path, or its pictures into a folder.
    fn export_pictures(&mut self, kind: &FileKind, path: PathBuf) {
        let Some((source, disk)) = self.shared_samples() else { return };
        let state = &self.state;
        let export = PathExport {
            vantages: state.film_vantages(),
            compared: state.compared_film(),
            look: state.filmed_look(),
            settings: state.settings.render.clone(),
            display: state.display,
            size: state.export_size(),
            caption: state.share.options.film_caption.clone(),
            film_rate: (*kind == VIDEO).then(|| state.timeline.frames_per_second.into()),
            linear: *kind == LINEAR_PICTURES,
        };
        let left = if *kind == VIDEO { NOTHING } else { "Only the pictures rendered until then were" };
        let threads = self.workers.filming.clone();
        self.export(path, disk, left, move |path, job| write_path(path, &source, &export, &threads, job));
    }

    /// Writes what becomes of all samples.
    fn export_samples(&mut self, kind: &'static FileKind, path: PathBuf) {
        let mut ways = WAYS.iter().filter_map(|(_, way)| way.write);
        let write = ways.find(|(kinds, _)| kinds.contains(kind));
        let (Some((_, write)), Some((source, disk))) = (write, self.shared_samples()) else { return };
        let state = &self.state;
        let shared = Shared {
            kind,
            options: state.share.options.clone(),
            frames: if kind.endings.is_empty() { Frames::Every } else { Frames::One(state.timeline.frame) },
            frames_per_second: state.timeline.frames_per_second.into(),
            path: self.page_path(),
            count: model::count_of,
        };
        self.export(path, disk, NOTHING, move |path, job| {
            let (said, files) = write(path, &source, &shared, job)?;
            let is_folder = shared.frames == Frames::Every;
            Ok((if is_folder { format!("{said}, {}", counted(files, "file")) } else { said }, None))
        });
    }

    /// All samples as they are edited, and the store that they are in.
    fn shared_samples(&self) -> Option<(FilmSource, Option<Arc<Playback>>)> {
        let state = &self.state;
        let samples = state.whole_samples()?;
        let edited = state.edited_samples();
        let disk = state.doc.scene.as_ref().and_then(|scene| scene.playback().cloned());
        if let Some(playback) = disk.filter(|_| edited.is_none()) {
            return Some((FilmSource::Disk(playback.clone()), Some(playback)));
        }
        // As a store does, a page takes the rendering settings of now.
        let mut samples = (**edited.unwrap_or(samples)).clone();
        samples.settings.render = state.settings.render.clone();
        Some((FilmSource::Memory(samples.into()), None))
    }

    /// Writes something of samples, which `disk` holds. `write` gives what was written, and why the renderer of the settings was not used.
    /// `left` is what is left once it was stopped.
    fn export(
        &mut self,
        path: PathBuf,
        disk: Option<Arc<Playback>>,
        left: &str,
        write: impl FnOnce(&Path, &Job) -> Result<(String, Option<String>)> + Send + 'static,
    ) {
        let stopped = ("Export stopped", format!("{left} written to {}.", path.display()));
        self.workers.export.submit(FileWork::new(stopped, move |job| {
            let (said, notice) = write(&path, job)?;
            let damage = disk.map_or_else(Vec::new, |playback| playback.store().damage());
            Ok(Message::Exported { path, exported: Exported { said, notice, damage } })
        }));
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
    fn copy_view_as(&mut self, of: FigureOf, is_figure: bool) {
        let missing = no_scene(&self.state).or_else(|| no_figure(&self.state, of));
        let Some((options, draw)) = self.figure(of).filter(|_| missing.is_none()) else {
            let why = missing.unwrap_or("There is no picture yet; try again once the view rests.");
            return self.state.warn_of_scene("Nothing to copy", why);
        };
        let stopped = ("Export stopped", "Nothing was copied.".to_owned());
        self.workers.export.submit(FileWork::new(stopped, move |job| {
            job.start(DRAWING, 0);
            let figure = draw(job)?;
            let (image, name, width_mm) = if is_figure {
                (chart_image(&figure.chart()?)?, "figure", Some(options.width_mm()))
            } else {
                (color_image(&figure.picture), "picture", None)
            };
            Ok(Message::Drawn { image, name: name.to_owned(), width_mm })
        }));
    }

    /// Copies what was drawn for the clipboard.
    pub(crate) fn drawn(&mut self, image: egui::ColorImage, name: &str, width_mm: Option<f64>) {
        let [columns, rows] = image.size;
        self.ctx.copy_image(image);
        let width = width_mm.map(|width| format!(", {} mm wide", model::significant(width)));
        let width = width.unwrap_or_default();
        let text = format!("The {name} is on the clipboard: {columns}×{rows} pixels{width}.");
        self.state.notify(NoticeKind::Done, "Copied", text);
    }

    /// What draws a figure of a view as it is shown, and its options; `None` while there is no picture.
    fn figure(&self, of: FigureOf) -> Option<(FigureOptions, Drawing)> {
        let state = &self.state;
        let options = FigureOptions { unit: state.live.unit, ..state.share.options.figure.clone() };
        let (scene, how) = (state.doc.scene.clone()?, options.clone());
        let draw: Drawing = match of {
            FigureOf::Live => {
                let key = state.live_key(state.figure_size(), options.is_dark)?;
                Box::new(move |job| of_live_view(&key, &how, job))
            }
            FigureOf::Change => {
                let pair = state.changed_samples()?;
                let key = state.live_key(state.figure_size(), options.is_dark)?;
                Box::new(move |job| of_change(&key, pair.each_ref().map(|samples| &**samples), &how, job))
            }
            FigureOf::Source => {
                let key = state.doc.source_shown.as_ref()?.key.clone();
                Box::new(move |_| of_source_picture(&scene.cameras, scene.source(), &key, &how))
            }
            FigureOf::Compared => {
                let compared = state.compared_figure()?;
                Box::new(move |_| Ok(of_comparison(&compared, &how)))
            }
        };
        Some((options, draw))
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
        let is_shared = share.asked.take_if(|asked| asked == path).is_some();
        if is_shared && share.is_open {
            let said = model::sentence(said);
            share.outcome = Some(ShareOutcome::Written { said, path: path.to_path_buf() });
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
            let why = format!("{}: {error}", work.failure());
            share.outcome = Some(ShareOutcome::Failed(why.clone()));
            self.state.inspector.log(NoticeKind::Error, why);
        }
        is_said
    }
}
