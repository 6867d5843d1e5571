//! Everything there is to do, for the command palette.

use glam::DVec3;

use crate::app::model::command::{
    ChartCommand, EditCommand, EditTool, EditTools, FileCommand, KeptViewCommand, Opening, PathCommand,
    PixelCommand, ReadingCommand, SettingsCommand, SourceCommand, ViewCommand, WindowCommand,
};
use crate::app::model::look::{Display, FrameGuide, ShownCameras, UP_DIRECTIONS};
use crate::app::model::picture::HoleDisplay;
use crate::app::model::purpose::{FigureOf, Purpose, ShareCommand, Table, TableForm};
use crate::app::model::setting_names::choice;
use crate::app::model::window::{Area, DockView, HelpPage, Workspace};
use crate::app::model::{self, Command, State};
use crate::app::rooms::charts::state::Study;
use crate::app::rooms::charts::ui::parts::chart_commands;
use crate::app::rooms::edits::state::SceneEdits;
use crate::app::rooms::settings::{PRESETS, changed};
use crate::app::rooms::source::SourceLook;
use crate::app::rooms::timeline::{TimeCommand, Timeline};
use crate::ways_out::WAYS;
use overlook_engine::demo::SCENES;
use overlook_engine::edits::Action;
use overlook_engine::settings::{Settings, ValueKind};

/// Something to do: its name, its keys, and the wish.
pub(crate) struct PaletteEntry {
    pub name: String,
    pub keys: &'static str,
    pub command: Command,
    /// Why it cannot be done now; `None` if it can.
    pub why_not: Option<String>,
}

impl PaletteEntry {
    pub(crate) fn new(name: String, keys: &'static str, command: Command) -> Self {
        Self { name, keys, command, why_not: None }
    }
}

/// The keys that show a camera and view from it, of the first nine.
const CAMERA_KEYS: [[&str; 2]; 9] = [
    ["1", "Shift+1"],
    ["2", "Shift+2"],
    ["3", "Shift+3"],
    ["4", "Shift+4"],
    ["5", "Shift+5"],
    ["6", "Shift+6"],
    ["7", "Shift+7"],
    ["8", "Shift+8"],
    ["9", "Shift+9"],
];

/// All entries.
pub(crate) fn entries(state: &State) -> Vec<PaletteEntry> {
    let view_entries = view_entries(state).into_iter();
    let mut entries: Vec<_> =
        view_entries.map(|(name, keys, command)| PaletteEntry::new(name, keys, command)).collect();
    // A store was made by thresholds that cannot be changed any more.
    let turns = state.has_thresholds();
    let mut add = |name: String, keys: &'static str, command: Command| {
        entries.push(PaletteEntry::new(name, keys, command));
    };
    for (name, keys, command) in fixed_commands(&state.doc.edits) {
        let changes_thresholds = matches!(
            command,
            Command::Undo
                | Command::Redo
                | Command::Settings(SettingsCommand::ResetAll | SettingsCommand::Switch)
        );
        if turns || !changes_thresholds {
            add(name.to_owned(), keys, command);
        }
    }
    entries.push(PaletteEntry {
        why_not: state.why_no_readings(),
        ..PaletteEntry::new(
            "Compare readings".to_owned(),
            "",
            Command::Reading(ReadingCommand::Compare(true)),
        )
    });
    entries.extend(choices(state));
    entries.extend(settings(turns));
    entries
}

