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
    pub(crate) fn new(name: impl Into<String>, keys: &'static str, command: Command) -> Self {
        Self { name: name.into(), keys, command, why_not: None }
    }
}

/// The keys that show a camera, of the first nine.
const SHOW_KEYS: [&str; 9] = ["1", "2", "3", "4", "5", "6", "7", "8", "9"];

/// The keys that view from it.
const VIEW_KEYS: [&str; 9] =
    ["Shift+1", "Shift+2", "Shift+3", "Shift+4", "Shift+5", "Shift+6", "Shift+7", "Shift+8", "Shift+9"];

/// All entries.
pub(crate) fn entries(state: &State) -> Vec<PaletteEntry> {
    // A store was made by thresholds that cannot be changed any more.
    let turns = state.has_thresholds();
    let mut entries = view_entries(state);
    for (name, keys, command) in fixed_commands(&state.doc.edits) {
        let changes_thresholds = matches!(
            command,
            Command::Undo
                | Command::Redo
                | Command::Settings(SettingsCommand::ResetAll | SettingsCommand::Switch)
        );
        if turns || !changes_thresholds {
            entries.push(PaletteEntry::new(name, keys, command));
        }
    }
    let compare = Command::Reading(ReadingCommand::Compare(true));
    let why_not = state.why_no_readings();
    entries.push(PaletteEntry { why_not, ..PaletteEntry::new("Compare readings", "", compare) });
    entries.extend(choices(state));
    entries.extend(settings(turns));
    entries
}

/// Entries that are there whatever is open.
fn fixed_commands(edits: &SceneEdits) -> [(&'static str, &'static str, Command); 52] {
    let ask = |purpose: Purpose| Command::File(FileCommand::AskPath(purpose));
    let help = |page: HelpPage| Command::Window(WindowCommand::Help(Some(page)));
    let tool =
        |tool: EditTool| Command::Edit(EditCommand::Tools(EditTools { tool: Some(tool), ..edits.tools }));
    [
        ("Open folder", "", ask(Purpose::OpenFolder)),
        ("Open file", "Ctrl+O", ask(Purpose::OpenFile)),
        ("Save settings", "", ask(Purpose::SaveSettings)),
        ("Load settings", "", ask(Purpose::LoadSettings)),
        ("Save edits", "", ask(Purpose::SaveEdits)),
        ("Copy as command line", "", Command::File(FileCommand::CopyCommandLine)),
        ("Save session", "Ctrl+S", ask(Purpose::SaveSession)),
        ("Open edits", "", ask(Purpose::LoadEdits)),
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
        ("Guide", "", help(HelpPage::Guide(0))),
        ("What opens", "", help(HelpPage::Sources)),
        ("Keyboard and mouse shortcuts", "?", help(HelpPage::Shortcuts)),
        ("Log", "", help(HelpPage::Log)),
        ("About Overlook and its version", "", help(HelpPage::About)),
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
    let mut add = |name: String, keys: &'static str, command: Command| {
        entries.push(PaletteEntry::new(name, keys, command));
    };
    for (view, name, _) in DockView::ALL.into_iter().filter(|(view, ..)| state.has_use_of(*view)) {
        add(format!("Open view: {name}"), "", Command::Window(WindowCommand::OpenView(view)));
    }
    for (overlay, name, _) in state.overlays() {
        let look = SourceLook { overlay, ..state.source };
        add(format!("Source shows: {name}"), "", Command::Source(SourceCommand::Look(look)));
    }
    for (color_by, name, _) in state.live_colors() {
        let look = ViewCommand::look(&state.live, |live| live.color_by = color_by);
        add(format!("Live view shows: {name}"), "", Command::View(look));
    }
    for (holes, name, _) in HoleDisplay::ALL {
        add(format!("Holes: {name}"), "H", Command::View(ViewCommand::Holes(holes)));
    }
    for (name, _, change) in PRESETS.into_iter().filter(|_| state.has_thresholds()) {
        let settings = Box::new(changed(change));
        add(format!("Preset: {name}"), "", Command::Settings(SettingsCommand::Preset(settings)));
    }
    for path in &state.recent {
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        let open = FileCommand::Open(Opening::Path(path.clone()));
        add(format!("Open recent: {name}"), "", Command::File(open));
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
        let [show, view] = [SHOW_KEYS, VIEW_KEYS].map(|keys| keys.get(index).copied().unwrap_or_default());
        let leave_out = EditCommand::LeaveOut(vec![index]);
        add(format!("Show camera '{}'", camera.name), show, Command::Source(SourceCommand::Camera(index)));
        add(format!("Leave out camera '{}'", camera.name), "", Command::Edit(leave_out));
        add(format!("View from camera '{}'", camera.name), view, Command::View(ViewCommand::JumpTo(index)));
    }
    entries
}

/// Every setting, and every value that one of them can be given by name; `turns` where thresholds can be changed.
fn settings(turns: bool) -> Vec<PaletteEntry> {
    let mut entries = Vec::new();
    let mut add =
        |name: String, command| entries.push(PaletteEntry::new(name, "", Command::Settings(command)));
    for field in Settings::fields().filter(|field| turns || field.path.starts_with("render.")) {
        let path = field.path;
        let setting = model::setting_names::name(path);
        add(format!("Setting: {setting}"), SettingsCommand::Find(Some(path)));
        let values: Vec<(String, toml::Value)> = match field.kind {
            ValueKind::Choice(names) => {
                names.iter().map(|(value, _)| (choice(path, value), (*value).into())).collect()
            }
            ValueKind::Switch => vec![("on".to_owned(), true.into()), ("off".to_owned(), false.into())],
            // Numbers are turned on their sliders.
            ValueKind::Number { .. } | ValueKind::Integer { .. } => Vec::new(),
        };
        for (name, value) in values {
            add(format!("{setting}: {name}"), SettingsCommand::Set { path, value });
        }
    }
    entries
}

