//! What sweeps and stress tests have measured so far, how far they came, and how it is shown.

use super::axis::Quantity;
use crate::app::model::results::method_of;
use overlook_engine::plural::counted;
use overlook_engine::settings::Settings;
use overlook_lab::stress::StressPoint;
use overlook_lab::sweep::{self, Point, Series};

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Study {
    /// Accuracy against cost, over many settings.
    Sweep,
    /// Accuracy against the size of a disturbance.
    Stress,
}

impl Study {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Sweep => "Sweep",
            Self::Stress => "Stress test",
        }
    }
}

/// A sweep or a stress test that was begun.
struct StudyRun {
    /// The settings it starts from.
    settings: Settings,
    /// Points that are known, of how many.
    known: (usize, usize),
    /// Whether there is nothing left to measure.
    is_complete: bool,
}

/// What was measured, and how it is shown.
pub(crate) struct Charts {
    /// Points of the sweep, as they came.
    pub sweep: Vec<Point>,
    /// Points of the stress test, as they came.
    pub stress: Vec<StressPoint>,
    pub disturbance: String,
    /// Along and up.
    axes: [Quantity; 2],
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
            axes: [Quantity::Bytes, Quantity::Psnr],
            studying: false,
            study: None,
            runs: [None, None],
            is_of_previous_test: false,
        }
    }
}

impl Charts {
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
        self.note(Study::Stress, known);
    }

    fn note(&mut self, study: Study, known: (usize, usize)) {
        if let Some(run) = &mut self.runs[study as usize] {
            run.known = known;
        }
    }

    /// Along and up.
    pub(crate) fn axes(&self) -> [Quantity; 2] {
        self.axes
    }

    pub(crate) fn set_axes(&mut self, axes: [Quantity; 2]) {
        self.axes = axes;
        self.mark_front();
    }

    /// Marks which points no other beats in both quantities that are shown.
    fn mark_front(&mut self) {
        let [along, up] = self.axes;
        sweep::mark_behind_best(&mut self.sweep);
        sweep::mark_pareto(&mut self.sweep, |point| along.cost(point), |point| -up.cost(point));
    }

    /// Settings that no others beat in both quantities that are shown, along the first.
    pub(crate) fn front(&self) -> Vec<[f64; 2]> {
        let best = self.sweep.iter().filter(|point| point.pareto);
        let mut front: Vec<_> = best.map(|point| self.axes.map(|quantity| quantity.of(point))).collect();
        front.sort_by(|a, b| a[0].total_cmp(&b[0]));
        front
    }

    /// Begins to measure from `settings`, or resumes a stopped run of the same. Returns false if nothing is left.
    pub(crate) fn begin(&mut self, study: Study, settings: &Settings) -> bool {
        let run = &mut self.runs[study as usize];
        let known = run.as_ref().filter(|run| run.settings == *settings);
        if known.is_some_and(|run| run.is_complete) {
            return false;
        }
        if known.is_none() {
            *run = Some(StudyRun { settings: settings.clone(), known: (0, 0), is_complete: false });
            if study == Study::Stress {
                self.is_of_previous_test = true;
            }
        }
        (self.study, self.studying) = (Some(study), true);
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
        self.run(study).is_some_and(|run| run.known.0 > 0 && !run.is_complete && run.settings == *settings)
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

/// The settings that give a point; `None` where samples were thinned or cameras left out besides, so that they do not.
pub(crate) fn settings_alone(point: &Point) -> Option<&Settings> {
    let more_was_done = matches!(
        point.series,
        Series::Random | Series::VoxelGrid | Series::FirstCameraAtCount | Series::SingleCamera
    );
    let more_was_done = more_was_done || point.series.is_rival();
    (!more_was_done).then_some(&point.settings)
}

/// The start of a sweep in the window: the settings on the sliders.
const START: &str = "settings it started from";

/// Name of a series in the window.
pub(crate) fn series_name(series: Series) -> &'static str {
    if series == Series::Reference { START } else { series.name() }
}

/// Name of a method of a stress test in the window.
pub(crate) fn method_name(method: &str) -> &str {
    match method {
        "ours" => START,
        "paper" => "as in the paper",
        other => other,
    }
}

/// Name of a point in the window.
pub(crate) fn point_name(point: &Point) -> String {
    point
        .label
        .strip_prefix("default, ")
        .map_or_else(|| point.label.clone(), |kernel| format!("{START}, {kernel}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use overlook_engine::demo::{Demo, DemoSpec};
    use overlook_lab::trial::{Trial, TrialResult};

    #[test]
    fn what_a_sweep_starts_from_is_not_called_the_defaults() {
        let mut settings = Settings::default();
        settings.pruning.depth_tolerance = 2.0;
        let spec = DemoSpec::new("orrery").cameras(2).frames(2).size((16, 12));
        let capture = Demo::new(&spec).unwrap().capture(&settings.capture);
        for planned in sweep::SweepPlan::standard(&settings, &capture).trials {
            let point = Point::new(&planned.trial, planned.series, &TrialResult::default());
            assert!(!series_name(point.series).contains("default"), "{:?}", point.series);
            assert!(!point_name(&point).contains("default"), "{}", point.label);
        }
    }

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
        charts.set_axes([Quantity::Psnr, Quantity::Seconds]);
        let logarithm = 3.0_f64.log10();
        assert_eq!(charts.front(), [[10.0, 0.0], [30.0, logarithm]]);
        assert_eq!(Quantity::Seconds.axis_name(), "Preprocessing, s (lower is better)");
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
        other.render.kernel = overlook_engine::settings::Kernel::Point;
        assert!(charts.stale_stress_note(&other).is_some_and(|words| words.contains("kernel")));
        other.pruning.depth_tolerance = 2.0;
        assert!(charts.stale_stress_note(&other).is_some_and(|words| words.contains("settings")));
        assert_eq!(
            ["ours", "paper", "without defenses"].map(method_name),
            [START, "as in the paper", "without defenses"]
        );
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
}
