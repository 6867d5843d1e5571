//! What can be taken back, in the order in which it was changed: settings, edits and the camera path; and two settings side by side.

use std::time::{Duration, Instant};

use crate::app::rooms::path::PathShape;
use overlook_engine::edits::EditList;
use overlook_engine::settings::Settings;

/// Numbers of one setting that follow each other faster than this are one change: a slider in motion.
const ONE_CHANGE: Duration = Duration::from_millis(700);

/// Changes that are remembered.
const STEPS: usize = 200;

/// Which of two settings is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(crate) enum SettingsSlot {
    #[default]
    A,
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
    pub(crate) fn steps(&self, undo: bool) -> impl Iterator<Item = &Undoable> {
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

#[cfg(test)]
mod tests {
    use super::*;

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
    fn what_was_changed_in_one_of_two_settings_is_not_taken_back_in_the_other() {
        let (mut history, start) = (History::default(), Instant::now());
        record(&mut history, 1.0, true, start);
        let b = history.switch(&with(2.0));
        assert_eq!(b, with(2.0), "B starts as A is");
        assert_eq!(stepped(&mut history, true, 2.0), None, "nothing of B was changed");
        record(&mut history, 2.0, true, start);
        assert_eq!(stepped(&mut history, true, 3.0), Some(2.0));
        assert_eq!(history.switch(&b), with(2.0));
        assert_eq!(stepped(&mut history, false, 2.0), None, "nothing of A was taken back");
        assert_eq!(stepped(&mut history, true, 2.0), Some(1.0));
        let a = with(1.0);
        assert_eq!([SettingsSlot::A, SettingsSlot::B].map(|slot| history.of(slot, &a)), [&a, &b]);
    }
}
