//! Paths that are chosen in a dialog or typed: their purpose, whether there is anything to write, and whether they exist already.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::app::control::OverlookApp;
use crate::app::model::command::{FileCommand, Opening};
use crate::app::model::purpose::{AskedPath, FigureOf, Purpose, TableForm, TypedPath};
use crate::app::model::window::NoticeKind;
use crate::app::model::{Command, Message, State, WorkKind};
use crate::app::rooms::charts::sheet;
use crate::app::rooms::files::work::{chart_bytes, chart_image, open_rendered};
use crate::app::rooms::path::NO_KEYS;
use crate::app::rooms::report::table_text;
use crate::app::work::FileWork;
use crate::ways_out::store::STORE;
use crate::ways_out::{Action, Needs};
use overlook_engine::capture::transforms::{open_path, path_to_json};
use overlook_engine::edits::EditList;
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::settings::Settings;
use overlook_engine::whole_file;
use overlook_lab::chart::Chart;

/// A dialog that closes faster than this was not shown: a system without one may take that long to find out.
const NO_DIALOG: Duration = Duration::from_secs(2);

impl OverlookApp {
    /// Carries out what concerns files.
    pub(crate) fn apply_to_files(&mut self, command: FileCommand) {
        match command {
            FileCommand::Open(opening) => self.ask_to_open(opening),
            // Before a path is chosen for nothing.
            FileCommand::AskPath(purpose) if self.refuses(purpose) => {}
            FileCommand::AskPath(purpose) if !self.has_dialogs => {
                self.type_path(purpose, suggested_name(&self.state, purpose), None);
            }
            FileCommand::AskPath(purpose) => {
                self.asked_at = Some(Instant::now());
                self.workers.dialog.submit((purpose, suggested_name(&self.state, purpose)));
            }
            FileCommand::SaveSession => self.save_session_again(),
            FileCommand::TypedPath(text) => {
                if let Some(typed) = &mut self.state.typed_path {
                    (typed.text, typed.replaces) = (text, false);
                }
            }
            FileCommand::TakeTypedPath => self.take_typed_path(),
            FileCommand::CloseTypedPath => self.state.typed_path = None,
            FileCommand::CopyCommandLine => self.copy_command_line(),
            FileCommand::ForgetRecent => {
                self.state.recent.clear();
                self.state.recent_pictures.clear();
                self.state.chosen_ups.clear();
            }
            FileCommand::Introduced => self.state.inspector.introduced = true,
            FileCommand::RoomExplained => self.state.inspector.room_explained = true,
            FileCommand::Stay => {
                self.state.inspector.closing.asks = false;
                self.state.open_after_question = None;
            }
            FileCommand::GoOnAnyway => self.go_on_anyway(),
        }
    }

    fn type_path(&mut self, purpose: Purpose, text: String, reason: Option<String>) {
        let folder = std::env::current_dir().ok();
        self.state.typed_path = Some(TypedPath { purpose, text, folder, reason, replaces: false });
    }

    /// Takes the path in the field. A path to write to is taken once it is known to be free, or may be replaced.
    fn take_typed_path(&mut self) {
        let Some(typed) = &mut self.state.typed_path else { return };
        let (purpose, Some(path)) = (typed.purpose, place(&typed.text)) else { return };
        let Some(path) = named(purpose, path) else {
            typed.reason = Some(other_ending(purpose));
            return;
        };
        if purpose.writes() && !typed.replaces {
            self.workers.check.submit((purpose, path));
        } else {
            self.last_typed = self.state.typed_path.take();
            self.take_path(purpose, path);
        }
    }

    /// Takes in whether the path in the field exists.
    pub(crate) fn path_checked(&mut self, purpose: Purpose, path: PathBuf, taken: bool) {
        if !purpose.writes() {
            let opening = Opening::Path(path);
            if taken && self.state.unsaved_work().is_some() {
                self.state.open_after_question = Some(opening);
            } else {
                // A path that does not exist fails to open like any other, and the open scene stays.
                self.open(opening);
            }
            return;
        }
        let is_meant = |typed: &&mut TypedPath| {
            typed.purpose == purpose && typed_destination(typed).as_ref() == Some(&path)
        };
        let Some(typed) = self.state.typed_path.as_mut().filter(is_meant) else { return };
        if taken {
            typed.replaces = true;
        } else {
            self.last_typed = self.state.typed_path.take();
            self.take_path(purpose, path);
        }
    }

