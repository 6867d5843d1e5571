//! What can be measured, and what is chosen of it.

use std::collections::BTreeSet;
use std::time::Duration;

use crate::app::model::window::DockView;
use overlook_engine::capture::Capture;
use overlook_engine::settings::{Kernel, Settings};
use overlook_lab::stress::{Disturbance, StressPlan, distinct};
use overlook_lab::sweep::{Planned, Series, SweepPlan};
use overlook_lab::trial::Fineness;
use overlook_lab::tune::TunePlan;

/// Frames that a stress test in the window looks at: enough for what moves to move.
const FRAMES: usize = 8;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Study {
    /// Accuracy against cost, over many settings.
    Sweep,
    /// Accuracy against the size of a disturbance.
    Stress,
    /// The smallest model that is good enough.
    Tuning,
    /// What the model would be without each camera.
    Ranking,
}

impl Study {
    pub(super) const COUNT: usize = Self::Ranking as usize + 1;

    /// Those that are drawn as charts.
    pub(crate) const CHARTS: [Self; 2] = [Self::Sweep, Self::Stress];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Sweep => "Sweep",
            Self::Stress => "Stress test",
            Self::Tuning => "Tuning",
            Self::Ranking => "Ranking of cameras",
        }
    }

    /// The view that shows it.
    pub(crate) fn view(self) -> DockView {
        match self {
            Self::Sweep => DockView::Tradeoff,
            Self::Stress => DockView::Stability,
            Self::Tuning => DockView::Tuning,
            Self::Ranking => DockView::Cameras,
        }
    }

    /// What its chart is called in commands.
    pub(crate) fn chart_name(self) -> String {
        format!("{} chart", self.name().to_lowercase())
    }

    pub(crate) fn chart_file(self) -> &'static str {
        if self == Self::Stress { "stress.pdf" } else { "sweep.pdf" }
    }

    /// Why no chart of it can be copied or saved.
    pub(crate) fn no_chart(self) -> String {
        format!("There is no {} yet, or all of its series are left out.", self.chart_name())
    }
}

/// What of a study is chosen to be measured.
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

    pub(crate) fn stress_plan(&self, settings: &Settings) -> StressPlan {
        let mut plan = StressPlan::standard(settings).with_rivals(settings);
        plan.disturbances.retain(|disturbance| self.takes(disturbance.name()));
        plan.methods.retain(|method| self.takes(&method.name));
        StressPlan { frames: Some(FRAMES), fineness: self.fineness, budget: self.budget, ..plan }
    }

    pub(crate) fn tune_plan(&self, settings: &Settings) -> TunePlan {
        let (left_out, fineness) = (self.left_out.clone(), self.fineness);
        TunePlan { left_out, fineness, time: self.budget, ..TunePlan::of(settings.clone()) }
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
            Self::Tuning => {
                let varied = TunePlan::of(settings.clone()).first_trials();
                let paths = varied.iter().filter_map(|trial| trial.label.split_once(" = "));
                vec![("Settings", owned(&mut distinct(paths.map(|(path, _)| path)).into_iter()))]
            }
            Self::Ranking => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use overlook_engine::demo::{Demo, DemoSpec};

    #[test]
    fn what_is_left_out_is_not_planned_and_everything_is_the_whole_plan() {
        let settings = Settings::default();
        let spec = DemoSpec::new("orrery").cameras(2).frames(2).size((16, 12));
        let capture = Demo::new(&spec).unwrap().capture(&settings.capture);
        let standard = SweepPlan::standard(&settings, &capture);
        let everything = StudyChoice::default();
        assert_eq!(everything.sweep_plan(&settings, &capture).trials, standard.trials);
        let stress_size = |plan: StressPlan| plan.disturbances.len() * plan.methods.len();
        for study in [Study::Sweep, Study::Stress, Study::Tuning] {
            let size = |choice: &StudyChoice| match study {
                Study::Sweep => choice.sweep_plan(&settings, &capture).trials.len(),
                Study::Stress => stress_size(choice.stress_plan(&settings)),
                _ => choice.tune_plan(&settings).first_trials().len(),
            };
            for name in study.groups(&settings, &capture).into_iter().flat_map(|(_, names)| names) {
                let choice = StudyChoice { left_out: [name.clone()].into(), ..StudyChoice::default() };
                assert!(size(&choice) < size(&everything), "{name}");
            }
        }
        let nothing = Study::Sweep.groups(&settings, &capture).into_iter().flat_map(|(_, names)| names);
        let choice = StudyChoice { left_out: nothing.collect(), ..StudyChoice::default() };
        assert_eq!(choice.sweep_plan(&settings, &capture).trials[0].series, Series::Reference);
    }
}
