//! Which settings a sweep tries.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::time::Duration;

use super::external::ExternalPoint;
use super::point::{Point, Series};
use crate::rivals::Rival;
use crate::trial::{Fineness, Thinning, Trial, levels};
use overlook_engine::capture::Capture;
use overlook_engine::error::{Error, Result};
use overlook_engine::settings::{
    AgreementRule, Antialias, Coarse, Fill, Kernel, Magnified, MixedPixels, Precision, PruningMethod,
    RateModel, RenderSettings, Settings, SpanLevels, ValueKind,
};

/// One trial of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Planned {
    /// The trial.
    pub trial: Trial,
    /// What it is.
    pub series: Series,
}

impl Planned {
    /// The settings that it varies, by their paths, and their values as text.
    pub fn dials(&self) -> impl Iterator<Item = (&str, &str)> {
        self.trial.label.split(", ").filter_map(|part| part.split_once(" = "))
    }
}

/// The trials of a sweep, and the points that are known already.
#[derive(Clone, Debug)]
pub struct SweepPlan {
    /// In the order of results; they are measured from coarse to fine.
    pub trials: Vec<Planned>,
    /// The baselines keep as many samples as these settings do.
    pub reference: Settings,
    /// Points of an earlier run on the same capture and truth.
    pub done: Vec<Point>,
    /// Figures of other programs, shown beside what is measured.
    pub external: Vec<ExternalPoint>,
    /// How long may be measured; a measurement that was begun is finished, and there is always one.
    pub budget: Option<Duration>,
}

/// Values of numbers; choices and switches take all of theirs.
const NUMBERS: [(&str, &[f64]); 11] = [
    ("pruning.agreement_margin", &[2.0, 3.0]),
    ("pruning.depth_tolerance", &[0.25, 0.5, 2.0, 4.0, 8.0]),
    ("pruning.normal_tolerance", &[15.0, 60.0]),
    ("pruning.color_tolerance", &[6.0, 12.0, 48.0, 255.0]),
    ("pruning.cosine_floor", &[0.01, 0.03, 0.3]),
    ("spans.color_tolerance", &[1.0, 4.0, 8.0]),
    ("spans.depth_tolerance", &[0.004]),
    ("spans.noise", &[0.0]),
    ("store.depth_precision", &[0.25, 1.0]),
    ("render.depth_tolerance", &[1.0, 16.0]),
    ("render.views", &[1.0, 4.0]),
];

/// Not varied: other methods are baselines, no picture depends on normals in a store, kernels are tried with each variation, and
/// times on two backends are no alternatives of one machine.
const LEFT_OUT: [&str; 5] =
    ["pruning.method", "store.normals", "store.verdicts", "render.kernel", "render.backend"];

/// The sections of settings that samples depend on.
const OF_SAMPLES: [&str; 3] = ["spans", "pruning", "store"];

/// The section of settings that only pictures depend on.
const OF_PICTURES: [&str; 1] = ["render"];

/// The paper's settings, as closely as ours express them: two span levels; the denser of two samples at one place stays, whatever
/// their normals and colors; no noise tolerance, no overlap; a sample covers 2×2 pixels.
#[must_use]
pub fn paper(base: &Settings) -> Settings {
    let mut settings = base.clone();
    settings.spans.levels = SpanLevels::Paper;
    settings.spans.noise = 0.0;
    settings.pruning.method = PruningMethod::HighestRate;
    settings.pruning.rate = RateModel::Paper;
    settings.pruning.normal_tolerance = 90.0;
    settings.pruning.color_tolerance = 255.0;
    settings.pruning.cosine_floor = 0.01;
    settings.pruning.across_spans = false;
    settings.pruning.overlap = false;
    settings.pruning.mixed_pixels = MixedPixels::Keep;
    settings.pruning.agreement = AgreementRule::Off;
    settings.render.kernel = Kernel::Block;
    settings.render.fill = Fill::None;
    settings
}

