//! Timing by repetition: median and interquartile range, which are robust against a few repeats disturbed by other programs.

use std::hint::black_box;
use std::time::{Duration, Instant};

use overlook_engine::error::Result;
use overlook_engine::job::Job;

/// How often a piece of work is repeated: until there are enough repeats and enough time has passed, or until too much has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RepeatLimits {
    /// Repeats before the first that counts: they fill caches and touch pages.
    pub(crate) warm_ups: usize,
    /// Repeats that are enough.
    pub(crate) repeats: usize,
    /// Repeats below which not even `at_most` ends the measurement.
    pub(crate) fewest: usize,
    /// Time that the repeats take together at least.
    pub(crate) at_least: Duration,
    /// Time after which no further repeat begins.
    pub(crate) at_most: Duration,
}

impl RepeatLimits {
    /// For figures that are to be relied on: five repeats and half a second, three seconds at most.
    pub(crate) const FULL: Self = Self {
        warm_ups: 2,
        repeats: 5,
        fewest: 3,
        at_least: Duration::from_millis(500),
        at_most: Duration::from_secs(3),
    };

    /// To see that everything works: three repeats, however short.
    pub(crate) const QUICK: Self = Self {
        warm_ups: 1,
        repeats: 3,
        fewest: 2,
        at_least: Duration::ZERO,
        at_most: Duration::from_secs(1),
    };

    fn is_spent(&self, repeats: usize, elapsed: Duration) -> bool {
        let enough = repeats >= self.repeats && elapsed >= self.at_least;
        enough || (repeats >= self.fewest && elapsed >= self.at_most)
    }
}

/// Wall-clock times of repeats.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Times {
    sorted_ms: Vec<f64>,
}

impl Times {
    /// Of these milliseconds, in any order.
    pub(crate) fn of(mut milliseconds: Vec<f64>) -> Self {
        milliseconds.sort_by(f64::total_cmp);
        Self { sorted_ms: milliseconds }
    }

    /// These and the `other` repeats of the same work, as one.
    pub(crate) fn and(mut self, other: Self) -> Self {
        self.sorted_ms.extend(other.sorted_ms);
        Self::of(self.sorted_ms)
    }

    /// How many there are.
    pub(crate) fn repeats(&self) -> usize {
        self.sorted_ms.len()
    }

    /// Median time of a repeat, milliseconds; 0 without repeats.
    pub(crate) fn median_ms(&self) -> f64 {
        self.quantile_ms(0.5)
    }

    /// Interquartile range of the repeats, milliseconds.
    pub(crate) fn spread_ms(&self) -> f64 {
        self.quantile_ms(0.75) - self.quantile_ms(0.25)
    }

    /// Units a second in millions, at the median.
    pub(crate) fn millions_per_s(&self, units: u64) -> f64 {
        units as f64 / (self.median_ms() * 1e3)
    }

    /// Bytes a second in units of 10⁹, at the median.
    pub(crate) fn gb_per_s(&self, bytes: u64) -> f64 {
        bytes as f64 / (self.median_ms() * 1e6)
    }

    /// Linear between neighboring times (type 7 of Hyndman and Fan, *Sample Quantiles in Statistical Packages*, 1996).
    fn quantile_ms(&self, share: f64) -> f64 {
        let Some(last) = self.sorted_ms.len().checked_sub(1) else { return 0.0 };
        let position = share * last as f64;
        let below = position.floor() as usize;
        let above = (below + 1).min(last);
        let (low, high) = (self.sorted_ms[below], self.sorted_ms[above]);
        low + (high - low) * (position - below as f64)
    }
}

/// Processor time that all threads of this process have taken so far, milliseconds; `None` where the system does not tell.
#[cfg(unix)]
#[expect(clippy::unnecessary_wraps, reason = "other systems do not tell")]
pub(crate) fn cpu_ms() -> Option<f64> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    Some(time.tv_sec as f64 * 1e3 + time.tv_nsec as f64 * 1e-6)
}

/// Nothing: the system does not tell.
#[cfg(not(unix))]
pub(crate) fn cpu_ms() -> Option<f64> {
    None
}

/// Repeats `work` within the budget. Its results are kept from the optimizer, and dropped outside of the measured time.
pub(crate) fn repeat<T>(
    budget: RepeatLimits,
    job: &Job,
    mut work: impl FnMut() -> Result<T>,
) -> Result<Times> {
    for _ in 0..budget.warm_ups {
        job.check()?;
        black_box(work()?);
    }
    let mut milliseconds = Vec::new();
    let begun = Instant::now();
    while !budget.is_spent(milliseconds.len(), begun.elapsed()) {
        job.check()?;
        let started = Instant::now();
        let result = black_box(work()?);
        milliseconds.push(started.elapsed().as_secs_f64() * 1e3);
        drop(result);
    }
    Ok(Times::of(milliseconds))
}

#[cfg(test)]
mod tests {
    use super::*;
    use overlook_engine::error::Error;

    #[test]
    fn median_and_spread_pass_over_what_is_out_of_line() {
        let times = Times::of(vec![5.0, 1.0, 900.0, 3.0, 2.0]);
        assert_eq!((times.median_ms(), times.spread_ms(), times.repeats()), (3.0, 3.0, 5));
        let even = Times::of(vec![4.0, 1.0, 2.0, 3.0]);
        assert_eq!((even.median_ms(), even.spread_ms()), (2.5, 1.5));
        let one = Times::of(vec![7.0]);
        assert_eq!((one.median_ms(), one.spread_ms()), (7.0, 0.0));
        assert_eq!((Times::default().median_ms(), Times::default().spread_ms()), (0.0, 0.0));
    }

    #[test]
    fn two_series_of_one_work_count_as_one() {
        let times = Times::of(vec![1.0, 2.0]).and(Times::of(vec![0.0, 9.0, 8.0]));
        assert_eq!(times, Times::of(vec![0.0, 1.0, 2.0, 8.0, 9.0]));
    }

    #[test]
    fn rates_are_per_second() {
        let times = Times::of(vec![2.0]);
        assert_eq!((times.millions_per_s(2_000_000), times.gb_per_s(1_000_000_000)), (1000.0, 500.0));
    }

    #[test]
    fn work_is_repeated_until_the_budget_is_spent_and_no_longer() {
        let second = Duration::from_secs(1);
        let budget =
            RepeatLimits { warm_ups: 2, repeats: 5, fewest: 3, at_least: second, at_most: 3 * second };
        assert!(!budget.is_spent(4, second) && !budget.is_spent(5, second / 2));
        assert!(
            budget.is_spent(5, second) && !budget.is_spent(2, 9 * second) && budget.is_spent(3, 3 * second)
        );

        let mut calls = 0;
        let quick = RepeatLimits { at_least: Duration::ZERO, ..budget };
        let times = repeat(quick, &Job::new(), || {
            calls += 1;
            Ok(calls)
        });
        assert_eq!((times.unwrap().repeats(), calls), (5, 7));
    }

    #[test]
    fn a_cancelled_measurement_ends_before_the_next_repeat() {
        let job = Job::new();
        let mut calls = 0;
        let result = repeat(RepeatLimits::FULL, &job, || {
            calls += 1;
            job.cancel();
            Ok(())
        });
        assert!(matches!(result, Err(Error::Cancelled)));
        assert_eq!(calls, 1);
    }
}
