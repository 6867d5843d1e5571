//! The changes that undo takes back, by their names.

use super::setting_names;
use crate::app::model::state::State;
use overlook_engine::settings::Settings;

/// Changes that are listed.
const LISTED: usize = 10;

impl State {
    /// Whether there is something to undo, or to redo.
    pub(crate) fn can_undo(&self, undo: bool) -> bool {
        let history = &self.inspector.history;
        let settings = if undo { history.can_undo() } else { history.can_redo() };
        settings || self.doc.edits.can(undo) || self.doc.path.can(undo)
    }

    /// What undo takes back, or redo makes again, in the order in which repeating it does: the next changes by their names.
    pub(crate) fn undo_list(&self, undo: bool) -> Vec<String> {
        let settings = self.inspector.history.changes(undo, &self.settings).map(named);
        let edits = self.doc.edits.named_changes(undo);
        edits.chain(self.doc.path.named_changes(undo)).chain(settings).take(LISTED).collect()
    }
}

/// A change of settings in a line.
fn named([before, after]: [&Settings; 2]) -> String {
    let changes = setting_names::changes(before, after);
    match &changes[..] {
        [] => "Settings".to_owned(),
        [one] => one.clone(),
        [first, others @ ..] => format!("{first}, and {} more", others.len()),
    }
}