impl SweepPlan {
    /// The reference, every variation of the samples and every kernel with each, every switch of the renderer, all baselines and all
    /// rivals.
    #[must_use]
    pub fn standard(reference: &Settings, capture: &Capture) -> Self {
        let mut plan = Self::empty(reference);
        plan.add_kernels("default", reference, &KERNELS);
        for (label, settings) in variations(reference) {
            plan.add_kernels(&label, &settings, &KERNELS);
        }
        plan.trials.extend(Self::switches(reference).trials.into_iter().skip(1));
        plan.add_baselines(capture);
        plan
    }

    /// The reference and every combination of the given values; an axis is the path of a setting and its values as text.
    ///
    /// # Errors
    /// `Invalid` for an unknown setting, a value it does not take, and a setting given twice.
    pub fn grid(reference: &Settings, axes: &[(String, Vec<String>)], capture: &Capture) -> Result<Self> {
        let mut combinations = vec![(Vec::new(), reference.clone())];
        for (index, (path, values)) in axes.iter().enumerate() {
            if axes[..index].iter().any(|(before, _)| before == path) {
                return Err(Error::invalid(
                    path,
                    "is varied twice; name all its values at once, as in key=value,value",
                ));
            }
            let mut wider = Vec::new();
            for (labels, settings) in &combinations {
                for value in values {
                    let (mut labels, mut settings) = (Vec::clone(labels), Settings::clone(settings));
                    settings.set_text(&format!("{path}={value}"))?;
                    labels.push(format!("{path} = {value}"));
                    wider.push((labels, settings));
                }
            }
            combinations = wider;
        }
        // Painting varies fastest, so that one set of samples is made once.
        combinations.sort_by_key(|(labels, _)| {
            labels.iter().filter(|label| !label.starts_with("render.")).cloned().collect::<Vec<_>>()
        });
        let list = combinations.into_iter().map(|(labels, settings)| (labels.join(", "), settings));
        Ok(Self::list(reference, list.collect(), capture))
    }

    /// The reference, the given settings under their names, and all baselines.
    #[must_use]
    pub fn list(reference: &Settings, named: Vec<(String, Settings)>, capture: &Capture) -> Self {
        let mut plan = Self::empty(reference);
        plan.add("default", reference.clone());
        for (label, settings) in named {
            plan.add(label, settings);
        }
        plan.add_baselines(capture);
        plan
    }

    /// The reference and every switch of the renderer, without baselines.
    #[must_use]
    pub fn switches(reference: &Settings) -> Self {
        let mut plan = Self::empty(reference);
        plan.add("default", reference.clone());
        for (label, settings) in picture_variations(reference) {
            plan.add(label, settings);
        }
        plan
    }

    /// Settings with their names, which vary a reference.
    pub(crate) fn varying(reference: &Settings, varied: Vec<(String, Settings)>) -> Self {
        let trials = varied.into_iter().map(|(label, settings)| {
            let trial = Trial::new(label, settings);
            Planned { trial, series: Series::Variation }
        });
        Self { trials: trials.collect(), ..Self::empty(reference) }
    }

    fn empty(reference: &Settings) -> Self {
        Self {
            trials: Vec::new(),
            reference: reference.clone(),
            done: Vec::new(),
            external: Vec::new(),
            budget: None,
        }
    }

    /// Keeps the trials of this fineness for which `takes` holds, and the reference.
    pub fn choose(&mut self, fineness: Fineness, takes: impl Fn(&Planned) -> bool) {
        let mut levels = self.levels().into_iter();
        self.trials.retain(|planned| {
            let is_taken = levels.next().is_some_and(|level| fineness.takes(level)) && takes(planned);
            is_taken || planned.series == Series::Reference
        });
    }

    /// How many measurements the plan has that are not known.
    #[must_use]
    pub fn open(&self) -> usize {
        self.trials.iter().filter(|planned| self.known(planned).is_none()).count()
    }

