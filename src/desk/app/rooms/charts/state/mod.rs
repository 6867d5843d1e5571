//! What is known of sweeps, stress tests, tuning and the ranking of cameras: what was measured, and what is to be.

pub(crate) mod axis;
mod choice;

use std::collections::HashSet;
use std::time::Instant;

use crate::app::model::scene::{Content, OpenScene, method_of};
use crate::app::rooms::charts::state::axis::{
    Quantity, ShownAxis, kernel_name, place, series_name, settings_alone,
};
pub(crate) use choice::{Study, StudyChoice};
use overlook_engine::capture::Capture;
use overlook_engine::edits::EditList;
use overlook_engine::error::{Error, Result};
use overlook_engine::plural::counted;
use overlook_engine::settings::Settings;
use overlook_lab::chart::Scale;
use overlook_lab::stress::{Disturbance, StressPlan, StressPoint};
use overlook_lab::sweep::{self, Point, SweepPlan};
use overlook_lab::truth::Truth;
use overlook_lab::tune::{CameraWorth, RankPlan, TunePlan, Tuned};

/// What a study measures.
pub(crate) enum StudyPlan {
    Sweep(SweepPlan),
    Stress(StressPlan),
    Tuning(Box<TunePlan>),
    Ranking(RankPlan),
}

impl StudyPlan {
    /// Measurements that are not known yet.
    pub(crate) fn open(&self, capture: &Capture, truth: &Truth) -> usize {
        match self {
            Self::Sweep(plan) => plan.open(),
            Self::Stress(plan) => plan.open(capture, truth),
            Self::Tuning(plan) => plan.open(),
            Self::Ranking(_) => capture.cameras.len(),
        }
    }
}

/// What a study measured last.
pub(crate) enum Found {
    Sweep(Point),
    Stress(StressPoint),
    Tuning(Point),
    Ranking(CameraWorth),
}

pub(crate) struct StudyQuestion {
    pub study: Study,
    /// What there is to choose: the title of each group, and the names in it.
    pub groups: Vec<(&'static str, Vec<String>)>,
    /// Measurements that the choice takes and that are not known yet.
    pub measurements: usize,
}

/// A sweep or a stress test that was begun.
struct StudyRun {
    /// The settings it starts from.
    settings: Settings,
    choice: StudyChoice,
    /// Points that are known, of how many.
    known: (usize, usize),
    is_complete: bool,
}

impl StudyRun {
    fn is_of(&self, settings: &Settings, choice: &StudyChoice) -> bool {
        self.settings == *settings && self.choice.measures_as(choice)
    }
}

/// What was measured, and how it is shown.
pub(crate) struct Charts {
    /// Points of the sweep, as they came.
    pub sweep: Vec<Point>,
    /// Points of the stress test, in the order of its tables.
    pub stress: Vec<StressPoint>,
    pub disturbance: String,
    /// Along and up; [`Self::set_axes`] sets them.
    pub axes: [ShownAxis; 2],
    /// Along which scale the sizes of disturbances lie.
    pub dial_scale: Scale,
    /// Series that are left out of the charts, by their names.
    hidden: HashSet<(Study, String)>,
    /// Points of tuning, as they came.
    pub tuning: Vec<Point>,
    /// The settings that were found, and the points that they were found by.
    pub tuned: Option<Box<Tuned>>,
    /// What each camera is worth, the most needless first.
    pub ranking: Vec<CameraWorth>,
    /// The edits that the ranked cameras were left by.
    pub ranked_edits: EditList,
    pub hides_ranking: bool,
    pub question: Option<StudyQuestion>,
    choices: [StudyChoice; Study::COUNT],
    /// When the point before came, or measuring began.
    last_point: Option<Instant>,
    /// What the last point of each study took, seconds.
    seconds_each: [Option<f64>; Study::COUNT],
    pub studying: bool,
    /// What is being measured, or was last.
    study: Option<Study>,
    runs: [Option<StudyRun>; Study::COUNT],
    /// Whether the points of the stress test are those of the one before, until the first new one takes their place.
    is_of_previous_test: bool,
}

impl Default for Charts {
    fn default() -> Self {
        Self {
            sweep: Vec::new(),
            stress: Vec::new(),
            disturbance: String::new(),
            axes: [Quantity::Bytes, Quantity::Psnr].map(ShownAxis::of),
            dial_scale: Scale::Linear,
            hidden: HashSet::new(),
            tuning: Vec::new(),
            tuned: None,
            ranking: Vec::new(),
            ranked_edits: EditList::default(),
            hides_ranking: false,
            question: None,
            choices: std::array::from_fn(|_| StudyChoice::quick()),
            last_point: None,
            seconds_each: [None; Study::COUNT],
            studying: false,
            study: None,
            runs: std::array::from_fn(|_| None),
            is_of_previous_test: false,
        }
    }
}

impl Charts {
    /// Those of another scene: how they look and what is chosen to be measured stays.
    pub(crate) fn at_scene(self) -> Self {
        let Self { axes, dial_scale, hidden, choices, .. } = self;
        Self { axes, dial_scale, hidden, choices, ..Self::default() }
    }