/// Entries that are there whatever is open.
fn fixed_commands(edits: &SceneEdits) -> [(&'static str, &'static str, Command); 52] {
    let tool =
        |tool: EditTool| Command::Edit(EditCommand::Tools(EditTools { tool: Some(tool), ..edits.tools }));
    [
        ("Open folder", "", Command::File(FileCommand::AskPath(Purpose::OpenFolder))),
        ("Open file", "Ctrl+O", Command::File(FileCommand::AskPath(Purpose::OpenFile))),
        ("Save settings", "", Command::File(FileCommand::AskPath(Purpose::SaveSettings))),
        ("Load settings", "", Command::File(FileCommand::AskPath(Purpose::LoadSettings))),
        ("Save edits", "", Command::File(FileCommand::AskPath(Purpose::SaveEdits))),
        ("Copy as command line", "", Command::File(FileCommand::CopyCommandLine)),
        ("Save session", "Ctrl+S", Command::File(FileCommand::AskPath(Purpose::SaveSession))),
        ("Open edits", "", Command::File(FileCommand::AskPath(Purpose::LoadEdits))),
        ("Edit: delete selection", "Delete", Command::Edit(EditCommand::Act(Action::Delete))),
        ("Edit: keep only the selection", "", Command::Edit(EditCommand::Act(Action::KeepOnly))),
        ("Edit: select by rectangle", "R", tool(EditTool::Rectangle)),
        ("Edit: select by lasso", "L", tool(EditTool::Lasso)),
        ("Edit: select by brush", "B", tool(EditTool::Brush)),
        ("Edit: select the same surface", "T", tool(EditTool::Surface)),
        ("Edit: select the same color", "C", tool(EditTool::Color)),
        ("Edit: mask pixels of a camera", "Shift+B", tool(EditTool::Mask)),
        ("Edit: grow the selection", "G", Command::Edit(EditCommand::Reshape(edits.grown(true)))),
        ("Edit: shrink the selection", "Shift+G", Command::Edit(EditCommand::Reshape(edits.grown(false)))),
        ("Edit: invert the selection", "Ctrl+I", Command::Edit(EditCommand::Reshape(edits.inverted()))),
        ("Edit: select nothing", "", Command::Edit(EditCommand::SelectNothing)),
        ("Copy picture", "", Command::Share(ShareCommand::CopyPicture(FigureOf::Live))),
        ("Copy explanation", "Ctrl+Shift+C", Command::Pixel(PixelCommand::CopyExplanation)),
        ("Undo", "Ctrl+Z", Command::Undo),
        ("Redo", "Ctrl+Y", Command::Redo),
        ("Reset all settings", "", Command::Settings(SettingsCommand::ResetAll)),
        ("Switch between settings A and B", "", Command::Settings(SettingsCommand::Switch)),
        ("Play or pause", "Space", Command::Time(TimeCommand::TogglePlay)),
        ("Reset view to start", "Home", Command::View(ViewCommand::Home)),
        ("Back to the view before", "Alt+Left", Command::View(ViewCommand::Back)),
        ("Forward to the next view", "Alt+Right", Command::View(ViewCommand::Forward)),
        ("Center view on the selection, or the selected pixel", "F", Command::View(ViewCommand::FramePoint)),
        ("Add key to the camera path", "K", Command::Path(PathCommand::AddKey)),
        ("Camera path: turntable around the pivot", "", Command::Path(PathCommand::TurnAround)),
        ("Recompute the whole capture", "", Command::Recompute),
        ("Run a sweep", "", Command::Chart(ChartCommand::Ask(Some(Study::Sweep)))),
        ("Run a stress test", "", Command::Chart(ChartCommand::Ask(Some(Study::Stress)))),
        ("Tune settings", "", Command::Chart(ChartCommand::Ask(Some(Study::Tuning)))),
        ("Rank cameras: find a needless camera", "", Command::Chart(ChartCommand::Study(Study::Ranking))),
        ("Cancel", "Esc", Command::Cancel),
        ("Light theme", "", Command::Window(WindowCommand::Dark(false))),
        ("Dark theme", "", Command::Window(WindowCommand::Dark(true))),
        ("Reset layout", "", Command::Window(WindowCommand::ResetLayout)),
        ("Guide", "", Command::Window(WindowCommand::Help(Some(HelpPage::Guide(0))))),
        ("What opens", "", Command::Window(WindowCommand::Help(Some(HelpPage::Sources)))),
        (
            "Keyboard and mouse shortcuts",
            "?",
            Command::Window(WindowCommand::Help(Some(HelpPage::Shortcuts))),
        ),
        ("Log", "", Command::Window(WindowCommand::Help(Some(HelpPage::Log)))),
        ("About Overlook and its version", "", Command::Window(WindowCommand::Help(Some(HelpPage::About)))),
        ("Interface size: larger", "Ctrl++", Command::Window(WindowCommand::InterfaceSize(1))),
        ("Interface size: smaller", "Ctrl+−", Command::Window(WindowCommand::InterfaceSize(-1))),
        ("Interface size: normal", "Ctrl+0", Command::Window(WindowCommand::InterfaceSize(0))),
        ("Forget recent files", "", Command::File(FileCommand::ForgetRecent)),
        ("Close the introduction", "", Command::File(FileCommand::Introduced)),
    ]
}

