//! What the window's own work takes: the time that `logic` and `ui` spend on the thread that draws.
//!
//! Painting by the graphics driver (or by a program in its place) is not in it: it starts when `ui` is done. Time is counted
//! twice: as it passes, and as the processor spent it on this thread. What lies between the two is time that the thread
//! waited for a processor that others held.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use super::super::own_thread;

/// Frames that are remembered: a minute of them.
const FRAMES: usize = 3600;

/// The frame time that keeps sixty frames a second, milliseconds.
pub(crate) const BUDGET_MS: f32 = 16.0;

/// Time that a piece of work took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Spent {
    /// As it passed.
    pub wall: Duration,
    /// As the processor spent it on this thread; `None` where the system does not tell.
    pub cpu: Option<Duration>,
}

/// Times a piece of work on the calling thread.
pub(crate) struct Stopwatch {
    wall: Instant,
    cpu: Option<Duration>,
}

impl Stopwatch {
    /// Starts.
    pub(crate) fn start() -> Self {
        Self { wall: Instant::now(), cpu: own_thread::cpu_time() }
    }

    /// Time since the start.
    pub(crate) fn spent(&self) -> Spent {
        let cpu = own_thread::cpu_time().zip(self.cpu).map(|(now, then)| now.saturating_sub(then));
        Spent { wall: self.wall.elapsed(), cpu }
    }
}

/// Milliseconds of the window's own work, frame by frame.
#[derive(Default)]
pub(crate) struct Meter {
    logic: Spent,
    wall_ms: VecDeque<f32>,
    cpu_ms: VecDeque<f32>,
}

/// The last frames in figures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameTimes {
    /// Time as it passed.
    pub wall: Figures,
    /// Processor time of the thread that draws; `None` where the system does not tell.
    pub cpu: Option<Figures>,
}

/// Many times in a few figures, milliseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
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

impl std::fmt::Display for Figures {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { frames, median_ms, percentile_99_ms, longest_ms, over_budget } = self;
        write!(
            f,
            "median {median_ms:.1} ms, 99 of 100 within {percentile_99_ms:.1} ms, longest {longest_ms:.1} ms; \
             {over_budget} of {frames} frames over {BUDGET_MS} ms"
        )
    }
}

impl std::fmt::Display for FrameTimes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "passed: {}", self.wall)?;
        if let Some(cpu) = &self.cpu {
            write!(f, " / spent: {cpu}")?;
        }
        Ok(())
    }
}

impl Meter {
    /// `logic` took this long.
    pub(crate) fn logic(&mut self, spent: Spent) {
        self.logic = self.logic.and(spent);
    }

    /// `ui` took this long: the frame is over.
    pub(crate) fn ui(&mut self, spent: Spent) {
        let frame = std::mem::take(&mut self.logic).and(spent);
        if frame.wall.as_secs_f32() * 1e3 > BUDGET_MS / 2.0 {
            log::debug!(
                "a frame took {:.1?}, of which ui {:.1?}; {:.1?} spent",
                frame.wall,
                spent.wall,
                frame.cpu
            );
        }
        remember(&mut self.wall_ms, frame.wall);
        if let Some(cpu) = frame.cpu {
            remember(&mut self.cpu_ms, cpu);
        }
    }

    /// Forgets what it counted.
    pub(crate) fn clear(&mut self) {
        self.wall_ms.clear();
        self.cpu_ms.clear();
    }

    /// The frames as time passed, the latest last, milliseconds.
    pub(crate) fn wall_ms(&self) -> impl DoubleEndedIterator<Item = f32> + '_ {
        self.wall_ms.iter().copied()
    }

    /// The last frames in figures; `None` before the first.
    pub(crate) fn times(&self) -> Option<FrameTimes> {
        Some(FrameTimes { wall: figures(&self.wall_ms)?, cpu: figures(&self.cpu_ms) })
    }
}

impl Spent {
    fn and(self, other: Self) -> Self {
        let cpu = match (self.cpu, other.cpu) {
            (Some(a), Some(b)) => Some(a + b),
            (a, b) => a.or(b),
        };
        Self { wall: self.wall + other.wall, cpu }
    }
}

fn remember(times_ms: &mut VecDeque<f32>, time: Duration) {
    if times_ms.len() == FRAMES {
        times_ms.pop_front();
    }
    times_ms.push_back(time.as_secs_f32() * 1e3);
}

fn figures(times_ms: &VecDeque<f32>) -> Option<Figures> {
    let mut sorted: Vec<f32> = times_ms.iter().copied().collect();
    sorted.sort_unstable_by(f32::total_cmp);
    let longest_ms = *sorted.last()?;
    let at = |share: f32| sorted[((sorted.len() - 1) as f32 * share) as usize];
    Some(Figures {
        frames: sorted.len(),
        median_ms: at(0.5),
        percentile_99_ms: at(0.99),
        longest_ms,
        over_budget: sorted.iter().filter(|ms| **ms > BUDGET_MS).count(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_its_logic_and_its_drawing() {
        let mut meter = Meter::default();
        assert_eq!(meter.times(), None);
        let spent = |wall, cpu: Option<u64>| Spent {
            wall: Duration::from_millis(wall),
            cpu: cpu.map(Duration::from_millis),
        };
        for wall in [1, 2, 30] {
            meter.logic(spent(wall, Some(1)));
            meter.ui(spent(1, Some(2)));
        }
        let FrameTimes { wall, cpu } = meter.times().unwrap();
        assert_eq!((wall.frames, wall.over_budget), (3, 1));
        assert!((wall.median_ms - 3.0).abs() < 1e-3 && (wall.longest_ms - 31.0).abs() < 1e-3);
        let cpu = cpu.unwrap();
        assert!(cpu.over_budget == 0 && (cpu.longest_ms - 3.0).abs() < 1e-3);
    }

    #[test]
    fn where_the_system_does_not_tell_there_is_no_processor_time() {
        let mut meter = Meter::default();
        meter.ui(Spent { wall: Duration::from_millis(1), cpu: None });
        assert_eq!(meter.times().unwrap().cpu, None);
    }
}
