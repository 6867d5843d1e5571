//! What there is to do with the views and the live view's camera, for the command palette.

use glam::DVec3;

use crate::app::model::{Command, State};
use crate::app::rooms::charts::model::Study;
use crate::app::rooms::charts::ui::chart_commands;
use crate::app::rooms::colors::model::Display;
use crate::app::rooms::files::model::{FileCommand, Purpose};
use crate::app::rooms::frame::model::{Area, WindowCommand, Workspace};
use crate::app::rooms::live::model::{FrameGuide, KeptViewCommand, ShownCameras, UP_DIRECTIONS, ViewCommand};
use crate::app::rooms::share::model::{ShareCommand, ShareWay};
use crate::app::rooms::timeline::model::{TimeCommand, Timeline};

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
    for study in Study::ALL {
        let [copy, save] = chart_commands(study);
        entries.push((format!("Copy the {}", study.chart_name()), "", copy));
        entries.push((format!("Save the {}", study.chart_name()), "", save));
    }
    for (way, name, _) in ShareWay::ALL {
        let keys = if way == ShareWay::Store { "Ctrl+S" } else { "" };
        entries.push((format!("Share: {name}"), keys, Command::Share(ShareCommand::Open(Some(way)))));
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