/// What is chosen among views, overlays, presets, tables, scenes, files and cameras.
fn choices(state: &State) -> Vec<PaletteEntry> {
    let mut entries = Vec::new();
    let turns = state.has_thresholds();
    let mut add = |name: String, keys: &'static str, command: Command| {
        entries.push(PaletteEntry::new(name, keys, command));
    };
    for (view, name, _) in DockView::ALL.into_iter().filter(|(view, ..)| state.has_use_of(*view)) {
        add(format!("Open view: {name}"), "", Command::Window(WindowCommand::OpenView(view)));
    }
    for (overlay, name, _) in state.overlays() {
        add(
            format!("Source shows: {name}"),
            "",
            Command::Source(SourceCommand::Look(SourceLook { overlay, ..state.source })),
        );
    }
    for (color_by, name, _) in state.live_colors() {
        add(
            format!("Live view shows: {name}"),
            "",
            Command::View(ViewCommand::look(&state.live, |live| live.color_by = color_by)),
        );
    }
    for (holes, name, _) in HoleDisplay::ALL {
        add(format!("Holes: {name}"), "H", Command::View(ViewCommand::Holes(holes)));
    }
    for (name, _, change) in PRESETS.into_iter().filter(|_| turns) {
        let settings = Box::new(changed(change));
        add(format!("Preset: {name}"), "", Command::Settings(SettingsCommand::Preset(settings)));
    }
    for path in &state.recent {
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        add(
            format!("Open recent: {name}"),
            "",
            Command::File(FileCommand::Open(Opening::Path(path.clone()))),
        );
    }
    for (table, name, _) in Table::ALL {
        for (form, form_name, _) in TableForm::ALL {
            add(format!("Copy the {name} as {form_name}"), "", Command::CopyTable(table, form));
        }
    }
    add("Demo: room, pruned".to_owned(), "", Command::File(FileCommand::Open(Opening::Room)));
    for (name, _) in SCENES {
        add(format!("Demo: {name}"), "", Command::File(FileCommand::Open(Opening::Demo((*name).to_owned()))));
    }
    for (index, camera) in state.doc.scene.iter().flat_map(|scene| scene.cameras.iter().enumerate()) {
        let [show, view] = CAMERA_KEYS.get(index).copied().unwrap_or_default();
        add(format!("Show camera '{}'", camera.name), show, Command::Source(SourceCommand::Camera(index)));
        add(
            format!("Leave out camera '{}'", camera.name),
            "",
            Command::Edit(EditCommand::LeaveOut(vec![index])),
        );
        add(format!("View from camera '{}'", camera.name), view, Command::View(ViewCommand::JumpTo(index)));
    }
    entries
}

/// Every setting, and every value that one of them can be given by name; `turns` where thresholds can be changed.
fn settings(turns: bool) -> Vec<PaletteEntry> {
    let mut entries = Vec::new();
    let mut add = |name: String, keys: &'static str, command: Command| {
        entries.push(PaletteEntry::new(name, keys, command));
    };
    for field in Settings::fields().filter(|field| turns || field.path.starts_with("render.")) {
        let setting = model::setting_names::name(field.path);
        add(format!("Setting: {setting}"), "", Command::Settings(SettingsCommand::Find(Some(field.path))));
        let values: Vec<(String, toml::Value)> = match field.kind {
            ValueKind::Choice(names) => {
                names.iter().map(|(value, _)| (choice(field.path, value), (*value).into())).collect()
            }
            ValueKind::Switch => vec![("on".to_owned(), true.into()), ("off".to_owned(), false.into())],
            // Numbers are turned on their sliders.
            ValueKind::Number { .. } | ValueKind::Integer { .. } => Vec::new(),
        };
        for (name, value) in values {
            add(
                format!("{setting}: {name}"),
                "",
                Command::Settings(SettingsCommand::Set { path: field.path, value }),
            );
        }
    }
    entries
}

