//! The fewest views that show everything, chosen by what each adds.
//!
//! ```text
//! capture ─ align ─▶ points of what each view saw ─▶ which views show each ─▶ order by what each adds ─▶ as many as are needed
//!                                                                               └─ some numbers of them: preprocess, render, score
//! ```
//!
//! Purpose: a walking camera records most surfaces in dozens of views. A few views are enough if they show every surface that any view
//! saw, at half of its sharpness or better. A surface counts once, however many views saw it.
//!
//! [`ViewChoice`](overlook_engine::capture::ViewChoice) is the quick look when a recording is opened: it compares at most 256 views at a
//! few points each, and measures no accuracy. Both take views by the same [`GreedyCover`](overlook_engine::capture::GreedyCover).

mod greedy;
mod surface_points;
#[cfg(test)]
mod tests;
mod visibility;

use serde::{Deserialize, Serialize};

use crate::trial::{MeanEstimate, Trial, Workbench};
use crate::truth::{self, Fold, Truth};
use greedy::Coverage;
use overlook_engine::alignment;
use overlook_engine::capture::{Addition, Capture, TruthView};
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::plural::{counted, either};
use overlook_engine::settings::{AlignSettings, Settings};
use surface_points::seen_points;
use visibility::shown_by_each;

/// The default share of all seen surfaces that the chosen views must show, 0 to 1.
pub const SHOWN_AT_LEAST: f64 = 0.99;

/// Most frames that surface points are taken from.
const FRAMES: usize = 5;

/// A view, and what it adds to the views before it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AddedView {
    /// Its name.
    pub name: String,
    /// The share of all seen surfaces that this view adds, 0 to 1.
    pub adds: f64,
    /// The share of all seen surfaces that this view and those before it show, 0 to 1.
    pub shown: f64,
}

/// Coverage, accuracy and size of a model of the first views.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ViewCount {
    /// Number of views.
    pub views: usize,
    /// The share of all seen surfaces that they show, 0 to 1.
    pub shown: f64,
    /// PSNR over pixels that some view saw, holes filled, dB.
    pub psnr_filled_db: f64,
    /// Its standard error over vantages.
    pub psnr_filled_db_se: f64,
    /// Samples kept of them.
    pub samples: u64,
    /// Bytes of their store.
    pub bytes: u64,
}

/// The views that were chosen, and how coverage and accuracy grow with their number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChosenViews {
    /// All views that add a surface: first the needed ones, then the others, each part in the order of what they add.
    pub order: Vec<AddedView>,
    /// Number of needed views; they come first in `order`.
    pub needed: usize,
    /// Number of views of the capture.
    pub of: usize,
    /// The share of all seen surfaces that the needed views had to show, 0 to 1.
    pub shown_at_least: f64,
    /// Number of surface points that coverage was measured at.
    pub points: usize,
    /// Names of the views that were held out as truth; empty if the truth was given.
    pub left_out: Vec<String>,
    /// Accuracy by number of views; the last entry is of all views that were not held out. Empty without any truth.
    pub accuracy: Vec<ViewCount>,
    /// The result in sentences.
    pub words: Vec<String>,
}

impl ChosenViews {
    /// Names of the needed views; the one that adds most comes first.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.order[..self.needed].iter().map(|view| view.name.as_str())
    }
}

/// Chooses the fewest views that show a share of all seen surfaces, and measures the accuracy of these views and of some fewer.
/// `shown_at_least` is that share, 0 to 1.
///
/// # Errors
/// Those of loading frames and truth, of preprocessing and rendering; `Cancelled`.
pub fn choose_views(
    capture: &Capture,
    settings: &Settings,
    shown_at_least: f64,
    truth: &Truth,
    job: &Job,
) -> Result<ChosenViews> {
    let aligned = alignment::align(capture, &settings.align, job)?;
    let truth = match truth {
        Truth::Views(views) => Truth::Views(truth::views_as_taken(aligned.alignment.as_ref(), views)),
        Truth::HoldOut => Truth::HoldOut,
    };
    // All views together corrected the rig; fewer views must not correct it again.
    let settings = Settings { align: AlignSettings::OFF, ..settings.clone() };
    let capture = aligned.capture;
    let (coverage, points) = coverage(&capture, job)?;
    let (order, count) = coverage.order((shown_at_least * coverage.total as f64).ceil() as u64);
    let needed: Vec<usize> = order[..count].iter().map(|addition| addition.view).collect();
    let mut chosen = ChosenViews {
        order: added_views(&capture, &order, coverage.total),
        needed: count,
        of: capture.cameras.len(),
        shown_at_least,
        points,
        left_out: Vec::new(),
        accuracy: Vec::new(),
        words: Vec::new(),
    };
    drop(coverage);
    if let Some(test) = AccuracyTest::new(&capture, &truth, &needed, &settings, job)? {
        chosen.accuracy = accuracy(&test, &chosen, job)?;
        chosen.left_out = test.left_out;
    }
    job.set_context("");
    chosen.words = words(&chosen);
    Ok(chosen)
}

