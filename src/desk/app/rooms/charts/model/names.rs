//! What points, series and methods are called in the window, and which settings give a point.

use crate::app::rooms::settings::model::setting_names;
use overlook_engine::settings::{Kernel, Settings};
use overlook_lab::sweep::{Point, Series};

/// The settings that give a point; `None` where samples were thinned or cameras left out besides, so that they do not.
pub(crate) fn settings_alone(point: &Point) -> Option<&Settings> {
    let more_was_done = matches!(
        point.series,
        Series::Random | Series::VoxelGrid | Series::FirstCameraAtCount | Series::SingleCamera
    );
    let more_was_done = more_was_done || point.series.is_rival();
    (!more_was_done).then_some(&point.settings)
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
    setting_names::choice("render.kernel", kernel.name())
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

    #[test]
    fn a_stress_test_starts_from_the_same_settings() {
        assert_eq!(
            ["ours", "paper", "without defenses"].map(method_name),
            [START, "as in the paper", "noise handling off"]
        );
    }
}
