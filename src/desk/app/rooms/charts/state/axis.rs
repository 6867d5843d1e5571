//! What a chart can show along an axis.

use crate::app::model::setting_names::choice;
use crate::text;
use overlook_engine::settings::{Kernel, Settings};
use overlook_lab::chart::Scale;
use overlook_lab::sweep::{Point, Series};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quantity {
    Psnr,
    Ssim,
    Flip,
    Coverage,
    Bytes,
    Samples,
    Milliseconds,
    Seconds,
}

impl Quantity {
    /// Every quantity: name, and the scale of its axis.
    pub(crate) const ALL: [(Self, &'static str, Scale); 8] = [
        (Self::Psnr, "PSNR, holes filled, dB", Scale::Linear),
        (Self::Ssim, "SSIM", Scale::Linear),
        (Self::Flip, "FLIP", Scale::Linear),
        (Self::Coverage, "Coverage", Scale::Linear),
        (Self::Bytes, "Store size", Scale::Log),
        (Self::Samples, "Samples", Scale::Log),
        (Self::Milliseconds, "Rendering a view, ms", Scale::Log),
        (Self::Seconds, "Reading and pruning, s", Scale::Log),
    ];

    pub(crate) fn name(self) -> &'static str {
        Self::ALL.iter().find(|(of, ..)| *of == self).map_or("", |(_, name, _)| name)
    }

    /// Its name with the direction in which it is better, for an axis.
    pub(crate) fn axis_name(self) -> String {
        let better = if self.is_gain() { "higher" } else { "lower" };
        format!("{} ({better} is better)", self.name())
    }

    /// Its unit on paper, where numbers have none of their own.
    fn unit_on_paper(self) -> (&'static str, f64) {
        match self {
            Self::Bytes => (", MB", 1e6),
            Self::Samples => (", thousands", 1e3),
            _ => ("", 1.0),
        }
    }

    pub(crate) fn name_on_paper(self) -> String {
        self.axis_name().replacen(self.name(), &format!("{}{}", self.name(), self.unit_on_paper().0), 1)
    }

    /// Its value in the unit of [`Self::name_on_paper`].
    pub(crate) fn on_paper(self, point: &Point) -> f64 {
        self.value(point) / self.unit_on_paper().1
    }

    pub(crate) fn is_gain(self) -> bool {
        matches!(self, Self::Psnr | Self::Ssim | Self::Coverage)
    }

    /// What is lost by it: better where smaller.
    pub(crate) fn cost(self, point: &Point) -> f64 {
        match self {
            // As the front of the command line has it.
            Self::Bytes => point.bytes_of_samples() as f64,
            _ if self.is_gain() => -self.value(point),
            _ => self.value(point),
        }
    }

    pub(crate) fn words(self, point: &Point) -> String {
        match self {
            Self::Psnr => format!("{:.2}", point.psnr_filled_db),
            Self::Ssim | Self::Flip => format!("{:.3}", self.value(point)),
            Self::Coverage => format!("{:.1} %", 100.0 * point.coverage),
            Self::Bytes => text::bytes(point.bytes),
            Self::Samples => text::count(point.samples),
            Self::Milliseconds | Self::Seconds => text::significant(self.value(point)),
        }
    }

    fn value(self, point: &Point) -> f64 {
        match self {
            Self::Psnr => point.psnr_filled_db,
            Self::Ssim => point.ssim,
            Self::Flip => point.flip,
            Self::Coverage => point.coverage,
            Self::Bytes => point.bytes as f64,
            Self::Samples => point.samples as f64,
            Self::Milliseconds => point.milliseconds,
            Self::Seconds => point.seconds_preprocess,
        }
    }

    pub(crate) fn is_time(self) -> bool {
        matches!(self, Self::Milliseconds | Self::Seconds)
    }

    /// Whether its axis can be logarithmic: it is a size or a time. Decibels are logarithms already.
    pub(crate) fn has_decades(self) -> bool {
        Self::ALL.iter().any(|(of, _, scale)| *of == self && *scale == Scale::Log)
    }

    /// The number at a tick of an axis from `low` to `high`, with its unit; none below zero, where there is nothing to count.
    pub(crate) fn tick_words(self, tick: f64, [low, high]: [f64; 2], scale: Scale) -> String {
        let units: &[&str] = match self {
            _ if tick < 0.0 && !matches!(self, Self::Psnr | Self::Ssim) => return String::new(),
            Self::Bytes => &[" B", " kB", " MB", " GB", " TB"],
            Self::Samples => &["", " k", " M", " G", " T"],
            _ => &[""],
        };
        // Ticks at equal steps share the unit of the largest; those of decades have their own.
        let largest = if scale.is_even(low, high) { high } else { tick };
        let power = (0..units.len()).rfind(|power| largest >= 1000_f64.powi(*power as i32)).unwrap_or(0);
        let [tick, low, high] = [tick, low, high].map(|value| value / 1000_f64.powi(power as i32));
        scale.label(tick, low, high, TICKS) + units[power]
    }
}

