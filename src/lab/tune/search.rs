//! The search for a setting: variations one by one, then those together that save bytes.

use super::choice::{CandidateSetting, LossRule, Reason, most_accurate};
use super::plan::{TuneBudget, TunePlan};
use crate::sweep::{Point, Series};
use crate::trial::{TimeLeft, Trial, Workbench};
use crate::truth::{Recorded, Truth};
use overlook_engine::capture::Capture;
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::plural::counted;
use overlook_engine::preprocess::{BufferedResult, preprocess_buffered};
use overlook_engine::settings::{Kernel, RenderSettings, Settings};
use overlook_engine::store::file::{self, Extras, InputFiles, Provenance};

type OnPoint<'a> = Box<dyn FnMut(&Point) + 'a>;

/// A search under way.
pub(super) struct SettingSearch<'a> {
    plan: &'a TunePlan,
    pub(super) job: &'a Job,
    pub(super) truth: &'a Truth,
    workbench: Workbench,
    stores: WholeStores<'a>,
    points: Vec<Point>,
    on_point: OnPoint<'a>,
    time_left: TimeLeft,
    /// Expected number of points.
    expected: usize,
    /// Whether the settings that the search starts from exceed the budget.
    starts_beyond: bool,
}

/// A setting is not stored whole if its store is expected to exceed this multiple of the budget. The margin covers a rough expectation:
/// the growth from the frames used to the whole capture depends on the setting.
const BYTES_MARGIN: f64 = 1.5;

/// One setting that differs from the start, and what it gave.
struct TriedChange {
    /// As in `spans.levels = off`.
    assignment: String,
    point: Point,
}

impl TriedChange {
    fn path(&self) -> &str {
        self.assignment.split('=').next().unwrap_or_default().trim()
    }
}

impl<'a> SettingSearch<'a> {
    pub(super) fn new(
        capture: &'a Capture,
        plan: &'a TunePlan,
        truth: &'a Truth,
        job: &'a Job,
        on_point: OnPoint<'a>,
    ) -> Result<Self> {
        let workbench = Workbench::new(&Recorded::undisturbed(capture), truth, &plan.settings, job)?;
        let stores = WholeStores::of(plan.whole.as_ref().unwrap_or(capture));
        let (points, time_left) = (Vec::new(), TimeLeft::start(plan.time));
        let (expected, starts_beyond) = (0, false);
        Ok(Self { plan, job, truth, workbench, stores, points, on_point, time_left, expected, starts_beyond })
    }

    /// Measures a trial, unless it is known.
    pub(super) fn measure(&mut self, trial: &Trial) -> Result<Point> {
        let is_same = |point: &&Point| point.is_of(trial);
        if let Some(point) = self.points.iter().find(is_same) {
            return Ok(point.clone());
        }
        let point = if let Some(known) = self.plan.done.iter().find(is_same) {
            known.clone()
        } else {
            let done = self.points.len();
            let expected = self.expected.max(done + 1);
            self.time_left.next(self.job, done + 1, expected, expected - done);
            let point = Point::new(trial, Series::Variation, &self.workbench.measure(trial, self.job)?);
            (self.on_point)(&point);
            point
        };
        self.points.push(point.clone());
        Ok(point)
    }

    /// The most accurate point so far; of equals the simplest, of these the first.
    pub(super) fn best(&self) -> &Point {
        // There is always the point of the initial settings.
        &self.points[most_accurate(&candidates(&self.points)).unwrap_or(0)]
    }

    /// What may be given up of the best, dB.
    pub(super) fn at_most_db(&self) -> f64 {
        self.plan.at_most_db
    }

    /// The rule that settings are chosen by.
    fn rule(&self) -> LossRule {
        LossRule { at_most_db: self.plan.at_most_db, comparisons: self.expected }
    }

    /// Whether a point surely gives up no more than the plan allows.
    pub(super) fn is_good_enough(&self, point: &Point) -> bool {
        self.rule().is_good_enough(&point.views, &self.best().views)
    }

    /// Whether there are too few vantages to choose by, so that the search ends at its first setting.
    pub(super) fn cannot_tell(&self) -> bool {
        matches!(self.rule().choose(&candidates(&self.points)), Some((_, Reason::CannotTell)))
    }

    /// Everything measured, in order.
    pub(super) fn finish(self) -> Vec<Point> {
        self.points
    }

