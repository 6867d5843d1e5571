//! Settings as they were: undo and redo, and two settings side by side.

use std::time::{Duration, Instant};

use crate::settings::Settings;

/// Changes of one setting that follow each other faster than this are one change: a slider in motion.
const ONE_CHANGE: Duration = Duration::from_millis(700);

/// Changes that are remembered.
const STEPS: usize = 200;

/// Which of two settings is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(crate) enum Slot {
    /// The first.
    #[default]
    A,
    /// The second.
    B,
}

/// What settings were.
#[derive(Default)]
pub(crate) struct History {
    undo: Vec<Settings>,
    redo: Vec<Settings>,
    last: Option<(Instant, &'static str)>,
    /// Which of two settings is on.
    pub slot: Slot,
    /// The settings that are not on; `None` while both are the same.
    pub other: Option<Settings>,
}

impl History {
    /// `what` is about to change `before`.
    pub(crate) fn record(&mut self, before: &Settings, what: &'static str, now: Instant) {
        let goes_on = self.last.is_some_and(|(at, last)| last == what && now.duration_since(at) < ONE_CHANGE);
        self.last = Some((now, what));
        self.redo.clear();
        if goes_on {
            return;
        }
        if self.undo.len() == STEPS {
            self.undo.remove(0);
        }
        self.undo.push(before.clone());
    }

    /// Whether there is something to go back to.
    pub(crate) fn can_undo(&self) -> bool {
        !self.undo.is_empty()
    }

    /// Whether there is something to go forward to.
    pub(crate) fn can_redo(&self) -> bool {
        !self.redo.is_empty()
    }

    /// The settings before the last change.
    pub(crate) fn undo(&mut self, now: &Settings) -> Option<Settings> {
        let before = self.undo.pop()?;
        self.redo.push(now.clone());
        self.last = None;
        Some(before)
    }

    /// The settings that were undone last.
    pub(crate) fn redo(&mut self, now: &Settings) -> Option<Settings> {
        let after = self.redo.pop()?;
        self.undo.push(now.clone());
        self.last = None;
        Some(after)
    }

    /// Puts the other settings on; `now` become the others.
    pub(crate) fn switch(&mut self, now: &Settings) -> Settings {
        self.slot = match self.slot {
            Slot::A => Slot::B,
            Slot::B => Slot::A,
        };
        self.last = None;
        self.other.replace(now.clone()).unwrap_or_else(|| now.clone())
    }

    /// The settings of a slot, given those that are on.
    pub(crate) fn of<'a>(&'a self, slot: Slot, now: &'a Settings) -> &'a Settings {
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
            history.record(&with(1.0 + step as f32), "pruning.depth_tolerance", at);
        }
        let before = history.undo(&with(11.0)).unwrap();
        assert_eq!(before, with(1.0));
        assert!(!history.can_undo());
        assert_eq!(history.redo(&before).unwrap(), with(11.0));
    }

    #[test]
    fn two_settings_take_turns() {
        let mut history = History::default();
        assert_eq!(history.switch(&with(1.0)), with(1.0), "B starts as A is");
        assert_eq!(history.switch(&with(2.0)), with(1.0));
        assert_eq!(
            (history.of(Slot::A, &with(1.0)), history.of(Slot::B, &with(1.0))),
            (&with(1.0), &with(2.0))
        );
    }
}