/// What the views of a capture show, and the number of surface points that this was measured at.
fn coverage(capture: &Capture, job: &Job) -> Result<(Coverage, usize)> {
    let frames: Vec<usize> = truth::evenly_spaced(capture.frame_count(), FRAMES).collect();
    job.start("Looking at views", capture.cameras.len() * (frames.len() + 1));
    let seen = seen_points(capture, &frames, job)?;
    let shown = shown_by_each(capture, &seen, job)?;
    let counts: Vec<usize> = seen.iter().map(|seen| seen.points.len()).collect();
    Ok((Coverage::new(shown, &counts), counts.iter().sum()))
}

/// For each view the share of all seen surfaces that no other view shows, 0 to 1.
///
/// # Errors
/// Those of loading frames, and `Cancelled`.
pub(super) fn shown_alone(capture: &Capture, job: &Job) -> Result<Vec<f64>> {
    let coverage = coverage(capture, job)?.0;
    let total = coverage.total.max(1) as f64;
    Ok(coverage.alone().into_iter().map(|weight| weight as f64 / total).collect())
}

fn added_views(capture: &Capture, order: &[Addition], total: u64) -> Vec<AddedView> {
    let share = |weight: u64| weight as f64 / total.max(1) as f64;
    let mut so_far = 0;
    let view = |addition: &Addition| {
        so_far += addition.added;
        let name = capture.cameras[addition.view].name.clone();
        AddedView { name, adds: share(addition.added), shown: share(so_far) }
    };
    order.iter().map(view).collect()
}

/// Numbers of views that accuracy is measured with: each is half as large again as the one before.
fn numbers(needed: usize) -> Vec<usize> {
    let next = |number: &usize| Some((number + 1).max(number * 3 / 2));
    let mut numbers: Vec<usize> =
        std::iter::successors(Some(1), next).take_while(|number| *number < needed).collect();
    numbers.extend((needed > 0).then_some(needed));
    numbers
}

fn accuracy(test: &AccuracyTest, chosen: &ChosenViews, job: &Job) -> Result<Vec<ViewCount>> {
    let numbers = numbers(chosen.needed);
    let all = test.views();
    let mut counts = Vec::new();
    for number in numbers.iter().copied().chain((all > chosen.needed).then_some(all)) {
        job.set_context(format!("{} of {}", counted(number, "view"), chosen.of));
        let first = chosen.order.get(..number).filter(|_| number <= chosen.needed);
        let names = first.map(|views| views.iter().map(|view| view.name.clone()).collect());
        let found = test.of(names, job)?;
        counts.push(ViewCount {
            views: number,
            // All views count as 1, although a held-out view may have shown a surface that no other view shows.
            shown: first.and_then(<[AddedView]>::last).map_or(1.0, |view| view.shown),
            psnr_filled_db: found.psnr_filled_db.mean,
            psnr_filled_db_se: found.psnr_filled_db.standard_error,
            samples: found.samples,
            bytes: found.bytes,
        });
    }
    Ok(counts)
}

