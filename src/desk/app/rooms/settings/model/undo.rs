//! Settings as they were: undo and redo, and two settings side by side.

use std::time::{Duration, Instant};

use overlook_engine::settings::Settings;

/// Numbers of one setting that follow each other faster than this are one change: a slider in motion.
const ONE_CHANGE: Duration = Duration::from_millis(700);

/// Changes that are remembered.
const STEPS: usize = 200;

/// Earlier states of something, and those that were taken back.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Steps<T> {
    past: Vec<T>,
    future: Vec<T>,
}

impl<T> Default for Steps<T> {
    fn default() -> Self {
        Self { past: Vec::new(), future: Vec::new() }
    }
}

impl<T> Steps<T> {
    /// Notes what something was before a change: as a step of its own, or as a part of the last one.
    pub(crate) fn record(&mut self, before: T, is_new_step: bool) {
        self.future.clear();
        if is_new_step || self.past.is_empty() {
            self.past.push(before);
            let surplus = self.past.len().saturating_sub(STEPS);
            self.past.drain(..surplus);
        }
    }

    /// Whether there is something to go back to (or forward to).
    pub(crate) fn can(&self, undo: bool) -> bool {
        !if undo { &self.past } else { &self.future }.is_empty()
    }

    /// The changes that can be taken back, the last first, or made again, the next first: what something was before each, and after
    /// it; `now` is what it is.
    pub(crate) fn changes<'a>(&'a self, undo: bool, now: &'a T) -> impl Iterator<Item = [&'a T; 2]> {
        let states = if undo { &self.past } else { &self.future };
        let nearer = std::iter::once(now).chain(states.iter().rev());
        let pairs = nearer.zip(states.iter().rev());
        pairs.map(move |(nearer, farther)| if undo { [farther, nearer] } else { [nearer, farther] })
    }

    /// What something was before the last change, or after it where that was taken back; `now` is what it is.
    pub(crate) fn step(&mut self, undo: bool, now: T) -> Option<T> {
        let (from, to) =
            if undo { (&mut self.past, &mut self.future) } else { (&mut self.future, &mut self.past) };
        let other = from.pop()?;
        to.push(now);
        Some(other)
    }
}

/// Which of two settings is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(crate) enum SettingsSlot {
    /// The first.
    #[default]
    A,
    /// The second.
    B,
}

/// What became of the settings of a slot.
#[derive(Default)]
struct Past {
    steps: Steps<Settings>,
    /// Which number was changed last and when; `None` if the last change was of another kind.
    last: Option<(Instant, &'static str)>,
}

/// Earlier settings.
#[derive(Default)]
pub(crate) struct History {
    /// Changes of the settings that are on, and of the other ones: undo in one takes nothing back in the other.
    past: Past,
    other_past: Past,
    /// Which of two settings is on.
    pub slot: SettingsSlot,
    /// The settings that are not on; `None` while both are the same.
    pub other: Option<Settings>,
}

impl History {
    /// `before` are about to change. `number` names the setting if it is a number, as a slider changes it; `None` if something is
    /// chosen.
    pub(crate) fn record(&mut self, before: &Settings, number: Option<&'static str>, now: Instant) {
        let past = &mut self.past;
        let goes_on =
            past.last.is_some_and(|(at, last)| Some(last) == number && now.duration_since(at) < ONE_CHANGE);
        past.last = number.map(|number| (now, number));
        past.steps.record(before.clone(), !goes_on);
    }

    /// Whether there is something to go back to.
    pub(crate) fn can_undo(&self) -> bool {
        self.past.steps.can(true)
    }

    /// Whether there is something to go forward to.
    pub(crate) fn can_redo(&self) -> bool {
        self.past.steps.can(false)
    }

    /// The changes of the settings that are on, as [`Steps::changes`] gives them.
    pub(crate) fn changes<'a>(
        &'a self,
        undo: bool,
        now: &'a Settings,
    ) -> impl Iterator<Item = [&'a Settings; 2]> {
        self.past.steps.changes(undo, now)
    }

    /// The settings before the last change of those that are on.
    pub(crate) fn undo(&mut self, now: &Settings) -> Option<Settings> {
        let before = self.past.steps.step(true, now.clone())?;
        self.past.last = None;
        Some(before)
    }

    /// The settings that were undone last of those that are on.
    pub(crate) fn redo(&mut self, now: &Settings) -> Option<Settings> {
        let after = self.past.steps.step(false, now.clone())?;
        self.past.last = None;
        Some(after)
    }

    /// Puts the other settings on; `now` become the others.
    pub(crate) fn switch(&mut self, now: &Settings) -> Settings {
        self.past.last = None;
        std::mem::swap(&mut self.past, &mut self.other_past);
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

    #[test]
    fn a_slider_in_motion_is_undone_at_once_and_redone() {
        let (mut history, start) = (History::default(), Instant::now());
        for step in 0..10 {
            let at = start + Duration::from_millis(50 * step);
            history.record(&with(1.0 + step as f32), Some("pruning.depth_tolerance"), at);
        }
        let before = history.undo(&with(11.0)).unwrap();
        assert_eq!(before, with(1.0));
        assert!(!history.can_undo());
        assert_eq!(history.redo(&before).unwrap(), with(11.0));
    }

    #[test]
    fn what_is_chosen_is_undone_by_itself_however_soon_the_next_choice_follows() {
        let (mut history, at) = (History::default(), Instant::now());
        history.record(&with(1.0), None, at);
        history.record(&with(2.0), None, at);
        history.record(&with(3.0), Some("pruning.depth_tolerance"), at);
        history.record(&with(4.0), None, at);
        history.record(&with(5.0), Some("pruning.depth_tolerance"), at);
        let undone = std::iter::successors(history.undo(&with(6.0)), |now| history.undo(now));
        assert_eq!(undone.collect::<Vec<_>>(), [5.0, 4.0, 3.0, 2.0, 1.0].map(with));
    }

    #[test]
    fn changes_are_listed_in_the_order_in_which_they_are_taken_back_and_made_again() {
        let mut steps = Steps::default();
        let listed = |steps: &Steps<u32>, undo: bool, now: u32| -> Vec<[u32; 2]> {
            steps.changes(undo, &now).map(|pair| pair.map(|state| *state)).collect()
        };
        for before in 0..3 {
            steps.record(before, true);
        }
        assert_eq!(listed(&steps, true, 3), [[2, 3], [1, 2], [0, 1]]);
        assert_eq!((steps.step(true, 3), steps.step(true, 2)), (Some(2), Some(1)));
        assert_eq!(listed(&steps, true, 1), [[0, 1]]);
        assert_eq!(listed(&steps, false, 1), [[1, 2], [2, 3]]);
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
        history.record(&with(1.0), Some("pruning.depth_tolerance"), start);
        let b = history.switch(&with(2.0));
        assert!(!history.can_undo(), "nothing of B was changed");
        history.record(&b, Some("pruning.depth_tolerance"), start);
        assert_eq!(history.undo(&with(3.0)).unwrap(), b);
        assert_eq!(history.switch(&b), with(2.0));
        assert!(!history.can_redo(), "nothing of A was taken back");
        assert_eq!(history.undo(&with(2.0)).unwrap(), with(1.0));
        assert_eq!(history.of(SettingsSlot::B, &with(1.0)), &b);
    }
}
