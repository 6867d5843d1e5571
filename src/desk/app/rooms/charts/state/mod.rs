//! What is known of sweeps and stress tests: their points, and what is to be measured.

pub(crate) mod axis;

use std::collections::{BTreeSet, HashSet};
use std::time::{Duration, Instant};

use crate::app::model::scene::{Content, OpenScene, method_of};
use crate::app::rooms::charts::state::axis::{
    Quantity, ShownAxis, kernel_name, place, series_name, settings_alone,
};
use overlook_engine::capture::Capture;
use overlook_engine::error::{Error, Result};
use overlook_engine::plural::counted;
use overlook_engine::settings::{Kernel, Settings};
use overlook_lab::chart::Scale;
use overlook_lab::stress::{Disturbance, StressPlan, StressPoint, distinct};
use overlook_lab::sweep::{self, Planned, Point, Series, SweepPlan};
use overlook_lab::trial::Fineness;
use overlook_lab::truth::Truth;

/// The question what to measure.
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
    /// What is measured of it.
    choice: StudyChoice,
    /// Points that are known, of how many.
    known: (usize, usize),
    /// Whether there is nothing left to measure.
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
    /// Points of the stress test, as they came.
    pub stress: Vec<StressPoint>,
    pub disturbance: String,
    /// Along and up.
    axes: [ShownAxis; 2],
    /// Along which scale the sizes of disturbances lie.
    pub dial_scale: Scale,
    /// Series that are left out of the charts, by their names.
    hidden: HashSet<(Study, String)>,
    /// The question what to measure, while it is open.
    pub question: Option<StudyQuestion>,
    /// What is chosen to be measured of a sweep and of a stress test.
    choices: [StudyChoice; 2],
    /// When the point before came, or measuring began.
    last_point: Option<Instant>,
    /// What the last point of a sweep and of a stress test took, seconds.
    seconds_each: [Option<f64>; 2],
    pub studying: bool,
    /// What is being measured, or was last.
    study: Option<Study>,
    /// The last sweep and the last stress test.
    runs: [Option<StudyRun>; 2],
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
            question: None,
            choices: [StudyChoice::quick(), StudyChoice::quick()],
            last_point: None,
            seconds_each: [None; 2],
            studying: false,
            study: None,
            runs: [None, None],
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

    /// Adds a point of the sweep; `known` are known then, of how many.
    pub(crate) fn add(&mut self, point: Point, known: (usize, usize)) {
        self.sweep.push(point);
        self.note(Study::Sweep, known);
        self.mark_front();
    }

    /// Adds a point of the stress test; `known` are known then, of how many.
    pub(crate) fn add_stressed(&mut self, point: StressPoint, known: (usize, usize)) {
        if std::mem::take(&mut self.is_of_previous_test) {
            self.stress.clear();
        }
        self.stress.push(point);
        // In the order of tables and lines, whatever was measured first.
        let rank = |point: &StressPoint| {
            Disturbance::ALL.iter().position(|disturbance| disturbance.name() == point.disturbance)
        };
        self.stress.sort_by(|a, b| rank(a).cmp(&rank(b)).then(a.dial.total_cmp(&b.dial)));
        self.note(Study::Stress, known);
    }

    fn note(&mut self, study: Study, known: (usize, usize)) {
        let now = Instant::now();
        let before = self.last_point.replace(now);
        self.seconds_each[study as usize] = before.map(|before| (now - before).as_secs_f64());
        if let Some(run) = &mut self.runs[study as usize] {
            run.known = known;
        }
    }

    /// Along and up.
    pub(crate) fn axes(&self) -> [ShownAxis; 2] {
        self.axes
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

    /// What is chosen to be measured.
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
            let is_other = run.as_ref().is_none_or(|run| run.settings != *settings);
            self.is_of_previous_test |= study == Study::Stress && is_other;
            *run = Some(StudyRun { settings: settings.clone(), choice, known: (0, 0), is_complete: false });
        }
        (self.study, self.studying) = (Some(study), true);
        (self.question, self.last_point) = (None, Some(Instant::now()));
        true
    }

    /// The points of the stress test that was begun.
    pub(crate) fn known_stress(&self) -> Vec<StressPoint> {
        if self.is_of_previous_test { Vec::new() } else { self.stress.clone() }
    }

    pub(crate) fn complete(&mut self) {
        if let Some(run) = self.study.and_then(|study| self.runs[study as usize].as_mut()) {
            run.is_complete = true;
        }
    }

    /// What is being measured.
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

    /// Note for a stress test that was made with other settings than `now`; `None` for a current one.
    pub(crate) fn stale_stress_note(&self, now: &Settings) -> Option<&'static str> {
        let made = &self.runs[Study::Stress as usize].as_ref()?.settings;
        if self.is_of_previous_test && !self.stress.is_empty() {
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
        let text = match self.run(study)?.known {
            (0, _) => "Nothing was measured yet.".to_owned(),
            (known, of) => format!("After {known} of {}; Resume measures the rest.", counted(of, "point")),
        };
        Some((format!("{} stopped", study.name()), text))
    }

    /// The point that shows what these settings give.
    pub(crate) fn of(&self, settings: &Settings) -> Option<&Point> {
        self.sweep.iter().find(|point| settings_alone(point) == Some(settings))
    }
}

