//! Estimated time left of a run of measurements.

use std::time::Instant;

use overlook_engine::job::Job;

/// The mean time of the points measured so far.
pub(crate) struct TimeLeft {
    started: Instant,
    measured: usize,
}

impl TimeLeft {
    /// Nothing is measured yet.
    pub(crate) fn start() -> Self {
        Self { started: Instant::now(), measured: 0 }
    }

    /// Points that were begun.
    pub(crate) fn measured(&self) -> usize {
        self.measured
    }

    /// Shows in the job which point is next and how long the `left` points, this one included, take at the pace so far.
    pub(crate) fn next(&mut self, job: &Job, number: usize, total: usize, left: usize) {
        let each = (self.measured > 0).then(|| self.started.elapsed().as_secs_f64() / self.measured as f64);
        job.set_context(match each.map(|each| each * left as f64) {
            None => format!("{number} of {total}"),
            Some(seconds) if seconds < 90.0 => format!("{number} of {total}, {seconds:.0} s left"),
            Some(seconds) => format!("{number} of {total}, {:.0} min left", seconds / 60.0),
        });
        self.measured += 1;
    }
}