    /// Takes in what the system's dialog was answered.
    pub(crate) fn path_chosen(&mut self, purpose: Purpose, path: Option<PathBuf>) {
        let asked_at = self.asked_at.take();
        match path {
            // The dialog asks before it replaces a file of the chosen name, but not for folders, nor for a name with an added ending.
            Some(path)
                if (purpose.asked().endings.is_empty()
                    || named(purpose, path.clone()).as_ref() != Some(&path))
                    && path.to_str().is_some() =>
            {
                self.type_path(purpose, path.display().to_string(), None);
                self.take_typed_path();
            }
            Some(path) => self.take_path(purpose, path),
            None if asked_at.is_some_and(|at| at.elapsed() < NO_DIALOG) => {
                self.has_dialogs = false;
                let reason = "The system's file dialog gave no path; type it here instead.";
                self.type_path(purpose, suggested_name(&self.state, purpose), Some(reason.to_owned()));
            }
            None => {
                self.state.notify(NoticeKind::Done, "No path was chosen", "Nothing was opened or written.");
            }
        }
    }

    /// Shows a path again that was typed and could not be read or written.
    pub(crate) fn type_again(&mut self, work: WorkKind, error: &Error) {
        let Error::Io { path, .. } = error else { return };
        let last = self.last_typed.take_if(|last| {
            last.purpose.work() == work
                && typed_destination(last).is_some_and(|place| path.starts_with(place))
        });
        if let (Some(last), None) = (last, &self.state.typed_path) {
            self.state.typed_path =
                Some(TypedPath { reason: Some(error.to_string()), replaces: false, ..last });
        }
    }

    pub(crate) fn take_path(&mut self, purpose: Purpose, path: PathBuf) {
        let path = lasting(path);
        // Thresholds may have been changed while a path was chosen.
        if self.refuses(purpose) {
            return;
        }
        let scene = self.state.doc.scene.clone();
        let scene_id = scene.as_ref().map_or(0, |scene| scene.id);
        match purpose {
            Purpose::OpenFile | Purpose::OpenFolder => {
                self.apply(Command::File(FileCommand::Open(Opening::Path(path))));
            }
            Purpose::Share(kind) => self.share(kind, path),
            Purpose::SaveSettings => {
                let settings = self.state.shown_settings();
                self.save(path, move |path, _| saved(path, settings.to_toml()));
            }
            Purpose::LoadSettings => self.load(path, |path| {
                let settings = Settings::load(&path)?;
                Ok(Message::SettingsLoaded { path, settings })
            }),
            Purpose::SaveTable(table) => {
                if let Some(text) = table_text(table, TableForm::of_file(&path), &self.state) {
                    self.save(path, move |path, _| saved(path, text));
                }
            }
            Purpose::SaveChart(study) => {
                if let Some(chart) = sheet(study, &self.state) {
                    self.save(path, move |path, _| saved(path, chart_bytes(path, &chart)?));
                }
            }
            Purpose::SavePath => self.save_path(path),
            Purpose::LoadPath => self.load(path, move |path| {
                Ok(Message::PathLoaded { scene: scene_id, file: open_path(&path, false)?, path })
            }),
            Purpose::SaveEdits => self.save_edits(path),
            Purpose::SaveSession => self.save_session(&path),
            Purpose::LoadEdits => self.load(path, move |path| {
                Ok(Message::EditsLoaded { scene: scene_id, list: EditList::load(&path)?, path })
            }),
            Purpose::OpenPictures => {
                let Some(scene) = scene else { return };
                self.load(path, move |path| {
                    Ok(Message::PicturesOpened { scene: scene_id, folder: open_rendered(&path, &scene)? })
                });
            }
        }
    }

