//! Settings: the sliders, their histograms, presets, and settings as they were.

mod control;
pub(crate) mod ui;
pub(crate) mod work;

use overlook_engine::settings::{
    Field, Fill, Kernel, MixedPixels, PruningMethod, RateModel, Settings, SpanLevels, ValueKind,
};

type Preset = (&'static str, &'static str, fn(&mut Settings));

/// Settings to start from: name, purpose, and changes of the defaults.
pub(crate) const PRESETS: [Preset; 6] = [
    ("Balanced", "The defaults.", |_| {}),
    (
        "As in the paper",
        "Static or per-frame samples, the printed r, no overlap at depth edges, edge-blended pixels kept, 2×2 blending, holes left open.",
        |settings| {
            settings.spans.levels = SpanLevels::Paper;
            settings.pruning.rate = RateModel::Paper;
            settings.pruning.overlap = false;
            settings.pruning.mixed_pixels = MixedPixels::Keep;
            settings.render.kernel = Kernel::Block;
            settings.render.fill = Fill::None;
        },
    ),
    ("Conservative", "Drops only what agrees closely in depth, normal and color.", |settings| {
        settings.pruning.depth_tolerance = 0.5;
        settings.pruning.normal_tolerance = 15.0;
        settings.pruning.color_tolerance = 10.0;
        settings.spans.color_tolerance = 1.0;
    }),
    ("Aggressive", "Drops all that is nearly shown elsewhere: small files.", |settings| {
        settings.pruning.depth_tolerance = 2.5;
        settings.pruning.normal_tolerance = 50.0;
        settings.pruning.color_tolerance = 64.0;
        settings.spans.color_tolerance = 8.0;
        settings.pruning.overlap = false;
    }),
    (
        "First camera wins",
        "Keeps what a layered depth image keeps, without regard to sampling rates.",
        |settings| {
            settings.pruning.method = PruningMethod::FirstCamera;
        },
    ),
    (
        "Keep everything",
        "No pruning, neither over time nor between cameras: the reference for all others.",
        |settings| {
            settings.pruning.method = PruningMethod::Off;
            settings.spans.levels = SpanLevels::Off;
        },
    ),
];

/// The defaults with a change.
pub(crate) fn changed(change: fn(&mut Settings)) -> Settings {
    let mut settings = Settings::default();
    change(&mut settings);
    settings
}

/// Bars of a histogram.
pub(crate) const BARS: usize = 56;

/// Lower end of logarithmic axes that begin at 0, as a share of the upper end.
const SMALLEST_SHARE: f64 = 1e-4;

/// The axis of a threshold: that of its slider. On a logarithmic one both ends are above 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ThresholdAxis {
    pub min: f64,
    pub max: f64,
    pub log: bool,
}

impl ThresholdAxis {
    /// The axis of a setting; `None` where it is no number.
    pub(crate) fn of(field: &Field) -> Option<Self> {
        let ValueKind::Number { min, max, log } = field.kind else { return None };
        let min = if log { min.max(max * SMALLEST_SHARE) } else { min };
        Some(Self { min, max, log })
    }

    /// The position of a value on the axis, 0 to 1.
    pub(crate) fn position(self, value: f64) -> f32 {
        let value = value.clamp(self.min, self.max);
        let share = if self.log {
            (value / self.min).ln() / (self.max / self.min).ln()
        } else {
            (value - self.min) / (self.max - self.min)
        };
        share as f32
    }

    /// The value at a position.
    pub(crate) fn exact_value(self, position: f32) -> f64 {
        let share = f64::from(position.clamp(0.0, 1.0));
        if self.log {
            self.min * (self.max / self.min).powf(share)
        } else {
            self.min + (self.max - self.min) * share
        }
    }

    /// The value at a position, rounded to three digits.
    pub(crate) fn value(self, position: f32) -> f64 {
        let value = self.exact_value(position);
        let unit = 10_f64.powf(value.abs().max(1e-12).log10().floor() - 2.0);
        ((value / unit).round() * unit).clamp(self.min, self.max)
    }
}

