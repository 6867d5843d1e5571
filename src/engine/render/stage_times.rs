//! How long each stage of a picture took.

use std::time::Instant;

/// Wall-clock milliseconds of each stage of a picture. Silhouettes are found and colors looked up block by block on all threads: the time
/// that both take together is shared out by the time that the threads spent on each. A graphics card tells the times by its own clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct StageTimes {
    /// Listing the samples of the frame, and finding those that the picture may show.
    pub select_ms: f64,
    /// Painting samples into the z-buffer.
    pub paint_ms: f64,
    /// Deciding which surfaces pixels show.
    pub silhouettes_ms: f64,
    /// Looking up the colors of these surfaces, or blending them.
    pub look_up_ms: f64,
    /// Finding what cameras saw, and testing lines of sight.
    pub free_space_ms: f64,
    /// Filling holes.
    pub fill_ms: f64,
    /// Copying pictures.
    pub copy_ms: f64,
}

/// A stage, as an index of the parts of [`StageTimes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stage {
    Select,
    Paint,
    Silhouettes,
    LookUp,
    FreeSpace,
    Fill,
    Copy,
}

impl Stage {
    const ALL: [Self; 7] =
        [Self::Select, Self::Paint, Self::Silhouettes, Self::LookUp, Self::FreeSpace, Self::Fill, Self::Copy];
}

impl StageTimes {
    /// The names of the stages, and their milliseconds.
    #[must_use]
    pub fn parts(&self) -> [(&'static str, f64); 7] {
        [
            ("select", self.select_ms),
            ("paint", self.paint_ms),
            ("silhouettes", self.silhouettes_ms),
            ("look up", self.look_up_ms),
            ("free space", self.free_space_ms),
            ("fill", self.fill_ms),
            ("copy", self.copy_ms),
        ]
    }

    /// Adds the times of another picture.
    pub fn add(&mut self, other: &Self) {
        let mut other = *other;
        for stage in Stage::ALL {
            *self.of(stage) += *other.of(stage);
        }
    }

    /// The time of a stage.
    pub(super) fn of(&mut self, stage: Stage) -> &mut f64 {
        match stage {
            Stage::Select => &mut self.select_ms,
            Stage::Paint => &mut self.paint_ms,
            Stage::Silhouettes => &mut self.silhouettes_ms,
            Stage::LookUp => &mut self.look_up_ms,
            Stage::FreeSpace => &mut self.free_space_ms,
            Stage::Fill => &mut self.fill_ms,
            Stage::Copy => &mut self.copy_ms,
        }
    }
}

/// Adds up what each stage of one picture takes.
#[derive(Debug)]
pub(crate) struct StageClock {
    last: Instant,
    times: StageTimes,
}

impl StageClock {
    /// From now on.
    pub(crate) fn start() -> Self {
        Self { last: Instant::now(), times: StageTimes::default() }
    }

    /// Counts the time since the last call, or the start, for a stage.
    pub(crate) fn end(&mut self, stage: Stage) {
        let milliseconds = self.lap();
        *self.times.of(stage) += milliseconds;
    }

    /// Shares the time since the last call out among two stages, by the nanoseconds that threads spent on each.
    pub(crate) fn end_both(&mut self, stages: [Stage; 2], spent: [u64; 2]) {
        let milliseconds = self.lap();
        // Where neither was measured apart, all of it is the second stage's.
        let spent = if spent == [0, 0] { [0, 1] } else { spent };
        let all = (spent[0] + spent[1]) as f64;
        for (stage, spent) in stages.into_iter().zip(spent) {
            *self.times.of(stage) += milliseconds * spent as f64 / all;
        }
    }

    /// What the stages took so far.
    pub(crate) fn times(&self) -> StageTimes {
        self.times
    }

    fn lap(&mut self) -> f64 {
        let now = Instant::now();
        let milliseconds = now.duration_since(self.last).as_secs_f64() * 1e3;
        self.last = now;
        milliseconds
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_of_two_stages_that_run_together_is_shared_out_by_what_threads_spent() {
        let mut clock = StageClock::start();
        std::thread::sleep(std::time::Duration::from_millis(2));
        clock.end_both([Stage::Silhouettes, Stage::LookUp], [100, 300]);
        let times = clock.times();
        assert!(times.silhouettes_ms > 0.0);
        assert!((times.look_up_ms - 3.0 * times.silhouettes_ms).abs() < 1e-9);
        clock.end(Stage::Copy);
        let mut twice = clock.times();
        twice.add(&clock.times());
        for ((name, once), (_, both)) in clock.times().parts().into_iter().zip(twice.parts()) {
            assert!((both - 2.0 * once).abs() < 1e-12, "{name}");
        }
    }
}
