//! A clock that stands still while something is done that is not part of the work it measures.

use std::time::{Duration, Instant};

/// Wall-clock time of some work.
pub(super) struct Clock {
    started: Instant,
    aside: Duration,
}

impl Clock {
    /// Runs from now on.
    pub(super) fn start() -> Self {
        Self { started: Instant::now(), aside: Duration::ZERO }
    }

    /// Does what is not counted.
    pub(super) fn aside<T>(&mut self, work: impl FnOnce() -> T) -> T {
        let started = Instant::now();
        let done = work();
        self.aside += started.elapsed();
        done
    }

    /// Seconds of work so far.
    pub(super) fn seconds(&self) -> f64 {
        self.started.elapsed().saturating_sub(self.aside).as_secs_f64()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_done_aside_is_not_counted() {
        const ASIDE: Duration = Duration::from_millis(30);
        let before = Instant::now();
        let mut clock = Clock::start();
        assert_eq!(
            clock.aside(|| {
                std::thread::sleep(ASIDE);
                7
            }),
            7
        );
        let seconds = clock.seconds();
        assert!(seconds + ASIDE.as_secs_f64() <= before.elapsed().as_secs_f64() + 1e-6, "{seconds}");
    }
}