    /// Adds what was measured; `known` is known then, of how much.
    pub(crate) fn add(&mut self, found: Found, known: (usize, usize)) {
        let study = match found {
            Found::Sweep(point) => {
                self.sweep.push(point);
                self.mark_front();
                Study::Sweep
            }
            Found::Stress(point) => {
                self.add_stressed(point);
                Study::Stress
            }
            Found::Tuning(point) => {
                self.tuning.push(point);
                Study::Tuning
            }
            Found::Ranking(camera) => {
                self.ranking.push(camera);
                CameraWorth::sort(&mut self.ranking);
                Study::Ranking
            }
        };
        let now = Instant::now();
        let before = self.last_point.replace(now);
        self.seconds_each[study as usize] = before.map(|before| (now - before).as_secs_f64());
        if let Some(run) = &mut self.runs[study as usize] {
            run.known = known;
        }
    }

    fn add_stressed(&mut self, point: StressPoint) {
        if std::mem::take(&mut self.is_of_previous_test) {
            self.stress.clear();
        }
        self.stress.push(point);
        // In the order of tables and lines, whatever was measured first.
        let rank = |point: &StressPoint| {
            Disturbance::ALL.iter().position(|disturbance| disturbance.name() == point.disturbance)
        };
        self.stress.sort_by(|a, b| rank(a).cmp(&rank(b)).then(a.dial.total_cmp(&b.dial)));
    }

    pub(crate) fn set_axes(&mut self, axes: [ShownAxis; 2]) {
        self.axes = axes;
        self.mark_front();
    }

    /// Whether a series of a chart is shown.
    pub(crate) fn shows(&self, study: Study, series: &str) -> bool {
        self.hidden.is_empty() || !self.hidden.contains(&(study, series.to_owned()))
    }

    /// Whether a point of the sweep is shown: its series and its kernel are.
    pub(crate) fn shows_point(&self, point: &Point) -> bool {
        let names = [series_name(point.series), &kernel_name(point.settings.render.kernel)];
        names.iter().all(|name| self.shows(Study::Sweep, name))
    }

    /// Leaves a series out, or shows it again.
    pub(crate) fn toggle(&mut self, study: Study, series: String) {
        let entry = (study, series);
        if !self.hidden.remove(&entry) {
            self.hidden.insert(entry);
        }
    }

    pub(crate) fn choice(&self, study: Study) -> &StudyChoice {
        &self.choices[study as usize]
    }

    pub(crate) fn choose(&mut self, study: Study, choice: StudyChoice) {
        self.choices[study as usize] = choice;
    }

    /// About how long so many measurements take, seconds; `None` until one is made.
    pub(crate) fn seconds_for(&self, study: Study, measurements: usize) -> Option<f64> {
        self.seconds_each[study as usize].map(|each| each * measurements as f64)
    }

