//! What accuracy costs: sweeps and stress tests as charts, tuning, and what each camera is worth.

mod control;
pub(crate) mod state;
pub(crate) mod ui;
pub(crate) mod work;

use crate::app::model::state::State;
use crate::app::rooms::charts::state::axis::{FRONT, START, method_name, place};
use crate::app::rooms::charts::state::{Charts, Study};
use overlook_lab::chart::{Chart, ChartQuantity, stress, tradeoff};
use overlook_lab::stress::StressPoint;
use overlook_lab::sweep::Point;

/// The chart of a study, of a stress test with all disturbances; `None` while it has no point that is shown.
pub(crate) fn sheet(study: Study, state: &State) -> Option<Chart> {
    let scene = state.doc.scene.as_ref().map_or("", |scene| scene.name.as_str());
    match study {
        Study::Sweep => sheet_of_sweep(scene, &state.doc.charts),
        Study::Stress => sheet_of_stress_test(scene, &state.doc.charts),
        Study::Tuning | Study::Ranking => None,
    }
}

fn sheet_of_sweep(scene: &str, charts: &Charts) -> Option<Chart> {
    let axes = charts.axes;
    let is_drawn = |point: &&Point| charts.shows_point(point) && place(axes, point).is_some();
    let points: Vec<Point> = charts.sweep.iter().filter(is_drawn).cloned().collect();
    if points.is_empty() {
        return None;
    }
    let values = axes.map(|axis| move |point: &Point| axis.quantity.on_paper(point));
    let quantities = [0, 1].map(|index| ChartQuantity {
        name: axes[index].quantity.name_on_paper(),
        scale: axes[index].scale,
        value: &values[index],
        is_gain: axes[index].quantity.is_gain(),
    });
    Some(tradeoff(scene, &points, &quantities, START, charts.shows(Study::Sweep, FRONT)))
}

fn sheet_of_stress_test(scene: &str, charts: &Charts) -> Option<Chart> {
    let named = |point: &StressPoint| StressPoint {
        method: method_name(&point.method).to_owned(),
        disturbance: crate::text::words(&point.disturbance),
        ..point.clone()
    };
    let shown = charts.stress.iter().filter(|point| charts.shows(Study::Stress, method_name(&point.method)));
    let points: Vec<StressPoint> = shown.map(named).collect();
    (!points.is_empty()).then(|| stress(scene, &points))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::rooms::charts::state::Found;
    use crate::app::rooms::charts::state::axis::{Quantity, ShownAxis};
    use overlook_engine::settings::Settings;
    use overlook_lab::sweep::Series;
    use overlook_lab::trial::{Trial, TrialResult};

    fn point(series: Series, psnr_db: f64, bytes: u64) -> Point {
        let trial = Trial::new("t", Settings::default());
        let mut point = Point::new(&trial, series, &TrialResult::default());
        (point.psnr_filled_db, point.ssim, point.bytes, point.samples) = (psnr_db, 0.9, bytes, bytes);
        point
    }

    #[test]
    fn a_chart_that_leaves_shows_the_axes_and_the_series_that_are_shown() {
        let mut state = State::default();
        assert!(sheet(Study::Sweep, &state).is_none() && sheet(Study::Stress, &state).is_none());
        state.doc.charts.add(Found::Sweep(point(Series::Reference, 30.0, 2_000_000)), (1, 2));
        state.doc.charts.add(Found::Sweep(point(Series::Random, 20.0, 1_000_000)), (2, 2));
        let svg = |state: &State| sheet(Study::Sweep, state).unwrap().svg();
        let both = svg(&state);
        for words in
            [START, "random", "Store size, MB (lower is better)", "PSNR, holes filled, dB", "Pareto front"]
        {
            assert!(both.contains(words), "{words}: {both}");
        }
        assert!(both.contains("fill=\"#ffffff\""), "on white paper: {both}");
        let random = Series::Random.name().to_owned();
        state.doc.charts.toggle(Study::Sweep, random.clone());
        assert!(!svg(&state).contains(&random), "it is left out as in the window");
        state.doc.charts.set_axes([Quantity::Samples, Quantity::Ssim].map(ShownAxis::of));
        let other = svg(&state);
        assert!(other.contains("Samples, thousands") && other.contains("SSIM (higher is better)"), "{other}");
        state.doc.charts.toggle(Study::Sweep, START.to_owned());
        assert!(sheet(Study::Sweep, &state).is_none(), "nothing is shown");
    }

    #[test]
    fn a_stress_test_leaves_with_all_disturbances_and_the_names_of_the_window() {
        let mut state = State::default();
        let methods = ["ours", "paper", "without defenses"].map(|method| ("noise", method));
        for (disturbance, method) in methods.into_iter().chain([("camera_pose", "ours")]) {
            let stressed = StressPoint {
                disturbance: disturbance.to_owned(),
                unit: "pixels".to_owned(),
                dial: 1.0,
                method: method.to_owned(),
                loss_db: 0.0,
                kept_share: 0.5,
                point: point(Series::Variation, 30.0, 10),
            };
            state.doc.charts.add(Found::Stress(stressed), (1, 4));
        }
        let svg = sheet(Study::Stress, &state).unwrap().svg();
        for words in [START, "as in the paper", "noise handling off", "oise, pixels", "amera pose, pixels"] {
            assert!(svg.contains(words), "{words}: {svg}");
        }
        state.doc.charts.toggle(Study::Stress, "as in the paper".to_owned());
        assert!(!sheet(Study::Stress, &state).unwrap().svg().contains("as in the paper"));
    }
}
