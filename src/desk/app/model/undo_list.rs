//! What the window can take back, and what that is called.

use std::time::Instant;

use crate::app::model::setting_names::changes;
use crate::app::model::state::State;
use crate::app::model::undo::{Part, Undoable};
use crate::app::rooms::edits::state::named_change;

/// Changes that are listed.
const LISTED: usize = 10;

impl State {
    /// What can be taken back of the settings, as they are.
    pub(crate) fn undoable_settings(&self) -> Undoable {
        Undoable::Settings(self.inspector.history.slot, Box::new(self.settings.clone()))
    }

    /// What is now of the kind of a step.
    pub(crate) fn now(&self, step: &Undoable) -> Undoable {
        match step {
            Undoable::Settings(..) => self.undoable_settings(),
            Undoable::Edits(_) => Undoable::Edits(self.doc.edits.list.clone()),
            Undoable::Path(_) => Undoable::Path(self.doc.path.shape()),
        }
    }

    /// Notes what something was, if it was changed.
    pub(crate) fn note_change(&mut self, before: Undoable, part: Option<Part>) {
        if self.now(&before) != before {
            self.inspector.history.record(before, part, Instant::now());
        }
    }

    /// Whether there is something to undo, or to redo.
    pub(crate) fn can_undo(&self, undo: bool) -> bool {
        self.inspector.history.steps(undo).next().is_some()
    }

    /// Whether undo (or redo) would change the edits next.
    pub(crate) fn would_step_edits(&self, undo: bool) -> bool {
        matches!(self.inspector.history.steps(undo).next(), Some(Undoable::Edits(_)))
    }

    /// What undo takes back, or redo makes again, in the order in which repeating it does: the next changes by their names.
    pub(crate) fn undo_list(&self, undo: bool) -> Vec<String> {
        let steps: Vec<&Undoable> = self.inspector.history.steps(undo).take(LISTED).collect();
        let nth_named = |(nth, step): (usize, &&Undoable)| {
            let is_alike =
                |other: &&&Undoable| std::mem::discriminant(**other) == std::mem::discriminant(*step);
            let nearer = steps[..nth].iter().rev().find(is_alike);
            let nearer = nearer.map_or_else(|| self.now(step), |nearer| Undoable::clone(nearer));
            named(if undo { [step, &nearer] } else { [&nearer, step] })
        };
        steps.iter().enumerate().map(nth_named).collect()
    }
}

/// The change between two states, in a line.
fn named([before, after]: [&Undoable; 2]) -> String {
    match (before, after) {
        (Undoable::Edits(before), Undoable::Edits(after)) => named_change([before, after]),
        (Undoable::Path(before), Undoable::Path(after)) => before.named_change_to(after),
        (Undoable::Settings(_, before), Undoable::Settings(_, after)) => match &changes(before, after)[..] {
            [] => "Settings".to_owned(),
            [one] => one.clone(),
            [first, others @ ..] => format!("{first}, and {} more", others.len()),
        },
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use overlook_engine::edits::{Action, Edit, Region};

    #[test]
    fn changes_of_edits_have_names_and_the_letters_of_one_name_are_one_step() {
        let mut state = State::default();
        let mut change = |part: Option<Part>, change: &dyn Fn(&mut Vec<Edit>)| {
            let before = Undoable::Edits(state.doc.edits.list.clone());
            change(&mut state.doc.edits.list.edits);
            state.note_change(before, part);
        };
        for name in ["Delete sphere", "Mask left"] {
            change(None, &|edits| edits.push(Edit::new(name, Action::Delete, Region::Doubtful)));
        }
        change(None, &|edits| edits[1].is_on = false);
        change(None, &|edits| edits.swap(0, 1));
        for name in ["m", "ma", "mask"] {
            change(Some(Part::EditName(0)), &|edits| name.clone_into(&mut edits[0].name));
        }
        change(None, &|edits| drop(edits.remove(1)));
        change(None, &|edits| edits.clear());
        let expected = [
            "Remove \"mask\"",
            "Remove \"Delete sphere\"",
            "Name \"mask\"",
            "Change the order of edits",
            "Switch \"Mask left\" off",
            "Mask left",
            "Delete sphere",
        ];
        assert_eq!(state.undo_list(true), expected);
    }
}