    /// Marks which points no other beats in both quantities that are shown.
    fn mark_front(&mut self) {
        let [along, up] = self.axes.map(|axis| axis.quantity);
        sweep::mark_behind_best(&mut self.sweep);
        sweep::mark_pareto(&mut self.sweep, |point| along.cost(point), |point| -up.cost(point));
    }

    /// Settings that no others beat in both quantities that are shown, along the first.
    pub(crate) fn front(&self) -> Vec<[f64; 2]> {
        let best = self.sweep.iter().filter(|point| point.pareto);
        let mut front: Vec<_> = best.filter_map(|point| place(self.axes, point)).collect();
        front.sort_by(|a, b| a[0].total_cmp(&b[0]));
        front
    }

    /// Begins to measure what is chosen from `settings`, or resumes a stopped run of the same. Returns false if nothing is left.
    pub(crate) fn begin(&mut self, study: Study, settings: &Settings) -> bool {
        let choice = self.choices[study as usize].clone();
        let run = &mut self.runs[study as usize];
        let is_same = run.as_ref().is_some_and(|run| run.is_of(settings, &choice));
        if is_same && run.as_ref().is_some_and(|run| run.is_complete) {
            return false;
        }
        if !is_same {
            match study {
                Study::Ranking => self.ranking.clear(),
                Study::Tuning => self.tuned = None,
                Study::Sweep | Study::Stress => {}
            }
            let is_other = run.as_ref().is_none_or(|run| run.settings != *settings);
            self.is_of_previous_test |= study == Study::Stress && is_other;
            *run = Some(StudyRun { settings: settings.clone(), choice, known: (0, 0), is_complete: false });
        }
        (self.study, self.studying) = (Some(study), true);
        (self.question, self.last_point) = (None, Some(Instant::now()));
        true
    }

    /// The points of the stress test that was begun.
    fn known_stress(&self) -> Vec<StressPoint> {
        if self.is_of_previous_test { Vec::new() } else { self.stress.clone() }
    }

    /// What is chosen to be measured from `settings`, and what is known of it.
    pub(crate) fn plan(&self, study: Study, settings: &Settings, capture: &Capture) -> StudyPlan {
        let choice = self.choice(study);
        match study {
            Study::Sweep => {
                let plan = choice.sweep_plan(settings, capture);
                StudyPlan::Sweep(SweepPlan { done: self.sweep.clone(), ..plan })
            }
            Study::Stress => {
                StudyPlan::Stress(StressPlan { done: self.known_stress(), ..choice.stress_plan(settings) })
            }
            Study::Tuning => {
                let plan = choice.tune_plan(settings);
                StudyPlan::Tuning(Box::new(TunePlan { done: self.tuning.clone(), ..plan }))
            }
            Study::Ranking => {
                let (edits, done) = (self.ranked_edits.clone(), self.ranking.clone());
                StudyPlan::Ranking(RankPlan { settings: settings.clone(), edits, done })
            }
        }
    }

    pub(crate) fn complete(&mut self) {
        if let Some(run) = self.study.and_then(|study| self.runs[study as usize].as_mut()) {
            run.is_complete = true;
        }
    }

    pub(crate) fn under_way(&self) -> Option<Study> {
        self.study.filter(|_| self.studying)
    }

    fn run(&self, study: Study) -> Option<&StudyRun> {
        self.runs[study as usize].as_ref()
    }

    /// Whether measuring from `settings` resumes a stopped run.
    pub(crate) fn goes_on(&self, study: Study, settings: &Settings) -> bool {
        let choice = self.choice(study);
        self.run(study).is_some_and(|run| run.known.0 > 0 && !run.is_complete && run.is_of(settings, choice))
    }

    pub(crate) fn made_with(&self, study: Study) -> Option<&Settings> {
        self.run(study).map(|run| &run.settings)
    }