/// Ticks that are aimed at.
pub(crate) const TICKS: usize = 6;

/// The coordinate of a value in a plot, of a logarithmic axis the decimal logarithm; `None` where there is none.
pub(crate) fn coordinate(value: f64, scale: Scale) -> Option<f64> {
    let coordinate = if scale == Scale::Log { value.log10() } else { value };
    coordinate.is_finite().then_some(coordinate)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ShownAxis {
    pub quantity: Quantity,
    pub scale: Scale,
}

impl ShownAxis {
    /// The axis of a quantity with the scale that suits it.
    pub(crate) fn of(quantity: Quantity) -> Self {
        Self { quantity, scale: if quantity.has_decades() { Scale::Log } else { Scale::Linear } }
    }

    /// Where a point lies along it; `None` where the axis cannot show it.
    pub(crate) fn at(self, point: &Point) -> Option<f64> {
        coordinate(self.quantity.value(point), self.scale)
    }
}

/// Where a point lies in a chart; `None` where an axis cannot show it.
pub(crate) fn place(axes: [ShownAxis; 2], point: &Point) -> Option<[f64; 2]> {
    Some([axes[0].at(point)?, axes[1].at(point)?])
}

/// The settings that give a point; `None` where samples were thinned or cameras left out besides, so that they do not.
pub(crate) fn settings_alone(point: &Point) -> Option<&Settings> {
    let is_thinned = matches!(
        point.series,
        Series::Random | Series::VoxelGrid | Series::FirstCameraAtCount | Series::SingleCamera
    );
    (!is_thinned && !point.series.is_rival()).then_some(&point.settings)
}

/// The start of a sweep and of a stress test in the window: the settings on the sliders.
pub(crate) const START: &str = "your settings";

/// The line through what no other point beats.
pub(crate) const FRONT: &str = "Pareto front";

/// Name of a series in the window.
pub(crate) fn series_name(series: Series) -> &'static str {
    if series == Series::Reference { START } else { series.name() }
}

/// Name of a kernel in the window.
pub(crate) fn kernel_name(kernel: Kernel) -> String {
    choice("render.kernel", kernel.name())
}

/// Name of a method of a stress test in the window.
pub(crate) fn method_name(method: &str) -> &str {
    match method {
        "ours" => START,
        "paper" => "as in the paper",
        "without defenses" => "noise handling off",
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
    use overlook_lab::sweep::SweepPlan;
    use overlook_lab::trial::TrialResult;

    #[test]
    fn ticks_are_named_in_one_unit_where_their_steps_are_equal_and_never_wrongly() {
        let words = |quantity: Quantity, low: f64, high: f64, scale: Scale| -> Vec<String> {
            let ticks = scale.ticks(low, high, TICKS).into_iter();
            ticks.map(|tick| quantity.tick_words(tick, [low, high], scale)).collect()
        };
        let bytes = |low, high, scale| words(Quantity::Bytes, low, high, scale);
        assert_eq!(bytes(-6e5, 1.1e6, Scale::Linear), ["", "0.0 MB", "0.5 MB", "1.0 MB"]);
        assert_eq!(bytes(900.0, 1.2e6, Scale::Log), ["1 kB", "10 kB", "100 kB", "1 MB"]);
        assert_eq!(bytes(1.234e6, 1.2386e6, Scale::Log)[..2], ["1.234 MB", "1.235 MB"]);
        assert_eq!(words(Quantity::Samples, 0.0, 900.0, Scale::Linear)[..2], ["0", "200"]);
        assert_eq!(words(Quantity::Psnr, -1.0, 1.0, Scale::Linear)[0], "-1.0");
        assert_eq!(coordinate(1000.0, Scale::Log), Some(3.0));
        assert!([0.0, -1.0, f64::NAN, f64::INFINITY].iter().all(|of| coordinate(*of, Scale::Log).is_none()));
        assert_eq!(coordinate(-1.0, Scale::Linear), Some(-1.0));
    }

    #[test]
    fn what_a_sweep_starts_from_is_not_called_the_defaults() {
        let mut settings = Settings::default();
        settings.pruning.depth_tolerance = 2.0;
        let spec = DemoSpec::new("orrery").cameras(2).frames(2).size((16, 12));
        let capture = Demo::new(&spec).unwrap().capture(&settings.capture);
        for planned in SweepPlan::standard(&settings, &capture).trials {
            let point = Point::new(&planned.trial, planned.series, &TrialResult::default());
            assert!(!series_name(point.series).contains("default"), "{:?}", point.series);
            assert!(!point_name(&point).contains("default"), "{}", point.label);
        }
    }
}
