//! What the left view shows of one camera beside the others, as numbers.

use egui::Color32;

use crate::app::colormap::{dimmed, diverging, sequential};
use crate::app::rooms::source::model::{Legend, RATIO_RANGE, SourceKey, VIEW_DEPENDENCE_RANGE};
use overlook_engine::grid::Grid;
use overlook_engine::preprocess::inspect::VISIBLE_STEPS;

/// The sampling ratio against another camera, or the best of them; dimmed if no other camera shows the point.
pub(crate) fn sampling_ratio(key: &SourceKey, picture: &Grid<Color32>) -> Grid<Color32> {
    let Some(inspection) = &key.inspection else { return picture.clone() };
    let ratio = inspection.log2_sampling_ratio(key.camera, key.against);
    Grid::from_fn(picture.width(), picture.height(), |x, y| {
        let value = ratio[(x, y)];
        if value.is_nan() { dimmed(picture[(x, y)], 0.35) } else { diverging(value / RATIO_RANGE) }
    })
}

/// By how much colors differ from those of other cameras; dimmed where none shows the point.
pub(crate) fn view_dependence(key: &SourceKey, picture: &Grid<Color32>) -> (Grid<Color32>, Legend) {
    let Some(inspection) = &key.inspection else { return (picture.clone(), Legend::Plain) };
    let found = inspection.view_dependence(key.camera);
    let pixels = Grid::from_fn(picture.width(), picture.height(), |x, y| {
        let steps = found[(x, y)];
        let of_camera = dimmed(picture[(x, y)], 0.35);
        if steps.is_nan() { of_camera } else { sequential(steps / VIEW_DEPENDENCE_RANGE) }
    });
    let count =
        |wanted: fn(f32) -> bool| found.as_slice().iter().filter(|steps| wanted(**steps)).count() as u64;
    let legend = Legend::ViewDependence {
        visible: count(|steps| steps >= VISIBLE_STEPS),
        alike: count(|steps| steps < VISIBLE_STEPS),
        unknown: count(f32::is_nan),
    };
    (pixels, legend)
}