/// What concerns the window, ways out, and the live view.
fn view_entries(state: &State) -> Vec<PaletteEntry> {
    let mut entries = Vec::new();
    let mut add = |name: String, keys: &'static str, command: Command| {
        entries.push(PaletteEntry::new(name, keys, command));
    };
    for (workspace, name, _) in Workspace::ALL {
        let show = WindowCommand::Workspace(workspace);
        add(format!("Workspace: {name}"), "Ctrl+1 – 4", Command::Window(show));
    }
    let show_or_hide = |hides: bool| if hides { "Show" } else { "Hide" };
    for (area, name, keys) in Area::ALL {
        let hides = !state.look.shows(area);
        let show = WindowCommand::ShowArea(area, hides);
        add(format!("{} the {}", show_or_hide(hides), name.to_lowercase()), keys, Command::Window(show));
    }
    let hides = state.look.hides_totals;
    add(
        format!("{} the summary bar", show_or_hide(hides)),
        "",
        Command::Window(WindowCommand::ShowTotals(hides)),
    );
    add("Share…".to_owned(), "Ctrl+E", Command::Share(ShareCommand::Open(None)));
    let copy = Command::Share(ShareCommand::CopyFigure(None));
    add("Copy figure to the clipboard".to_owned(), "Ctrl+Shift+F", copy);
    for study in Study::CHARTS {
        for (verb, command) in ["Copy", "Save"].into_iter().zip(chart_commands(study)) {
            add(format!("{verb} the {}", study.chart_name()), "", command);
        }
    }
    for (way, row) in WAYS {
        add(format!("Share: {}", row.name), "", Command::Share(ShareCommand::Open(Some(way))));
    }
    for (name, keys, command) in view_commands(state) {
        add(name.to_owned(), keys, command);
    }
    for (name, keys, axis) in [
        ("+X", "Alt+X", DVec3::NEG_X),
        ("−X", "Alt+Shift+X", DVec3::X),
        ("+Y", "Alt+Y", DVec3::NEG_Y),
        ("−Y", "Alt+Shift+Y", DVec3::Y),
        ("+Z", "Alt+Z", DVec3::NEG_Z),
        ("−Z", "Alt+Shift+Z", DVec3::Z),
    ] {
        add(format!("View from {name}"), keys, Command::View(ViewCommand::LookAlong(axis)));
    }
    for (up, name, _) in UP_DIRECTIONS {
        add(format!("Up: {name}"), "", Command::View(ViewCommand::Up(up)));
    }
    for (guide, name, _) in FrameGuide::ALL {
        let look = ViewCommand::look(&state.live, |live| live.guides.frame = guide);
        add(format!("Frame guide: {name}"), "", Command::View(look));
    }
    let kept = |command: KeptViewCommand| Command::View(ViewCommand::Kept(command));
    add("Keep view".to_owned(), "Ctrl+D", kept(KeptViewCommand::Keep));
    for (index, view) in state.doc.kept_views.iter().enumerate() {
        add(format!("Go to {}", view.name), "", kept(KeptViewCommand::GoTo(index)));
    }
    for (index, camera) in state.doc.scene.iter().flat_map(|scene| scene.cameras.iter().enumerate()) {
        let look = ViewCommand::look(&state.live, |live| live.cameras.solo = Some(index));
        add(format!("Solo camera {}", camera.name), "", Command::View(look));
    }
    entries
}

/// Entries of the views that are there whatever is open.
fn view_commands(state: &State) -> [(&'static str, &'static str, Command); 17] {
    let look = |change: fn(&mut _)| Command::View(ViewCommand::look(&state.live, change));
    let timeline = &state.timeline;
    let time = |change: fn(&mut Timeline)| Command::Time(TimeCommand::change(timeline, change));
    let ask = |purpose: Purpose| Command::File(FileCommand::AskPath(purpose));
    [
        ("Maximize or restore a view", "Shift+Space", Command::Window(WindowCommand::Maximize(None))),
        ("Full screen", "F11", Command::Window(WindowCommand::FullScreen)),
        ("Copy view", "Ctrl+C", Command::View(ViewCommand::Copy)),
        ("Paste view", "Ctrl+V", Command::View(ViewCommand::Paste)),
        ("Measure distance", "M", look(|live| live.ruler.measure(true))),
        ("Show all cameras' samples", "", look(|live| live.cameras = ShownCameras::default())),
        ("Loop over all frames", "Shift+I", time(|timeline| timeline.range = None)),
        ("Mark this frame, or take its marker away", "Shift+M", time(Timeline::toggle_marker)),
        ("Next marker", "Ctrl+Right", Command::Time(TimeCommand::Frame(timeline.marker(true)))),
        ("Previous marker", "Ctrl+Left", Command::Time(TimeCommand::Frame(timeline.marker(false)))),
        ("Play back and forth", "", time(|timeline| timeline.ping_pong = true)),
        ("Play around the ends", "", time(|timeline| timeline.ping_pong = false)),
        ("Copy the address of this view", "Ctrl+L", Command::View(ViewCommand::CopyAddress)),
        ("Reset colors", "", Command::Display(Display::default())),
        ("Save camera path", "", ask(Purpose::SavePath)),
        ("Open camera path", "", ask(Purpose::LoadPath)),
        ("Compare with pictures of another program", "", ask(Purpose::OpenPictures)),
    ]
}
