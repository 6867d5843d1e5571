//! What can be taken back, in the order in which it was changed: settings, edits and the camera path; and two settings side by side.

use std::time::{Duration, Instant};

use crate::app::model::state::State;
use crate::app::rooms::edits::model::edits::named_change;
use crate::app::rooms::path::model::PathShape;
use crate::app::rooms::settings::model::setting_names;
use overlook_engine::edits::EditList;
use overlook_engine::settings::Settings;

/// Numbers of one setting that follow each other faster than this are one change: a slider in motion.
const ONE_CHANGE: Duration = Duration::from_millis(700);

/// Changes that are remembered.
const STEPS: usize = 200;

/// Changes that are listed.
const LISTED: usize = 10;

/// Which of two settings is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(crate) enum SettingsSlot {
    /// The first.
    #[default]
    A,
    /// The second.
    B,
}

/// Something as it was before a change.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Undoable {
    /// The settings of a slot.
    Settings(SettingsSlot, Box<Settings>),
    Edits(EditList),
    Path(PathShape),
}

impl Undoable {
    /// Whether undo reaches it while the settings of a slot are on.
    fn is_reached(&self, slot: SettingsSlot) -> bool {
        !matches!(self, Self::Settings(of, _) if *of != slot)
    }

    /// The change between two states, in a line.
    fn named([before, after]: [&Self; 2]) -> String {
        match (before, after) {
            (Self::Edits(before), Self::Edits(after)) => named_change([before, after]),
            (Self::Path(before), Self::Path(after)) => before.named_change_to(after),
            (Self::Settings(_, before), Self::Settings(_, after)) => {
                match &setting_names::changes(before, after)[..] {
                    [] => "Settings".to_owned(),
                    [one] => one.clone(),
                    [first, others @ ..] => format!("{first}, and {} more", others.len()),
                }
            }
            _ => String::new(),
        }
    }
}

/// What is changed bit by bit: its changes are one step as long as nothing else is changed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Part {
    /// A number among the settings, by its path; as a step of its own after a while.
    Setting(&'static str),
    /// The name of an edit, by its index.
    EditName(usize),
    /// A key of the camera path, by its index.
    PathKey(usize),
}

/// What was changed and taken back, and the settings that are not on.
#[derive(Default)]
pub(crate) struct History {
    past: Vec<Undoable>,
    future: Vec<Undoable>,
    /// What was changed last and when, if it is changed bit by bit.
    last: Option<(Part, Instant)>,
    /// Which of two settings is on.
    pub slot: SettingsSlot,
    /// The settings that are not on; `None` while both are the same.
    pub other: Option<Settings>,
}

impl History {
    /// Notes what something was before a change of a part of it, or of all of it.
    pub(crate) fn record(&mut self, before: Undoable, part: Option<Part>, now: Instant) {
        let goes_on = self.last.is_some_and(|(last, at)| {
            let is_soon = now.duration_since(at) < ONE_CHANGE;
            Some(last) == part && (is_soon || !matches!(last, Part::Setting(_)))
        });
        self.last = part.map(|part| (part, now));
        let slot = self.slot;
        self.future.retain(|step| !step.is_reached(slot));
        if !goes_on {
            self.past.push(before);
            let surplus = self.past.len().saturating_sub(STEPS);
            self.past.drain(..surplus);
        }
    }

    /// What undo takes back, the last change first, or redo makes again, the next first: undo in one of two settings takes nothing back
    /// in the other.
    fn steps(&self, undo: bool) -> impl Iterator<Item = &Undoable> {
        let steps = if undo { &self.past } else { &self.future };
        steps.iter().rev().filter(|step| step.is_reached(self.slot))
    }

    /// What something was before the last change, or after it where that was taken back; `now` is what it is.
    pub(crate) fn step(&mut self, undo: bool, now: impl FnOnce(&Undoable) -> Undoable) -> Option<Undoable> {
        let (from, to) =
            if undo { (&mut self.past, &mut self.future) } else { (&mut self.future, &mut self.past) };
        let step = from.remove(from.iter().rposition(|step| step.is_reached(self.slot))?);
        to.push(now(&step));
        self.last = None;
        Some(step)
    }

    /// Forgets what ends with the open scene.
    pub(crate) fn forget_scene(&mut self) {
        for steps in [&mut self.past, &mut self.future] {
            steps.retain(|step| matches!(step, Undoable::Settings(..)));
        }
    }