/// Names, keys and commands.
pub(crate) fn view_entries(state: &State) -> Vec<(String, &'static str, Command)> {
    let mut entries: Vec<(String, &'static str, Command)> = Workspace::ALL
        .into_iter()
        .map(|(workspace, name, _)| {
            (format!("Workspace: {name}"), "Ctrl+1 – 4", Command::Window(WindowCommand::Workspace(workspace)))
        })
        .collect();
    for (area, name, keys) in Area::ALL {
        let shown = state.look.shows(area);
        let verb = if shown { "Hide" } else { "Show" };
        entries.push((
            format!("{verb} the {}", name.to_lowercase()),
            keys,
            Command::Window(WindowCommand::ShowArea(area, !shown)),
        ));
    }
    let hides = state.look.hides_totals;
    let verb = if hides { "Show" } else { "Hide" };
    entries.push((format!("{verb} the summary bar"), "", Command::Window(WindowCommand::ShowTotals(hides))));
    entries.push(("Share…".to_owned(), "Ctrl+E", Command::Share(ShareCommand::Open(None))));
    let copy = Command::Share(ShareCommand::CopyFigure(None));
    entries.push(("Copy figure to the clipboard".to_owned(), "Ctrl+Shift+F", copy));
    for study in Study::CHARTS {
        let [copy, save] = chart_commands(study);
        entries.push((format!("Copy the {}", study.chart_name()), "", copy));
        entries.push((format!("Save the {}", study.chart_name()), "", save));
    }
    for (way, row) in WAYS {
        entries.push((format!("Share: {}", row.name), "", Command::Share(ShareCommand::Open(Some(way)))));
    }
    for (name, keys, command) in view_commands(state) {
        entries.push((name.to_owned(), keys, command));
    }
    for (name, keys, axis) in [
        ("+X", "Alt+X", DVec3::NEG_X),
        ("−X", "Alt+Shift+X", DVec3::X),
        ("+Y", "Alt+Y", DVec3::NEG_Y),
        ("−Y", "Alt+Shift+Y", DVec3::Y),
        ("+Z", "Alt+Z", DVec3::NEG_Z),
        ("−Z", "Alt+Shift+Z", DVec3::Z),
    ] {
        let command = Command::View(ViewCommand::LookAlong(axis));
        entries.push((format!("View from {name}"), keys, command));
    }
    for (up, name, _) in UP_DIRECTIONS {
        entries.push((format!("Up: {name}"), "", Command::View(ViewCommand::Up(up))));
    }
    for (guide, name, _) in FrameGuide::ALL {
        let command = ViewCommand::look(&state.live, |live| live.guides.frame = guide);
        entries.push((format!("Frame guide: {name}"), "", Command::View(command)));
    }
    entries.push(("Keep view".to_owned(), "Ctrl+D", Command::View(ViewCommand::Kept(KeptViewCommand::Keep))));
    let kept = state.doc.kept_views.iter().enumerate();
    entries.extend(kept.map(|(index, kept)| {
        (format!("Go to {}", kept.name), "", Command::View(ViewCommand::Kept(KeptViewCommand::GoTo(index))))
    }));
    let cameras = state.doc.scene.iter().flat_map(|scene| scene.cameras.iter().enumerate());
    entries.extend(cameras.map(|(index, camera)| {
        let command = Command::View(ViewCommand::look(&state.live, |live| live.cameras.solo = Some(index)));
        (format!("Solo camera {}", camera.name), "", command)
    }));
    entries
}

/// Entries that are there whatever is open.
fn view_commands(state: &State) -> [(&'static str, &'static str, Command); 17] {
    let timeline = &state.timeline;
    let time = |change: fn(&mut Timeline)| Command::Time(TimeCommand::change(timeline, change));
    [
        ("Maximize or restore a view", "Shift+Space", Command::Window(WindowCommand::Maximize(None))),
        ("Full screen", "F11", Command::Window(WindowCommand::FullScreen)),
        ("Copy view", "Ctrl+C", Command::View(ViewCommand::Copy)),
        ("Paste view", "Ctrl+V", Command::View(ViewCommand::Paste)),
        (
            "Measure distance",
            "M",
            Command::View(ViewCommand::look(&state.live, |live| live.ruler.measure(true))),
        ),
        (
            "Show all cameras' samples",
            "",
            Command::View(ViewCommand::look(&state.live, |live| live.cameras = ShownCameras::default())),
        ),
        ("Loop over all frames", "Shift+I", time(|timeline| timeline.range = None)),
        ("Mark this frame, or take its marker away", "Shift+M", time(Timeline::toggle_marker)),
        ("Next marker", "Ctrl+Right", Command::Time(TimeCommand::Frame(timeline.marker(true)))),
        ("Previous marker", "Ctrl+Left", Command::Time(TimeCommand::Frame(timeline.marker(false)))),
        ("Play back and forth", "", time(|timeline| timeline.ping_pong = true)),
        ("Play around the ends", "", time(|timeline| timeline.ping_pong = false)),
        ("Copy the address of this view", "Ctrl+L", Command::View(ViewCommand::CopyAddress)),
        ("Reset colors", "", Command::Display(Display::default())),
        ("Save camera path", "", Command::File(FileCommand::AskPath(Purpose::SavePath))),
        ("Open camera path", "", Command::File(FileCommand::AskPath(Purpose::LoadPath))),
        (
            "Compare with pictures of another program",
            "",
            Command::File(FileCommand::AskPath(Purpose::OpenPictures)),
        ),
    ]
}