fn words(chosen: &ChosenViews) -> Vec<String> {
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let (needed, of) = (chosen.needed, chosen.of);
    let shown = chosen.order[..needed].last().map_or(0.0, |view| view.shown);
    let mut words = vec![format!(
        "{} of {of} {} {} of all seen surfaces, at half of their sharpness or better.",
        counted(needed, "view"),
        either(needed, "shows", "show"),
        percent(shown),
    )];
    if let Some(first) = chosen.order.first().filter(|_| needed > 1) {
        let last = &chosen.order[needed - 1];
        words.push(format!(
            "'{}' adds {}; '{}', the last one, adds {}.",
            first.name,
            percent(first.adds),
            last.name,
            percent(last.adds)
        ));
    }
    let at = |number: usize| chosen.accuracy.iter().find(|count| count.views == number);
    match (at(needed), chosen.accuracy.last()) {
        (Some(few), Some(all)) if all.views > few.views => words.push(format!(
            "A model of these views has {:.2} dB in {:.2} MB; one of {} has {:.2} dB in {:.2} MB.",
            few.psnr_filled_db,
            few.bytes as f64 / 1e6,
            counted(all.views, "view"),
            all.psnr_filled_db,
            all.bytes as f64 / 1e6,
        )),
        (Some(few), _) => {
            words.push(format!("A model of these views has {:.2} dB.", few.psnr_filled_db));
        }
        _ => words.push("No view is left to measure accuracy at.".to_owned()),
    }
    if !chosen.left_out.is_empty() {
        words.push(format!("Accuracy is measured at held-out views: {}.", chosen.left_out.join(", ")));
    }
    words
}

/// Most views that are held out as truth.
const LEFT_OUT: usize = 8;

/// Accuracy and size of a model of some of the views.
#[derive(Clone, Copy, Debug)]
struct SubsetResult {
    /// PSNR over pixels that some view saw, holes filled, dB.
    psnr_filled_db: MeanEstimate,
    samples: u64,
    bytes: u64,
}

/// The capture and the truth that subsets of its views are measured on.
struct AccuracyTest {
    fold: Fold,
    settings: Settings,
    /// Names of the views that are held out as truth.
    left_out: Vec<String>,
}

impl AccuracyTest {
    /// Loads the truth: the given views, or else some of the views that were not `chosen`. `None` if no view has a known pixel.
    /// `capture` must be corrected already.
    fn new(
        capture: &Capture,
        truth: &Truth,
        chosen: &[usize],
        settings: &Settings,
        job: &Job,
    ) -> Result<Option<Self>> {
        let (rest, views, left_out) = match truth {
            Truth::Views(views) => (capture.clone(), views.clone(), Vec::new()),
            Truth::HoldOut => {
                let others: Vec<usize> =
                    (0..capture.cameras.len()).filter(|view| !chosen.contains(view)).collect();
                let name = |nth: usize| capture.cameras[others[nth]].name.clone();
                let left_out: Vec<String> = truth::evenly_spaced(others.len(), LEFT_OUT).map(name).collect();
                let (rest, views) = truth::split(capture, &left_out)?;
                (rest, views, left_out)
            }
        };
        job.start("Loading the truth", views.len());
        let views: Vec<TruthView> = truth::masked_one_by_one(&rest, views, job)?;
        let fold = Fold { held_out: None, capture: rest, classes: vec![None; views.len()], views };
        let is_any = !fold.views.is_empty();
        Ok(is_any.then(|| Self { fold, settings: settings.clone(), left_out }))
    }

    /// Number of views that a model may be made of.
    fn views(&self) -> usize {
        self.fold.capture.cameras.len()
    }

    /// Measures a model of the named views; without names, of all views that are not held out.
    fn of(&self, names: Option<Vec<String>>, job: &Job) -> Result<SubsetResult> {
        let trial = Trial { cameras: names, ..Trial::new("fewer views", self.settings.clone()) };
        // Each subset is a capture of its own: nothing of the one before can be used again.
        let result = Workbench::on(vec![self.fold.clone()], &self.settings).measure(&trial, job)?;
        let of_vantage = |views: &Vec<(String, crate::metrics::Scores)>| {
            views.iter().map(|(_, scores)| scores.psnr_all_db).collect()
        };
        let vantages: Vec<Vec<f64>> = result.vantages.iter().map(of_vantage).collect();
        Ok(SubsetResult {
            psnr_filled_db: MeanEstimate::over_vantages(&vantages),
            samples: result.samples,
            bytes: result.bytes,
        })
    }
}
