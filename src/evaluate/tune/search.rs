//! The search for a setting: variations one by one, then those together that save bytes.

use super::{Budget, Plan};
use crate::capture::Capture;
use crate::error::{Error, Result};
use crate::evaluate::pace::Pace;
use crate::evaluate::sweep::{Point, Series, variations};
use crate::evaluate::trial::{Trial, Workbench};
use crate::evaluate::truth::{Recorded, Truth};
use crate::job::Job;
use crate::settings::{Kernel, PruningMethod};

type OnPoint<'a> = Box<dyn FnMut(&Point) + 'a>;

/// A search under way.
pub(super) struct Search<'a> {
    plan: &'a Plan,
    pub(super) job: &'a Job,
    pub(super) truth: &'a Truth,
    workbench: Workbench,
    points: Vec<Point>,
    on_point: OnPoint<'a>,
    pace: Pace,
    /// Points there will be, as far as can be told.
    expected: usize,
}

/// One setting that differs from the start, and what it gave.
struct Change {
    /// As in `spans.levels = off`.
    assignment: String,
    point: Point,
}

impl Change {
    fn path(&self) -> &str {
        self.assignment.split('=').next().unwrap_or_default().trim()
    }
}

impl<'a> Search<'a> {
    pub(super) fn new(
        capture: &Capture,
        plan: &'a Plan,
        truth: &'a Truth,
        job: &'a Job,
        on_point: OnPoint<'a>,
    ) -> Result<Self> {
        let workbench = Workbench::new(&Recorded::undisturbed(capture), truth, &plan.settings, job)?;
        let (points, pace) = (Vec::new(), Pace::start());
        Ok(Self { plan, job, truth, workbench, points, on_point, pace, expected: 0 })
    }

    /// Measures a trial, unless it is known.
    pub(super) fn measure(&mut self, trial: &Trial) -> Result<Point> {
        let is_same = |point: &&Point| point.label == trial.label && point.settings == trial.settings;
        if let Some(point) = self.points.iter().find(is_same) {
            return Ok(point.clone());
        }
        let known = self.plan.done.iter().find(is_same).cloned();
        let point = if let Some(point) = known {
            point
        } else {
            let done = self.points.len();
            let expected = self.expected.max(done + 1);
            self.pace.next(self.job, (done + 1, expected), expected - done);
            let point = Point::new(trial, Series::Variation, &self.workbench.measure(trial, self.job)?);
            (self.on_point)(&point);
            point
        };
        self.points.push(point.clone());
        Ok(point)
    }

    /// The most accurate point so far; of equals the simplest, of these the first.
    pub(super) fn best(&self) -> &Point {
        let better = |a: &&Point, b: &&Point| {
            a.psnr_filled_db.total_cmp(&b.psnr_filled_db).then(simplicity(b).cmp(&simplicity(a)))
        };
        // There is always the point of the settings that the search started from.
        self.points.iter().rev().max_by(better).unwrap_or(&self.points[0])
    }

    /// Accuracy that is good enough, dB.
    pub(super) fn limit_db(&self) -> f64 {
        let best = self.best();
        best.psnr_filled_db - best.psnr_filled_db_se
    }

    /// Everything measured, in order.
    pub(super) fn finish(self) -> Vec<Point> {
        self.points
    }

    /// Finds the setting.
    pub(super) fn choose(&mut self) -> Result<Point> {
        let start = self.plan.settings.clone();
        let variations = variations(&start);
        self.expected = variations.len() + 14;
        self.measure(&Trial::new("start", start.clone()))?;
        let mut everything = start.clone();
        everything.pruning.method = PruningMethod::Off;
        self.measure(&Trial::new("no pruning", everything))?;
        let mut changes = Vec::with_capacity(variations.len());
        for (assignment, settings) in variations {
            let point = self.measure(&Trial::new(assignment.clone(), settings))?;
            changes.push(Change { assignment, point });
        }
        self.combine(changes)?;
        let simplest = self.chosen()?.settings;
        for kernel in [Kernel::Surfel, Kernel::Block, Kernel::Point] {
            let mut settings = simplest.clone();
            settings.render.kernel = kernel;
            self.measure(&Trial::new(format!("chosen so far, {kernel}"), settings))?;
        }
        self.chosen()
    }

    /// Adds one change after the other to the start, those that save most first, and keeps what stays allowed.
    fn combine(&mut self, mut changes: Vec<Change>) -> Result<()> {
        changes.sort_by_key(|change| simplicity(&change.point));
        let mut current = self.points[0].clone();
        let mut labels: Vec<&str> = Vec::new();
        let mut settled: Vec<&str> = Vec::new();
        for change in &changes {
            let saves = simplicity(&change.point) < simplicity(&self.points[0]);
            if settled.contains(&change.path()) || !saves || !self.may_lead_on(&change.point) {
                continue;
            }
            labels.push(&change.assignment);
            let mut settings = current.settings.clone();
            settings.set_text(&change.assignment)?;
            let combined = if labels.len() == 1 {
                change.point.clone()
            } else {
                self.measure(&Trial::new(labels.join(", "), settings))?
            };
            if self.may_lead_on(&combined) && simplicity(&combined) < simplicity(&current) {
                current = combined;
                settled.push(change.path());
            } else {
                labels.pop();
            }
        }
        Ok(())
    }

    /// Whether to go on from a point: it is good enough, or the budget is not met yet.
    fn may_lead_on(&self, point: &Point) -> bool {
        match self.plan.budget {
            None => point.psnr_filled_db >= self.limit_db(),
            Some(budget) => !budget.allows(&self.points[0]),
        }
    }

    /// Of everything measured: the simplest that is good enough, or the most accurate within the budget.
    fn chosen(&self) -> Result<Point> {
        let chosen = match self.plan.budget {
            None => {
                let limit_db = self.limit_db();
                let good = self.points.iter().filter(|point| point.psnr_filled_db >= limit_db);
                good.min_by_key(|point| simplicity(point))
            }
            Some(budget) => {
                let within = self.points.iter().filter(|point| budget.allows(point));
                within.rev().max_by(|a, b| {
                    a.psnr_filled_db.total_cmp(&b.psnr_filled_db).then(simplicity(b).cmp(&simplicity(a)))
                })
            }
        };
        chosen.cloned().ok_or_else(|| self.nothing_within_budget())
    }

    fn nothing_within_budget(&self) -> Error {
        let least =
            |spent: &dyn Fn(&Point) -> f64| self.points.iter().map(spent).fold(f64::INFINITY, f64::min);
        match self.plan.budget {
            Some(budget @ Budget::Milliseconds(milliseconds)) => Error::invalid(
                "budget",
                format!(
                    "no setting paints within {milliseconds} ms; the fastest takes {:.1} ms",
                    least(&|point| budget.spent(point))
                ),
            ),
            Some(budget @ Budget::Bytes(bytes)) => Error::invalid(
                "budget",
                format!(
                    "no setting fits into {bytes} bytes; the smallest takes {:.0}",
                    least(&|point| budget.spent(point))
                ),
            ),
            None => Error::invalid("tuning", "nothing could be measured"),
        }
    }
}

/// Fewest bytes first, then least work: no clock is asked. Of equals, what was measured first is preferred.
fn simplicity(point: &Point) -> (u64, u64) {
    (point.bytes_of_samples(), point.work as u64)
}