/// The settings that cut something that is counted here.
pub(crate) const CUT: [&str; 5] = [
    "pruning.depth_tolerance",
    "pruning.normal_tolerance",
    "pruning.color_tolerance",
    "spans.color_tolerance",
    "spans.depth_tolerance",
];

/// A quantity over many pixels, cut by a threshold.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ThresholdHistogram {
    /// The setting that cuts it.
    pub path: &'static str,
    /// What is counted.
    pub of: &'static str,
    /// Per bar: what passes all rules, and what does not.
    pub bars: Vec<[u32; 2]>,
    /// Every value, ascending.
    sorted: Vec<f32>,
    /// The counted frame; `None` if all frames are counted.
    pub frame: Option<usize>,
    /// The largest value that measured noise explains, in the unit of the axis; `None` without measured noise.
    pub noise: Option<f32>,
}

impl ThresholdHistogram {
    /// Counts values, each with whether it passes all rules; `None` where the setting is no number.
    pub(crate) fn new(
        path: &'static str,
        of: &'static str,
        noise: Option<f32>,
        values: Vec<(f32, bool)>,
    ) -> Option<Self> {
        let axis = Settings::fields().find(|field| field.path == path).and_then(ThresholdAxis::of)?;
        let mut bars = vec![[0; 2]; BARS];
        let mut sorted = Vec::with_capacity(values.len());
        for (value, passes) in values.into_iter().filter(|(value, _)| !value.is_nan()) {
            let bar = (axis.position(f64::from(value)) * BARS as f32) as usize;
            bars[bar.min(BARS - 1)][usize::from(!passes)] += 1;
            sorted.push(value);
        }
        sorted.sort_unstable_by(f32::total_cmp);
        Some(Self { path, of, bars, sorted, frame: None, noise: noise.filter(|noise| *noise > 0.0) })
    }

    /// Whether anything was counted.
    pub(crate) fn is_empty(&self) -> bool {
        self.sorted.is_empty()
    }

    /// The number of values within a threshold, or what noise explains beyond it, and of the others.
    pub(crate) fn sides(&self, threshold: f64) -> (usize, usize) {
        let threshold = threshold.max(f64::from(self.noise.unwrap_or_default()));
        let within = self.sorted.partition_point(|value| f64::from(*value) <= threshold);
        (within, self.sorted.len() - within)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_is_valid_and_different() {
        let all = PRESETS.map(|(name, _, change)| {
            let settings = changed(change);
            settings.validate(name).unwrap();
            settings
        });
        for (i, a) in all.iter().enumerate() {
            assert!(all[i + 1..].iter().all(|b| a != b), "{}", PRESETS[i].0);
        }
    }

    fn axis(path: &str) -> ThresholdAxis {
        Settings::fields().find(|field| field.path == path).and_then(ThresholdAxis::of).unwrap()
    }

    #[test]
    fn a_place_on_the_axis_and_its_value_belong_together() {
        for path in ["pruning.depth_tolerance", "pruning.normal_tolerance", "spans.depth_tolerance"] {
            let axis = axis(path);
            for step in 0..=20 {
                let position = step as f32 / 20.0;
                let again = axis.position(axis.value(position));
                assert!((again - position).abs() < 0.01, "{path}: {position} {again}");
            }
        }
    }

    #[test]
    fn every_value_lies_on_one_side_of_the_threshold() {
        let values = (0..100).map(|i| (i as f32, i < 40)).chain([(f32::NAN, true)]).collect();
        let histogram = ThresholdHistogram::new("pruning.normal_tolerance", "tests", None, values).unwrap();
        assert_eq!(histogram.sides(29.5), (30, 70));
        assert_eq!(histogram.bars.iter().flatten().sum::<u32>(), 100);
        assert_eq!(histogram.bars.iter().map(|bar| bar[0]).sum::<u32>(), 40);
    }
}
