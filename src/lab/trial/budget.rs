//! The order in which many values are measured, and how long: from coarse to fine, until a budget of time is spent.

use std::time::{Duration, Instant};

use overlook_engine::job::Job;

/// How many values of each dial are measured: a dial is one setting, or the size of one disturbance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Fineness {
    /// Both ends.
    Coarse,
    /// Both ends and the middle.
    Medium,
    /// All values.
    #[default]
    Fine,
}

impl Fineness {
    /// Whether values of a level of [`levels`] are measured.
    #[must_use]
    pub fn takes(self, level: usize) -> bool {
        match self {
            Self::Coarse => level == 0,
            Self::Medium => level <= 1,
            Self::Fine => true,
        }
    }
}

/// What was measured, and what a spent budget left.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured<P> {
    /// In the order of the plan.
    pub points: Vec<P>,
    /// Measurements that there was no time for.
    pub left: usize,
}

/// The level of each of `count` values along a dial: 0 of both ends, 1 of the value halfway between them, 2 of those halfway in the
/// halves, and so on.
#[must_use]
pub fn levels(count: usize) -> Vec<usize> {
    let mut levels = vec![0; count];
    let mut gaps = vec![[0, count.saturating_sub(1)]];
    for level in 1.. {
        gaps.retain(|[from, to]| to - from > 1);
        if gaps.is_empty() {
            break;
        }
        for [from, to] in std::mem::take(&mut gaps) {
            let middle = from.midpoint(to);
            levels[middle] = level;
            gaps.extend([[from, middle], [middle, to]]);
        }
    }
    levels
}

/// The indices of things that have these levels, coarse ones first; those of one level stay in order.
pub(crate) fn coarse_to_fine(levels: &[usize]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..levels.len()).collect();
    order.sort_by_key(|index| levels[*index]);
    order
}

/// The mean time of the points measured so far, and the time that there is.
pub(crate) struct TimeLeft {
    started: Instant,
    budget: Option<Duration>,
    measured: usize,
}

impl TimeLeft {
    /// Nothing is measured yet; without a budget there is time for everything.
    pub(crate) fn start(budget: Option<Duration>) -> Self {
        Self { started: Instant::now(), budget, measured: 0 }
    }

    /// Points that were begun.
    pub(crate) fn measured(&self) -> usize {
        self.measured
    }

    /// Whether there is no time for another point. There always is for the first.
    pub(crate) fn is_spent(&self) -> bool {
        self.measured > 0 && self.budget.is_some_and(|budget| self.started.elapsed() >= budget)
    }

    /// Shows in the job which point is next, and how long the `left` points, this one included, take at the pace so far, or until the
    /// budget is spent.
    pub(crate) fn next(&mut self, job: &Job, number: usize, total: usize, left: usize) {
        let elapsed = self.started.elapsed();
        let each = (self.measured > 0).then(|| elapsed.as_secs_f64() / self.measured as f64);
        let until_spent = self.budget.map(|budget| budget.saturating_sub(elapsed).as_secs_f64());
        let seconds = each.map(|each| each * left as f64);
        job.set_context(match seconds.map(|seconds| until_spent.map_or(seconds, |most| seconds.min(most))) {
            None => format!("{number} of {total}"),
            Some(seconds) if seconds < 90.0 => format!("{number} of {total}, {seconds:.0} s left"),
            Some(seconds) => format!("{number} of {total}, {:.0} min left", seconds / 60.0),
        });
        self.measured += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn from_coarse_to_fine_each_value_comes_once_the_ends_first_and_then_middles() {
        for count in 0..40 {
            let levels = levels(count);
            let order = coarse_to_fine(&levels);
            let mut sorted = order.clone();
            sorted.sort_unstable();
            assert!(sorted.into_iter().eq(0..count), "{order:?}");
            if count > 1 {
                assert_eq!(order[..2], [0, count - 1]);
            }
            // Nothing is farther from a measured value than before a level is begun.
            for finer in 1..=levels.iter().copied().max().unwrap_or_default() {
                let measured: Vec<_> = (0..count).filter(|index| levels[*index] < finer).collect();
                assert!(
                    measured.windows(2).all(|pair| pair[1] - pair[0] <= count.div_ceil(1 << (finer - 1)))
                );
            }
        }
        assert_eq!(levels(5), [0, 2, 1, 2, 0]);
        assert_eq!(coarse_to_fine(&levels(5)), [0, 4, 2, 1, 3]);
        let takes = |fineness: Fineness| levels(5).into_iter().filter(|level| fineness.takes(*level)).count();
        assert_eq!([Fineness::Coarse, Fineness::Medium, Fineness::Fine].map(takes), [2, 3, 5]);
    }

    #[test]
    fn a_budget_is_spent_once_its_time_is_over_and_never_before_the_first_point() {
        let (job, mut none) = (Job::new(), TimeLeft::start(Some(Duration::ZERO)));
        assert!(!none.is_spent());
        none.next(&job, 1, 9, 9);
        assert!(none.is_spent());
        for budget in [None, Some(Duration::from_hours(1))] {
            let mut much = TimeLeft::start(budget);
            much.next(&job, 1, 9, 9);
            assert!(!much.is_spent());
        }
    }
}