    /// Writes a file once those before it are written.
    pub(crate) fn save(
        &mut self,
        path: PathBuf,
        write: impl FnOnce(&Path, &Job) -> Result<Message> + Send + 'static,
    ) {
        let stopped = ("Saving stopped", format!("Nothing was written to {}.", path.display()));
        self.workers.file.submit(FileWork::new(stopped, move |job| write(&path, job)));
    }

    /// Reads a file, likewise.
    fn load(&mut self, path: PathBuf, read: impl FnOnce(PathBuf) -> Result<Message> + Send + 'static) {
        let stopped = ("Loading stopped", format!("Nothing was read from {}.", path.display()));
        self.workers.file.submit(FileWork::new(stopped, move |_| read(path)));
    }

    /// Draws a chart for the clipboard, where it is called `name`.
    pub(crate) fn draw_chart(&mut self, name: String, chart: Chart) {
        let stopped = ("Copying stopped", "Nothing was copied.".to_owned());
        let draw = move |_: &Job| Ok(Message::Drawn { image: chart_image(&chart)?, name, width_mm: None });
        self.workers.file.submit(FileWork::new(stopped, draw));
    }

    fn save_path(&mut self, path: PathBuf) {
        let Some(scene) = self.state.doc.scene.clone() else { return };
        let (saved, size) = (self.state.doc.path.clone(), self.state.export_size());
        let up_in_world = self.state.up_in_world();
        self.save(path, move |path, _| {
            let views = saved.views(size, &scene.frame_numbers);
            whole_file::write_all(path, path_to_json(up_in_world, &views, saved.easing)?)?;
            Ok(Message::PathSaved { path: path.to_path_buf(), saved })
        });
    }

    /// Whether something that a purpose needs is missing; warns if so.
    pub(crate) fn refuses(&mut self, purpose: Purpose) -> bool {
        let Some((title, text)) = what_is_missing(&self.state, purpose) else { return false };
        self.state.warn_of_scene(title, text);
        true
    }
}

/// Title and text of the warning if there is nothing to write for a purpose, or nothing that could use what it reads.
pub(crate) fn what_is_missing(state: &State, purpose: Purpose) -> Option<(&'static str, String)> {
    let where_not = |is_there: bool, text: &'static str| (!is_there).then_some(text);
    let no_scene = || no_scene(state);
    let no_keys = || where_not(state.doc.path.pictures() > 0, NO_KEYS);
    let no_samples = || no_scene().or_else(|| where_not(state.is_whole_ready(), not_pruned(state)));
    let (title, text) = match purpose {
        Purpose::SaveTable(table) => {
            let is_empty = table_text(table, TableForm::Csv, state).is_none();
            return is_empty.then(|| ("Nothing to save yet", format!("There is no {} yet.", table.name())));
        }
        Purpose::SaveChart(study) => {
            let is_empty = sheet(study, state).is_none();
            return is_empty.then(|| ("Nothing to save yet", study.no_chart()));
        }
        Purpose::Share(kind) => {
            let no_film = || match state.share.options.compares {
                Some(_) => no_figure(state, FigureOf::Live),
                None => no_keys(),
            };
            let missing = match kind.needs {
                Needs::Nothing => None,
                Needs::Scene => no_scene(),
                Needs::Samples => no_samples(),
                Needs::Film => no_samples().or_else(no_film),
                Needs::Figure => no_scene().or_else(|| no_figure(state, state.share.options.figure_of)),
            };
            let is_saved = kind.action == Action::Save;
            (if is_saved { "Nothing to save yet" } else { "Nothing to export yet" }, missing)
        }
        Purpose::SavePath => ("No camera path to save", no_scene().or_else(no_keys)),
        Purpose::LoadPath => ("No scene for a camera path", no_scene()),
        Purpose::SaveSession => {
            let text =
                "A session names the file or folder that is open; what comes with the program has none.";
            ("No session to save", where_not(state.opened_path().is_some(), text))
        }
        Purpose::SaveEdits | Purpose::LoadEdits => ("No scene for edits", no_scene()),
        Purpose::OpenPictures => (
            "Nothing to compare pictures with",
            where_not(
                state.has_capture(),
                "Open a capture first: a store has no viewpoints with true pictures.",
            ),
        ),
        Purpose::OpenFile | Purpose::OpenFolder | Purpose::SaveSettings | Purpose::LoadSettings => {
            return None;
        }
    };
    text.map(|text| (title, text.to_owned()))
}

