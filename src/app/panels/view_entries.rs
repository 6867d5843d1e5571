//! What there is to do with the views and the live view's camera, for the command palette.

use crate::app::model::{Area, Command, State, Workspace};

/// Names, keys and commands.
pub(super) fn view_entries(state: &State) -> Vec<(String, &'static str, Command)> {
    let mut entries: Vec<(String, &'static str, Command)> = Workspace::ALL
        .into_iter()
        .map(|(workspace, name, _)| {
            (format!("Workspace: {name}"), "Ctrl+1 – 4", Command::Workspace(workspace))
        })
        .collect();
    for (area, name, keys) in Area::ALL {
        let shown = state.look.shows(area);
        let verb = if shown { "Hide" } else { "Show" };
        entries.push((format!("{verb} the {}", name.to_lowercase()), keys, Command::ShowArea(area, !shown)));
    }
    let hides = state.look.hides_totals;
    let verb = if hides { "Show" } else { "Hide" };
    entries.push((format!("{verb} the figures above the views"), "", Command::ShowTotals(hides)));
    for (name, keys, command) in [
        ("Maximize or restore a view", "Shift+Space", Command::Maximize(None)),
        ("Full screen", "F11", Command::FullScreen),
    ] {
        entries.push((name.to_owned(), keys, command));
    }
    entries
}