    /// Puts the other settings on; `now` become the others.
    pub(crate) fn switch(&mut self, now: &Settings) -> Settings {
        self.last = None;
        self.slot = match self.slot {
            SettingsSlot::A => SettingsSlot::B,
            SettingsSlot::B => SettingsSlot::A,
        };
        self.other.replace(now.clone()).unwrap_or_else(|| now.clone())
    }

    /// The settings of a slot, given those that are on.
    pub(crate) fn of<'a>(&'a self, slot: SettingsSlot, now: &'a Settings) -> &'a Settings {
        if slot == self.slot { now } else { self.other.as_ref().unwrap_or(now) }
    }
}

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

    /// What undo takes back, or redo makes again, in the order in which repeating it does: the next changes by their names.
    pub(crate) fn undo_list(&self, undo: bool) -> Vec<String> {
        let steps: Vec<&Undoable> = self.inspector.history.steps(undo).take(LISTED).collect();
        let named = |(nth, step): (usize, &&Undoable)| {
            let is_alike =
                |other: &&&Undoable| std::mem::discriminant(**other) == std::mem::discriminant(*step);
            let nearer = steps[..nth].iter().rev().find(is_alike);
            let nearer = nearer.map_or_else(|| self.now(step), |nearer| Undoable::clone(nearer));
            Undoable::named(if undo { [step, &nearer] } else { [&nearer, step] })
        };
        steps.iter().enumerate().map(named).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use overlook_engine::edits::{Action, Edit, Region};

    fn with(tolerance: f32) -> Settings {
        let mut settings = Settings::default();
        settings.pruning.depth_tolerance = tolerance;
        settings
    }

    /// The settings of the slot that is on.
    fn step_of(history: &History, tolerance: f32) -> Undoable {
        Undoable::Settings(history.slot, Box::new(with(tolerance)))
    }

    fn record(history: &mut History, tolerance: f32, is_slider: bool, at: Instant) {
        let part = is_slider.then_some(Part::Setting("pruning.depth_tolerance"));
        history.record(step_of(history, tolerance), part, at);
    }

    /// What undo or redo gives where the tolerance is `now`.
    fn stepped(history: &mut History, undo: bool, now: f32) -> Option<f32> {
        let now = step_of(history, now);
        match history.step(undo, |_| now)? {
            Undoable::Settings(_, settings) => Some(settings.pruning.depth_tolerance),
            _ => None,
        }
    }

    #[test]
    fn a_slider_in_motion_is_undone_at_once_and_redone() {
        let (mut history, start) = (History::default(), Instant::now());
        for step in 0..10 {
            record(&mut history, 1.0 + step as f32, true, start + Duration::from_millis(50 * step));
        }
        assert_eq!(stepped(&mut history, true, 11.0), Some(1.0));
        assert_eq!(stepped(&mut history, true, 1.0), None);
        assert_eq!(stepped(&mut history, false, 1.0), Some(11.0));
    }

    #[test]
    fn what_is_chosen_is_undone_by_itself_however_soon_the_next_choice_follows() {
        let (mut history, at) = (History::default(), Instant::now());
        for (before, is_slider) in [(1.0, false), (2.0, false), (3.0, true), (4.0, false), (5.0, true)] {
            record(&mut history, before, is_slider, at);
        }
        let undone = std::iter::successors(Some(6.0), |now| stepped(&mut history, true, *now));
        assert_eq!(undone.skip(1).collect::<Vec<_>>(), [5.0, 4.0, 3.0, 2.0, 1.0]);
    }

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

    #[test]
    fn two_settings_take_turns() {
        let mut history = History::default();
        assert_eq!(history.switch(&with(1.0)), with(1.0), "B starts as A is");
        assert_eq!(history.switch(&with(2.0)), with(1.0));
        assert_eq!(
            (history.of(SettingsSlot::A, &with(1.0)), history.of(SettingsSlot::B, &with(1.0))),
            (&with(1.0), &with(2.0))
        );
    }

    #[test]
    fn what_was_changed_in_one_of_two_settings_is_not_taken_back_in_the_other() {
        let (mut history, start) = (History::default(), Instant::now());
        record(&mut history, 1.0, true, start);
        let b = history.switch(&with(2.0));
        assert_eq!(stepped(&mut history, true, 2.0), None, "nothing of B was changed");
        record(&mut history, 2.0, true, start);
        assert_eq!(stepped(&mut history, true, 3.0), Some(2.0));
        assert_eq!(history.switch(&b), with(2.0));
        assert_eq!(stepped(&mut history, false, 2.0), None, "nothing of A was taken back");
        assert_eq!(stepped(&mut history, true, 2.0), Some(1.0));
        assert_eq!(history.of(SettingsSlot::B, &with(1.0)), &b);
    }
}