/// Why nothing can be written while nothing is open.
pub(crate) fn no_scene(state: &State) -> Option<&'static str> {
    state.doc.scene.is_none().then_some("Open a capture or a store first.")
}

/// Why there is no picture for a figure.
pub(crate) fn no_figure(state: &State, of: FigureOf) -> Option<&'static str> {
    match of {
        FigureOf::Source if state.doc.source_shown.is_none() => {
            Some("There is no source picture: a store holds none, and a capture shows it once it is read.")
        }
        FigureOf::Compared if state.compared_figure().is_none() => {
            Some("There is no comparison: open Compare, and choose two sides that it can show.")
        }
        FigureOf::Live | FigureOf::Change if state.doc.live_shown.is_none() => {
            Some("The live view has no picture yet.")
        }
        FigureOf::Change if state.changed_samples().is_none() => Some(
            "No change of settings is known at this frame: turn a threshold, and wait until the frame is pruned.",
        ),
        _ => None,
    }
}

/// Why the whole capture is not pruned with the settings on the sliders.
fn not_pruned(state: &State) -> &'static str {
    if state.doc.stopped {
        "The whole capture is not pruned with these settings; recompute it (below), then try again."
    } else {
        "The whole capture is not pruned with these settings yet; try again once the line at the bottom is done."
    }
}

/// Writes a text or bytes to a file.
pub(crate) fn saved(path: &Path, bytes: impl AsRef<[u8]>) -> Result<Message> {
    whole_file::write_all(path, bytes)?;
    Ok(Message::Saved { path: path.to_path_buf(), bytes: None, holds: None })
}

/// What is wrong with a name that [`named`] does not take.
pub(crate) fn other_ending(purpose: Purpose) -> String {
    match purpose.asked().endings {
        endings if endings.contains(&"exr") => {
            "A picture is written as PNG or EXR; name it .png or .exr.".to_owned()
        }
        endings => format!("A file of this kind is named .{}.", endings.first().unwrap_or(&"")),
    }
}

/// A likely name of a file to write; empty for a path that must exist already.
pub(crate) fn suggested_name(state: &State, purpose: Purpose) -> String {
    let AskedPath { endings, stem, .. } = purpose.asked();
    let scene = || state.doc.scene.as_ref().map_or("capture", |scene| &scene.name);
    let stem = if stem.is_empty() { scene() } else { stem };
    match (purpose, endings.first()) {
        (Purpose::SaveTable(table), _) => table.file().to_owned(),
        (Purpose::SaveChart(study), _) => study.chart_file().to_owned(),
        _ if !purpose.writes() => String::new(),
        (_, Some(ending)) => format!("{stem}.{ending}"),
        (_, None) => stem.to_owned(),
    }
}

/// The path of a typed text, with `~` for the home folder; `None` for an empty text.
pub(crate) fn place(text: &str) -> Option<PathBuf> {
    let text = text.trim();
    let at_home = text.strip_prefix('~').filter(|rest| rest.is_empty() || rest.starts_with('/'));
    let path = match (at_home, std::env::home_dir()) {
        (Some(rest), Some(home)) => home.join(rest.trim_start_matches('/')),
        _ => PathBuf::from(text),
    };
    (!text.is_empty()).then(|| lasting(path))
}