    /// Takes back that cameras were ranked where that was with other edits than these.
    pub(crate) fn rank_with(&mut self, edits: &EditList) {
        if self.ranked_edits != *edits {
            self.ranked_edits = edits.clone();
            self.runs[Study::Ranking as usize] = None;
        }
    }

    /// Note for a study that was made with other settings than `now`; `None` for a current one.
    pub(crate) fn stale_note(&self, study: Study, now: &Settings) -> Option<&'static str> {
        let made = self.made_with(study)?;
        if study == Study::Stress && self.is_of_previous_test && !self.stress.is_empty() {
            Some("Of the test before; the first new point takes their place.")
        } else if method_of(made) != method_of(now) {
            Some("Made with other settings; run it again to see what these give.")
        } else if made.render.kernel != now.render.kernel {
            Some("Made with another kernel; run it again to see what this one gives.")
        } else {
            None
        }
    }

    /// Title and text of the message once measuring was stopped.
    pub(crate) fn stopped(&self) -> Option<(String, String)> {
        let study = self.study.filter(|_| !self.studying)?;
        let unit = if study == Study::Ranking { "camera" } else { "point" };
        let text = match self.run(study)?.known {
            (0, _) => "Nothing was measured yet.".to_owned(),
            (known, of) => format!("After {known} of {}; Resume measures the rest.", counted(of, unit)),
        };
        Some((format!("{} stopped", study.name()), text))
    }

    /// The point that shows what these settings give.
    pub(crate) fn of(&self, settings: &Settings) -> Option<&Point> {
        self.sweep.iter().find(|point| settings_alone(point) == Some(settings))
    }
}