    /// Finds the setting.
    pub(super) fn choose(&mut self) -> Result<Point> {
        let trials = self.plan.first_trials();
        self.expected = trials.len() + 12;
        let first = self.measure(&trials[0])?;
        self.starts_beyond = !self.is_within_budget(&first)?;
        self.measure(&trials[1])?;
        let mut changes = Vec::with_capacity(trials.len());
        for trial in &trials[2..] {
            if self.time_left.is_spent() {
                break;
            }
            let point = self.measure(trial)?;
            changes.push(TriedChange { assignment: trial.label.clone(), point });
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

    /// Combines changes, those that save most first, as long as the result stays acceptable.
    fn combine(&mut self, mut changes: Vec<TriedChange>) -> Result<()> {
        changes.sort_by_key(|change| simplicity(&change.point));
        let mut current = self.points[0].clone();
        let mut labels: Vec<&str> = Vec::new();
        let mut decided: Vec<&str> = Vec::new();
        for change in &changes {
            let saves = simplicity(&change.point) < simplicity(&self.points[0]);
            if decided.contains(&change.path()) || !saves || !self.may_lead_on(&change.point) {
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
                decided.push(change.path());
            } else {
                labels.pop();
            }
        }
        Ok(())
    }

    /// Whether to continue from a point: it is good enough, or the budget is not met yet.
    fn may_lead_on(&self, point: &Point) -> bool {
        match self.plan.budget {
            None => self.is_good_enough(point),
            Some(_) => self.starts_beyond,
        }
    }

    fn is_within_budget(&mut self, point: &Point) -> Result<bool> {
        Ok(match self.plan.budget {
            None => true,
            Some(TuneBudget::Milliseconds(milliseconds)) => point.milliseconds <= milliseconds,
            Some(TuneBudget::Bytes(bytes)) => {
                // The frames used are part of the whole.
                point.bytes_of_samples() <= bytes
                    && self.expected_bytes(point)? <= BYTES_MARGIN * bytes as f64
                    && self.bytes_whole(&point.settings)? <= bytes
            }
        })
    }

    /// Bytes that the store of the whole capture takes at most.
    pub(super) fn bytes_whole(&mut self, settings: &Settings) -> Result<u64> {
        self.stores.bytes(settings, self.job)
    }

    /// Bytes of the whole capture's store if it grows as that of the first point does.
    fn expected_bytes(&mut self, point: &Point) -> Result<f64> {
        let start = self.plan.settings.clone();
        let growth = self.bytes_whole(&start)? as f64 / self.points[0].bytes.max(1) as f64;
        Ok(point.bytes as f64 * growth)
    }

    /// Among everything measured, the simplest that is good enough, or the most accurate within the budget.
    fn chosen(&mut self) -> Result<Point> {
        if self.plan.budget.is_none() {
            let chosen = self.rule().choose(&candidates(&self.points));
            return chosen
                .map(|(nth, _)| self.points[nth].clone())
                .ok_or_else(|| Error::invalid("tuning", "nothing could be measured"));
        }
        let mut best_first = self.points.clone();
        best_first.sort_by(|a, b| {
            b.psnr_filled_db.total_cmp(&a.psnr_filled_db).then(simplicity(a).cmp(&simplicity(b)))
        });
        for point in best_first {
            if self.is_within_budget(&point)? {
                return Ok(point);
            }
        }
        Err(self.nothing_within_budget()?)
    }

    fn nothing_within_budget(&mut self) -> Result<Error> {
        let what = match self.plan.budget {
            Some(TuneBudget::Bytes(bytes)) => {
                let smallest = self.points.iter().min_by_key(|point| simplicity(point)).cloned();
                if let Some(smallest) = smallest {
                    self.bytes_whole(&smallest.settings)?;
                }
                let least = self.stores.least().unwrap_or_default();
                format!(
                    "no setting fits into {}; the smallest store of the whole capture takes {least}",
                    counted(bytes, "byte")
                )
            }
            Some(TuneBudget::Milliseconds(milliseconds)) => {
                let times = self.points.iter().map(|point| point.milliseconds);
                let least = times.fold(f64::INFINITY, f64::min);
                format!("no setting renders within {milliseconds} ms; the fastest takes {least:.1} ms")
            }
            None => "nothing could be measured".to_owned(),
        };
        Ok(Error::invalid("budget", what))
    }
}

/// Points as the rule compares them.
fn candidates(points: &[Point]) -> Vec<CandidateSetting<'_>> {
    points.iter().map(candidate).collect()
}

fn candidate(point: &Point) -> CandidateSetting<'_> {
    CandidateSetting { views: &point.views, psnr_filled_db: point.psnr_filled_db, cost: simplicity(point) }
}

/// Fewest bytes first, then least work: no clock, so that runs agree. The first measured of equals is preferred.
fn simplicity(point: &Point) -> (u64, u64) {
    (point.bytes_of_samples(), point.work as u64)
}

/// Stores of one capture, by their settings.
pub(super) struct WholeStores<'a> {
    capture: &'a Capture,
    /// Settings but for those of painting, and bytes.
    known: Vec<(Settings, u64)>,
}

impl<'a> WholeStores<'a> {
    pub(super) fn of(capture: &'a Capture) -> Self {
        Self { capture, known: Vec::new() }
    }

    /// Bytes that the store takes at most.
    pub(super) fn bytes(&mut self, settings: &Settings, job: &Job) -> Result<u64> {
        let of_samples = Settings { render: RenderSettings::default(), ..settings.clone() };
        let known = self.known.iter().find(|(known, _)| *known == of_samples).map(|(_, bytes)| *bytes);
        let bytes = known.map_or_else(|| most_bytes(self.capture, &of_samples, job), Ok)?;
        if known.is_none() {
            self.known.push((of_samples.clone(), bytes));
        }
        // A store also holds the settings of rendering; chunks are padded to even lengths.
        let words = |settings: &Settings| settings.to_toml().len().next_multiple_of(2) as u64;
        Ok(bytes - words(&of_samples) + words(settings))
    }

    /// The fewest bytes so far.
    pub(super) fn least(&self) -> Option<u64> {
        self.known.iter().map(|(_, bytes)| *bytes).min()
    }
}

/// Bytes of the store, with the longest record of where it comes from.
fn most_bytes(capture: &Capture, settings: &Settings, job: &Job) -> Result<u64> {
    let folder = tempfile::tempdir().map_err(|error| Error::io(std::env::temp_dir(), error))?;
    let BufferedResult { outline, images, verdicts, report } = preprocess_buffered(capture, settings, job)?;
    let inputs = InputFiles { files: u64::MAX, bytes: u64::MAX, crc32: u32::MAX };
    let provenance = Provenance { inputs: Some(inputs), ..Provenance::default() };
    let extras = Extras { report: report.to_json()?, provenance, verdicts, ..Extras::default() };
    let path = folder.path().join("whole.ovl");
    file::write_spooled(&path, &outline, &images, &extras, job)
}