/// The path with the ending that a file of this purpose needs; `None` if it has the ending of another kind of file.
pub(crate) fn named(purpose: Purpose, path: PathBuf) -> Option<PathBuf> {
    let endings = purpose.asked().endings;
    let Some(usual) = endings.first().filter(|_| purpose.writes()) else { return Some(path) };
    // Who types a whole name over the proposed stem has its ending twice.
    let text = path.display().to_string();
    let path =
        text.strip_suffix(&format!(".{usual}.{usual}")).map_or(path, |stem| format!("{stem}.{usual}").into());
    // Digits after a dot, as in `take.2`, are part of the name; any other ending was typed on purpose.
    let typed = path.extension().map(|typed| typed.to_string_lossy().into_owned());
    let typed = typed.filter(|typed| typed.len() > 1 && !typed.chars().all(|c| c.is_ascii_digit()));
    let Some(typed) = typed else { return Some(PathBuf::from(format!("{}.{usual}", path.display()))) };
    let takes_others = matches!(
        purpose,
        Purpose::Share(&STORE) | Purpose::SaveSettings | Purpose::SaveEdits | Purpose::SavePath
    );
    (takes_others || endings.iter().any(|ending| typed.eq_ignore_ascii_case(ending))).then_some(path)
}

/// The destination of the path in the field; `None` if it cannot be taken.
pub(crate) fn typed_destination(typed: &TypedPath) -> Option<PathBuf> {
    named(typed.purpose, place(&typed.text)?)
}

/// A path that stays valid when the window is started from another folder.
pub(crate) fn lasting(path: PathBuf) -> PathBuf {
    std::path::absolute(&path).unwrap_or(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::rooms::charts::state::Study;
    use crate::ways_out::film::VIDEO;
    use crate::ways_out::page::PAGE;
    use crate::ways_out::pictures::PICTURE;
    use crate::ways_out::points::POINTS;
    use crate::ways_out::splats::GLB;

    #[test]
    fn a_name_without_an_ending_gets_that_of_its_purpose_and_none_of_another_kind_is_taken() {
        let [store, page, picture, splats, points] =
            [&STORE, &PAGE, &PICTURE, &GLB, &POINTS].map(Purpose::Share);
        let chart = Purpose::SaveChart(Study::Sweep);
        for (purpose, typed, expected) in [
            (store, "/a/capture", Some("/a/capture.ovl")),
            (store, "/a/take.2", Some("/a/take.2.ovl")),
            (store, "/a/capture.ovl", Some("/a/capture.ovl")),
            (store, "/a/clean.ovl.ovl", Some("/a/clean.ovl")),
            (Purpose::SaveSettings, "/a/mine", Some("/a/mine.toml")),
            (Purpose::Share(&VIDEO), "/a/b.m4v", Some("/a/b.m4v")),
            (Purpose::OpenFile, "/a/folder", Some("/a/folder")),
            (page, "/a/scene", Some("/a/scene.html")),
            (page, "/a/scene.HTM", Some("/a/scene.HTM")),
            (picture, "/a/view", Some("/a/view.png")),
            (picture, "/a/view.EXR", Some("/a/view.EXR")),
            (chart, "/a/sweep", Some("/a/sweep.pdf")),
            (chart, "/a/sweep.SVG", Some("/a/sweep.SVG")),
            (splats, "/a/scene.2", Some("/a/scene.2.glb")),
            // A store is not replaced by what is shared of it.
            (page, "/a/scene.ovl", None),
            (splats, "/a/b.ply", None),
            (points, "/a/b.ovl", None),
            (chart, "/a/b.jpg", None),
            (picture, "/a/view.jpg", None),
        ] {
            assert_eq!(named(purpose, typed.into()), expected.map(PathBuf::from), "{typed}");
        }
    }

    #[test]
    fn a_tilde_that_is_typed_is_the_own_folder() {
        let home = std::env::home_dir().unwrap();
        assert_eq!(place(" ~/films/a.mp4 "), Some(home.join("films/a.mp4")));
        assert_eq!(place("~"), Some(home.join("")));
        assert_eq!(place("/data/~x/~"), Some(PathBuf::from("/data/~x/~")));
        assert_eq!(place("~x"), Some(lasting("~x".into())));
        assert_eq!(place("  "), None);
    }
}