/// Frames that a stress test in the window looks at: enough for what moves to move.
const FRAMES: usize = 8;

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Study {
    /// Accuracy against cost, over many settings.
    Sweep,
    /// Accuracy against the size of a disturbance.
    Stress,
}

impl Study {
    pub(crate) const ALL: [Self; 2] = [Self::Sweep, Self::Stress];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Sweep => "Sweep",
            Self::Stress => "Stress test",
        }
    }

    /// What its chart is called in commands.
    pub(crate) fn chart_name(self) -> &'static str {
        match self {
            Self::Sweep => "sweep chart",
            Self::Stress => "stress test chart",
        }
    }

    /// Name of the file of its chart.
    pub(crate) fn chart_file(self) -> &'static str {
        match self {
            Self::Sweep => "sweep.pdf",
            Self::Stress => "stress.pdf",
        }
    }

    /// Why no chart of it can be copied or saved.
    pub(crate) fn no_chart(self) -> String {
        format!("There is no {} yet, or all of its series are left out.", self.chart_name())
    }
}

/// What is chosen.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct StudyChoice {
    /// What is not measured: settings by their paths; methods, kernels and disturbances by their names.
    pub left_out: BTreeSet<String>,
    pub fineness: Fineness,
    /// `None` until everything is measured.
    pub budget: Option<Duration>,
}

impl StudyChoice {
    /// The ends and the middle of each setting, with the kernel of the settings alone, for some minutes.
    pub(crate) fn quick() -> Self {
        let left_out = Kernel::ALL.iter().map(|kernel| kernel.name().to_owned()).collect();
        Self { left_out, fineness: Fineness::Medium, budget: Some(Duration::from_mins(3)) }
    }

    /// Whether the same is measured, for however long.
    pub(crate) fn measures_as(&self, other: &Self) -> bool {
        (&self.left_out, self.fineness) == (&other.left_out, other.fineness)
    }

    fn takes(&self, name: &str) -> bool {
        !self.left_out.contains(name)
    }

    /// What is measured of a sweep.
    pub(crate) fn sweep_plan(&self, settings: &Settings, capture: &Capture) -> SweepPlan {
        let mut plan = SweepPlan::standard(settings, capture);
        plan.choose(self.fineness, |planned| {
            let kernel = planned.trial.settings.render.kernel;
            let has_kernel = !planned.series.is_rival() && planned.series != Series::Paper;
            planned.dials().all(|(path, _)| self.takes(path))
                && self.takes(planned.series.name())
                && (!has_kernel || kernel == settings.render.kernel || self.takes(kernel.name()))
        });
        plan.budget = self.budget;
        plan
    }

    /// What is measured of a stress test.
    pub(crate) fn stress_plan(&self, settings: &Settings) -> StressPlan {
        let mut plan = StressPlan::standard(settings).with_rivals(settings);
        plan.disturbances.retain(|disturbance| self.takes(disturbance.name()));
        plan.methods.retain(|method| self.takes(&method.name));
        StressPlan { frames: Some(FRAMES), fineness: self.fineness, budget: self.budget, ..plan }
    }
}