    /// The level of each trial: that of its values among all of the same settings. What varies no setting comes first.
    pub(super) fn levels(&self) -> Vec<usize> {
        let mut values: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        for (path, value) in self.trials.iter().flat_map(Planned::dials) {
            let values = values.entry(path).or_default();
            if !values.contains(&value) {
                values.push(value);
            }
        }
        for values in values.values_mut() {
            // Numbers by their size, names as they come.
            values.sort_by(|a, b| {
                let numbers = a.parse::<f64>().ok().zip(b.parse::<f64>().ok());
                numbers.map_or(Ordering::Equal, |(a, b)| a.total_cmp(&b))
            });
        }
        let level = |(path, value): (&str, &str)| {
            let values = &values[path];
            values.iter().position(|known| *known == value).map_or(0, |index| levels(values.len())[index])
        };
        self.trials.iter().map(|planned| planned.dials().map(level).max().unwrap_or_default()).collect()
    }

    /// When each trial is measured, the earliest first: the reference, other methods, then settings from coarse to fine.
    pub(super) fn rounds(&self) -> Vec<usize> {
        let round = |(planned, level): (&Planned, usize)| match planned.series {
            Series::Reference => 0,
            series if series.is_rival() || series == Series::Paper => 1,
            Series::Variation => 3 + level,
            _ => 2,
        };
        self.trials.iter().zip(self.levels()).map(round).collect()
    }

    /// The point that an earlier run measured for this trial. A baseline with as many samples as the reference is known only if
    /// the reference is known and has that many, because the settings do not hold its reference.
    #[must_use]
    pub fn known(&self, planned: &Planned) -> Option<Point> {
        let Planned { trial, series } = planned;
        let reference = || {
            let is_reference =
                |point: &&Point| point.series == Series::Reference && point.settings == self.reference;
            self.done.iter().find(is_reference)
        };
        let is_same = |point: &&Point| {
            point.label == trial.label
                && point.series == *series
                && point.settings == trial.settings
                && (matches!(trial.thinning, Thinning::None)
                    || reference().is_some_and(|reference| reference.samples == point.samples))
        };
        self.done.iter().find(is_same).cloned()
    }

    /// Adds settings, unless they are there already.
    fn add(&mut self, label: impl Into<String>, settings: Settings) {
        if !self.trials.iter().any(|planned| planned.trial.settings == settings) {
            let series = if settings == self.reference { Series::Reference } else { Series::Variation };
            self.trials.push(Planned { trial: Trial::new(label, settings), series });
        }
    }

    fn add_kernels(&mut self, label: &str, settings: &Settings, kernels: &[Kernel]) {
        for &kernel in kernels {
            let mut settings = settings.clone();
            settings.render.kernel = kernel;
            self.add(format!("{label}, {kernel}"), settings);
        }
    }

    fn add_baselines(&mut self, capture: &Capture) {
        let with_method = |method| {
            let mut settings = self.reference.clone();
            settings.pruning.method = method;
            settings
        };
        let (all, first) = (with_method(PruningMethod::Off), with_method(PruningMethod::FirstCamera));
        let mut add = |series: Series, settings: &Settings, thinning, cameras: Option<Vec<String>>| {
            let mut settings = settings.clone();
            for kernel in [Kernel::Gather, Kernel::Surfel, Kernel::Block] {
                settings.render.kernel = kernel;
                let name = match &cameras {
                    Some(names) => names.join(" and ") + " alone",
                    None => series.name().to_owned(),
                };
                let trial = Trial {
                    label: format!("{name}, {kernel}"),
                    settings: settings.clone(),
                    thinning,
                    cameras: cameras.clone(),
                    rival: None,
                };
                self.trials.push(Planned { trial, series });
            }
        };
        add(Series::Random, &all, Thinning::Random, None);
        add(Series::VoxelGrid, &all, Thinning::VoxelGrid, None);
        add(Series::NoPruning, &all, Thinning::None, None);
        add(Series::FirstCamera, &first, Thinning::None, None);
        add(Series::FirstCameraAtCount, &first, Thinning::Tolerance, None);
        for camera in &capture.cameras {
            add(Series::SingleCamera, &all, Thinning::None, Some(vec![camera.name.clone()]));
        }
        let settings = paper(&self.reference);
        let label = format!("{}, {}", Series::Paper.name(), settings.render.kernel);
        self.trials.push(Planned { trial: Trial::new(label, settings), series: Series::Paper });
        for rival in Rival::ALL {
            let trial = Trial { rival: Some(rival), ..Trial::new(rival.to_string(), self.reference.clone()) };
            self.trials.push(Planned { trial, series: Series::of(rival) });
        }
    }
}

