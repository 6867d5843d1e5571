//! Frame times: what `logic` and `ui` take on the thread that draws, painting by the graphics driver apart.
//!
//! Time is counted twice: as it passes, and as the processor spent it on this thread. The difference is waiting for a
//! processor.

use std::collections::VecDeque;
use std::fmt::Write;
use std::time::{Duration, Instant};

use overlook_engine::plural::counted;

/// Frames that are remembered: a minute of them.
const FRAMES: usize = 3600;

/// The frame time that keeps sixty frames a second, milliseconds.
const BUDGET_MS: f32 = 16.0;

/// Times a piece of work on the calling thread.
pub(crate) struct Stopwatch {
    wall: Instant,
    cpu: Option<Duration>,
}

impl Stopwatch {
    pub(crate) fn start() -> Self {
        Self { wall: Instant::now(), cpu: cpu_time() }
    }

    /// Time since the start: as it passed, and as the processor spent it; the latter zero where the system does not know.
    pub(crate) fn spent(&self) -> [Duration; 2] {
        let cpu = cpu_time().zip(self.cpu).map(|(now, then)| now.saturating_sub(then));
        [self.wall.elapsed(), cpu.unwrap_or_default()]
    }
}

/// Processor time that the calling thread has spent so far; `None` where the system does not know.
#[cfg(target_os = "linux")]
fn cpu_time() -> Option<Duration> {
    let spent = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Some(Duration::new(spent.tv_sec.try_into().ok()?, spent.tv_nsec.try_into().ok()?))
}

/// Processor time that the calling thread has spent so far; `None` where the system does not know.
#[cfg(not(target_os = "linux"))]
fn cpu_time() -> Option<Duration> {
    None
}

/// Milliseconds of the last frames.
#[derive(Default)]
pub(crate) struct Meter {
    logic: [Duration; 2],
    /// As time passed, and as the processor spent it.
    frames_ms: VecDeque<[f32; 2]>,
}

impl Meter {
    /// `logic` took this long.
    pub(crate) fn logic(&mut self, spent: [Duration; 2]) {
        self.logic = sum(self.logic, spent);
    }

    /// `ui` took this long: the frame is over.
    pub(crate) fn ui(&mut self, spent: [Duration; 2]) {
        let frame = sum(std::mem::take(&mut self.logic), spent);
        if self.frames_ms.len() == FRAMES {
            self.frames_ms.pop_front();
        }
        self.frames_ms.push_back(frame.map(|time| time.as_secs_f32() * 1e3));
    }

    /// The last frames in figures; `None` before the first.
    pub(crate) fn summary(&self) -> Option<String> {
        let mut text = String::new();
        for (index, what) in ["wall time", "CPU time"].into_iter().enumerate() {
            let mut sorted: Vec<f32> = self.frames_ms.iter().map(|times| times[index]).collect();
            sorted.sort_unstable_by(f32::total_cmp);
            let longest = sorted.last()?;
            let at = |share: f32| sorted[((sorted.len() - 1) as f32 * share) as usize];
            let over = sorted.iter().filter(|ms| **ms > BUDGET_MS).count();
            let separator = if index > 0 { " / " } else { "" };
            let _ = write!(
                text,
                "{separator}{what}: median {:.1} ms, p99 {:.1} ms, longest {longest:.1} ms; {over} of {} over \
                 {BUDGET_MS} ms",
                at(0.5),
                at(0.99),
                counted(sorted.len(), "frame")
            );
        }
        Some(text)
    }
}

fn sum(a: [Duration; 2], b: [Duration; 2]) -> [Duration; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_its_logic_and_its_drawing() {
        let mut meter = Meter::default();
        assert_eq!(meter.summary(), None);
        let spent = |wall, cpu| [wall, cpu].map(Duration::from_millis);
        for wall in [1, 2, 30] {
            meter.logic(spent(wall, 1));
            meter.ui(spent(1, 2));
        }
        assert_eq!(
            meter.summary().unwrap(),
            "wall time: median 3.0 ms, p99 3.0 ms, longest 31.0 ms; 1 of 3 frames over 16 ms / \
             CPU time: median 3.0 ms, p99 3.0 ms, longest 3.0 ms; 0 of 3 frames over 16 ms"
        );
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn time_asleep_is_not_time_spent() {
        let before = cpu_time().unwrap();
        std::thread::sleep(Duration::from_millis(40));
        assert!(cpu_time().unwrap() < before + Duration::from_millis(20));
    }
}