/// What a scene is measured on, and against what; `Invalid` for a store, and where nothing is known to measure against.
pub(crate) fn to_measure(scene: &OpenScene) -> Result<(&Capture, Truth)> {
    let Content::Capture { capture, truth } = &scene.content else {
        return Err(Error::invalid(
            &scene.name,
            "a store holds no source frames to measure against; open its capture",
        ));
    };
    let known = truth.iter().any(|view| view.truth.is_some());
    if !known && capture.cameras.len() < 2 {
        return Err(Error::invalid(
            &scene.name,
            "there is no truth to measure against, and its only camera cannot be left out; record a second camera, or \
             true pictures with a novel/transforms.json beside it",
        ));
    }
    Ok((capture, if known { Truth::Views(truth.clone()) } else { Truth::HoldOut }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use overlook_engine::settings::Kernel;
    use overlook_lab::sweep::Series;
    use overlook_lab::trial::{Fineness, Trial, TrialResult};

    fn point(label: &str, psnr: f64, bytes: u64, seconds: f64) -> Found {
        let trial = Trial::new(label, Settings::default());
        let mut point = Point::new(&trial, Series::Variation, &TrialResult::default());
        (point.psnr_filled_db, point.bytes, point.seconds_preprocess) = (psnr, bytes, seconds);
        Found::Sweep(point)
    }

    #[test]
    fn the_best_are_those_of_the_quantities_that_are_shown_where_axes_can_show_them() {
        let mut charts = Charts::default();
        for (label, psnr, bytes, seconds) in
            [("small", 20.0, 10, 9.0), ("good", 30.0, 1000, 3.0), ("fast", 10.0, 100, 1.0)]
        {
            charts.add(point(label, psnr, bytes, seconds), (1, 3));
        }
        assert_eq!(charts.front(), [[1.0, 20.0], [3.0, 30.0]]);
        // Less of one and more of the other, whichever is along.
        charts.set_axes([Quantity::Psnr, Quantity::Seconds].map(ShownAxis::of));
        let logarithm = 3.0_f64.log10();
        assert_eq!(charts.front(), [[10.0, 0.0], [30.0, logarithm]]);
        assert_eq!(Quantity::Seconds.axis_name(), "Reading and pruning, s (lower is better)");
        // What has no logarithm is left out of logarithmic axes alone.
        let mut charts = Charts::default();
        charts.add(point("free", 20.0, 0, 0.0), (1, 2));
        charts.add(point("good", 30.0, 100, 1.0), (2, 2));
        assert_eq!(charts.front(), [[2.0, 30.0]]);
        let axes = charts.axes;
        charts.set_axes([ShownAxis { scale: Scale::Linear, ..axes[0] }, axes[1]]);
        assert_eq!(charts.front(), [[0.0, 20.0], [100.0, 30.0]]);
    }

    #[test]
    fn another_choice_begins_anew_and_keeps_what_is_known() {
        let (settings, mut charts) = (Settings::default(), Charts::default());
        let coarse = StudyChoice { fineness: Fineness::Coarse, ..StudyChoice::default() };
        charts.choose(Study::Stress, coarse.clone());
        assert!(charts.begin(Study::Stress, &settings) && charts.known_stress().is_empty());
        charts.is_of_previous_test = false;
        charts.complete();
        assert!(!charts.begin(Study::Stress, &settings), "all ends are measured");
        charts.choose(Study::Stress, StudyChoice { budget: None, ..coarse });
        assert!(!charts.begin(Study::Stress, &settings), "for however long");
        charts.choose(Study::Stress, StudyChoice::default());
        assert!(charts.begin(Study::Stress, &settings) && !charts.is_of_previous_test);
    }

    #[test]
    fn what_was_stopped_says_how_far_it_came_and_goes_on_from_there_until_it_is_done() {
        let (settings, mut other) = (Settings::default(), Settings::default());
        other.pruning.depth_tolerance = 2.0;
        let mut charts = Charts::default();
        assert!(charts.begin(Study::Sweep, &settings) && charts.under_way() == Some(Study::Sweep));
        charts.studying = false;
        assert_eq!(charts.stopped().unwrap().1, "Nothing was measured yet.");
        assert!(!charts.goes_on(Study::Sweep, &settings));
        charts.studying = true;
        charts.add(point("first", 20.0, 10, 1.0), (33, 210));
        assert!(charts.stopped().is_none(), "it goes on");
        charts.studying = false;
        let (title, text) = charts.stopped().unwrap();
        assert_eq!((title.as_str(), text.starts_with("After 33 of 210 ")), ("Sweep stopped", true), "{text}");
        assert!(charts.goes_on(Study::Sweep, &settings) && !charts.goes_on(Study::Sweep, &other));
        assert!(!charts.goes_on(Study::Stress, &settings));
        assert!(charts.begin(Study::Sweep, &settings));
        charts.complete();
        assert!(!charts.goes_on(Study::Sweep, &settings) && !charts.begin(Study::Sweep, &settings));
        assert!(charts.begin(Study::Sweep, &other));
    }

    #[test]
    fn a_stress_test_of_other_settings_says_so() {
        let (settings, mut other) = (Settings::default(), Settings::default());
        let mut charts = Charts::default();
        assert_eq!(charts.stale_note(Study::Stress, &settings), None);
        charts.begin(Study::Stress, &settings);
        assert_eq!(charts.stale_note(Study::Stress, &settings), None);
        other.render.fill = overlook_engine::settings::Fill::None;
        assert_eq!(charts.stale_note(Study::Stress, &other), None, "studies fill all holes alike");
        other.render.kernel = Kernel::Point;
        assert!(charts.stale_note(Study::Stress, &other).is_some_and(|words| words.contains("kernel")));
        other.pruning.depth_tolerance = 2.0;
        assert!(charts.stale_note(Study::Stress, &other).is_some_and(|words| words.contains("settings")));
    }

    #[test]
    fn samples_that_were_thinned_are_not_what_their_settings_give() {
        let settings = Settings::default();
        let mut charts = Charts::default();
        for series in [Series::Random, Series::SingleCamera, Series::NoPruning, Series::VoxelGrid] {
            let trial = Trial::new(series.name(), settings.clone());
            charts.add(Found::Sweep(Point::new(&trial, series, &TrialResult::default())), (1, 4));
        }
        assert_eq!(charts.of(&settings).map(|point| point.series), Some(Series::NoPruning));
    }
}
