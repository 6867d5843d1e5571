//! What the window's own work takes: the time that `logic` and `ui` spend on the thread that draws.
//!
//! Painting by the graphics driver (or by a program in its place) is not in it: it starts when `ui` is done.

use std::collections::VecDeque;
use std::time::Duration;

/// Frames that are remembered.
const FRAMES: usize = 600;

/// The frame time that keeps sixty frames a second, milliseconds.
pub(crate) const BUDGET_MS: f32 = 16.0;

/// Milliseconds of the window's own work, frame by frame.
#[derive(Default)]
pub(crate) struct Meter {
    logic: Duration,
    frames_ms: VecDeque<f32>,
}

/// The last frames in figures, milliseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameTimes {
    /// Frames that were counted.
    pub frames: usize,
    /// Half of the frames took no longer.
    pub median_ms: f32,
    /// All but one in a hundred took no longer.
    pub percentile_99_ms: f32,
    /// The longest.
    pub longest_ms: f32,
    /// Frames longer than 16 ms.
    pub over_budget: usize,
}

impl Meter {
    /// `logic` took this long.
    pub(crate) fn logic(&mut self, elapsed: Duration) {
        self.logic += elapsed;
    }

    /// `ui` took this long: the frame is over.
    pub(crate) fn ui(&mut self, elapsed: Duration) {
        if self.frames_ms.len() == FRAMES {
            self.frames_ms.pop_front();
        }
        self.frames_ms.push_back((std::mem::take(&mut self.logic) + elapsed).as_secs_f32() * 1e3);
    }

    /// Forgets what it counted.
    pub(crate) fn clear(&mut self) {
        self.frames_ms.clear();
    }

    /// The frames, the latest last, milliseconds.
    pub(crate) fn frames_ms(&self) -> impl Iterator<Item = f32> + '_ {
        self.frames_ms.iter().copied()
    }

    /// The last frames in figures; `None` before the first.
    pub(crate) fn times(&self) -> Option<FrameTimes> {
        let mut sorted: Vec<f32> = self.frames_ms.iter().copied().collect();
        sorted.sort_unstable_by(f32::total_cmp);
        let longest_ms = *sorted.last()?;
        let at = |share: f32| sorted[((sorted.len() - 1) as f32 * share) as usize];
        Some(FrameTimes {
            frames: sorted.len(),
            median_ms: at(0.5),
            percentile_99_ms: at(0.99),
            longest_ms,
            over_budget: sorted.iter().filter(|ms| **ms > BUDGET_MS).count(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_its_logic_and_its_drawing() {
        let mut meter = Meter::default();
        assert_eq!(meter.times(), None);
        for ms in [1, 2, 30] {
            meter.logic(Duration::from_millis(ms));
            meter.ui(Duration::from_millis(1));
        }
        let times = meter.times().unwrap();
        assert_eq!((times.frames, times.over_budget), (3, 1));
        assert!((times.median_ms - 3.0).abs() < 1e-3 && (times.longest_ms - 31.0).abs() < 1e-3);
    }
}