impl Study {
    /// What there is to choose: the title of each group, and the names in it.
    pub(crate) fn groups(self, settings: &Settings, capture: &Capture) -> Vec<(&'static str, Vec<String>)> {
        let owned = |names: &mut dyn Iterator<Item = &str>| names.map(str::to_owned).collect();
        match self {
            Self::Sweep => {
                let plan = SweepPlan::standard(settings, capture);
                let paths = distinct(plan.trials.iter().flat_map(Planned::dials).map(|(path, _)| path));
                let methods = distinct(plan.trials.iter().map(|planned| planned.series));
                let others = Kernel::ALL.iter().filter(|kernel| **kernel != settings.render.kernel);
                let is_method = |of: &Series| !matches!(of, Series::Reference | Series::Variation);
                vec![
                    ("Settings", owned(&mut paths.into_iter())),
                    ("Methods", owned(&mut methods.into_iter().filter(is_method).map(Series::name))),
                    ("Other kernels", owned(&mut others.map(|kernel| kernel.name()))),
                ]
            }
            Self::Stress => {
                let plan = StressPlan::standard(settings).with_rivals(settings);
                let changes = |of: &&Disturbance| of.lacks(capture).is_none();
                let disturbances = plan.disturbances.iter().filter(changes).map(|of| of.name());
                let methods = plan.methods.iter().map(|method| method.name.as_str());
                vec![("Disturbances", owned(&mut { disturbances })), ("Methods", owned(&mut { methods }))]
            }
        }
    }
}

/// What a scene is measured on, and against what.
///
/// # Errors
/// `Invalid` for a store, and where nothing is known to measure against.
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
    use overlook_engine::demo::{Demo, DemoSpec};
    use overlook_lab::trial::{Trial, TrialResult};

    fn point(label: &str, psnr: f64, bytes: u64, seconds: f64) -> Point {
        let trial = Trial::new(label, Settings::default());
        let mut point = Point::new(&trial, Series::Variation, &TrialResult::default());
        (point.psnr_filled_db, point.bytes, point.seconds_preprocess) = (psnr, bytes, seconds);
        point
    }

    #[test]
    fn the_best_are_those_of_the_quantities_that_are_shown() {
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
    }

    #[test]
    fn points_without_a_logarithm_are_left_out_of_logarithmic_axes_alone() {
        let mut charts = Charts::default();
        charts.add(point("free", 20.0, 0, 0.0), (1, 2));
        charts.add(point("good", 30.0, 100, 1.0), (2, 2));
        assert_eq!(charts.front(), [[2.0, 30.0]]);
        let axes = charts.axes();
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
        assert_eq!(charts.stale_stress_note(&settings), None);
        charts.begin(Study::Stress, &settings);
        assert_eq!(charts.stale_stress_note(&settings), None);
        other.render.fill = overlook_engine::settings::Fill::None;
        assert_eq!(charts.stale_stress_note(&other), None, "studies fill all holes alike");
        other.render.kernel = Kernel::Point;
        assert!(charts.stale_stress_note(&other).is_some_and(|words| words.contains("kernel")));
        other.pruning.depth_tolerance = 2.0;
        assert!(charts.stale_stress_note(&other).is_some_and(|words| words.contains("settings")));
    }

    #[test]
    fn samples_that_were_thinned_are_not_what_their_settings_give() {
        let settings = Settings::default();
        let mut charts = Charts::default();
        for series in [Series::Random, Series::SingleCamera, Series::NoPruning, Series::VoxelGrid] {
            let trial = Trial::new(series.name(), settings.clone());
            charts.add(Point::new(&trial, series, &TrialResult::default()), (1, 4));
        }
        assert_eq!(charts.of(&settings).map(|point| point.series), Some(Series::NoPruning));
    }

    #[test]
    fn what_is_left_out_is_not_planned_and_everything_is_the_whole_plan() {
        let settings = Settings::default();
        let spec = DemoSpec::new("orrery").cameras(2).frames(2).size((16, 12));
        let capture = Demo::new(&spec).unwrap().capture(&settings.capture);
        let standard = SweepPlan::standard(&settings, &capture);
        let everything = StudyChoice::default();
        assert_eq!(everything.sweep_plan(&settings, &capture).trials, standard.trials);
        for group in [Study::Sweep, Study::Stress].iter().flat_map(|study| study.groups(&settings, &capture))
        {
            for name in group.1 {
                let choice = StudyChoice { left_out: [name.clone()].into(), ..StudyChoice::default() };
                let sweep = choice.sweep_plan(&settings, &capture).trials.len();
                let stress = choice.stress_plan(&settings);
                let whole = StressPlan::standard(&settings).with_rivals(&settings);
                let fewer = (stress.disturbances.len(), stress.methods.len())
                    < (whole.disturbances.len(), whole.methods.len());
                assert!(sweep < standard.trials.len() || fewer, "{name}");
            }
        }
        let nothing = Study::Sweep.groups(&settings, &capture).into_iter().flat_map(|(_, names)| names);
        let choice = StudyChoice { left_out: nothing.collect(), ..StudyChoice::default() };
        assert_eq!(choice.sweep_plan(&settings, &capture).trials[0].series, Series::Reference);
    }
}