/// The kernels of a sweep, the most accurate first.
const KERNELS: [Kernel; 4] = [Kernel::Gather, Kernel::Surfel, Kernel::Block, Kernel::Point];

/// The reference with one setting changed that samples depend on: every choice and switch of spans, pruning and store but two, and
/// numbers around their defaults. Depth precision is varied only if the reference's store is not lossless, since it has no effect
/// otherwise. New choices and switches are varied without being named here; new numbers are not.
#[must_use]
pub fn variations(reference: &Settings) -> Vec<(String, Settings)> {
    variations_in(&OF_SAMPLES, reference)
}

/// The reference with one switch of the renderer changed, and with all of those off that take time: what a picture costs that samples
/// alone make.
#[must_use]
pub fn picture_variations(reference: &Settings) -> Vec<(String, Settings)> {
    let mut bare = reference.clone();
    bare.render = RenderSettings {
        kernel: reference.render.kernel,
        backend: reference.render.backend,
        depth_tolerance: reference.render.depth_tolerance,
        fill: Fill::None,
        free_space: false,
        views: 1,
        antialias: Antialias::Off,
        coarse: Coarse::Pyramid,
        magnified: Magnified::Direct,
    };
    let mut list = variations_in(&OF_PICTURES, reference);
    if bare != *reference {
        list.push(("renderer: everything off".to_owned(), bare));
    }
    list
}

fn variations_in(sections: &[&str], reference: &Settings) -> Vec<(String, Settings)> {
    let mut assignments: Vec<String> = Vec::new();
    for field in Settings::fields() {
        let section = field.path.split('.').next().unwrap_or_default();
        if !sections.contains(&section) || LEFT_OUT.contains(&field.path) {
            continue;
        }
        if field.path == "store.depth_precision" && reference.store.precision == Precision::Lossless {
            continue;
        }
        match field.kind {
            ValueKind::Choice(choices) => {
                assignments.extend(choices.iter().map(|(name, _)| format!("{} = {name}", field.path)));
            }
            ValueKind::Switch => assignments.extend([true, false].map(|on| format!("{} = {on}", field.path))),
            ValueKind::Number { .. } | ValueKind::Integer { .. } => {
                let values = NUMBERS.iter().find(|(path, _)| *path == field.path).map(|(_, values)| *values);
                let values = values.unwrap_or_default().iter();
                assignments.extend(values.map(|value| format!("{} = {value}", field.path)));
            }
        }
    }
    let changed = |assignment: String| {
        let mut settings = reference.clone();
        settings.set_text(&assignment).ok()?;
        (settings != *reference).then_some((assignment, settings))
    };
    assignments.into_iter().filter_map(changed).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_is_tried_and_the_precision_of_depth_where_it_says_something() {
        let rounded = Settings::default();
        let mut lossless = rounded.clone();
        lossless.set_text("store.precision=lossless").unwrap();
        let paths = |reference: &Settings| -> Vec<String> {
            let path = |(label, _): (String, _)| label.split(' ').next().unwrap_or_default().to_owned();
            variations(reference).into_iter().chain(picture_variations(reference)).map(path).collect()
        };
        let (of_lossless, of_rounded) = (paths(&lossless), paths(&rounded));
        for field in Settings::fields().filter(|field| !LEFT_OUT.contains(&field.path)) {
            if !OF_SAMPLES.iter().chain(&OF_PICTURES).any(|section| field.path.starts_with(section)) {
                continue;
            }
            let is_tried = |paths: &[String]| paths.iter().any(|path| path == field.path);
            assert!(is_tried(&of_rounded), "{}", field.path);
            assert_eq!(is_tried(&of_lossless), field.path != "store.depth_precision", "{}", field.path);
        }
    }
}
