//! Which samples of two cameras show one surface point, so that their colors determine the color lens.
//!
//! Purpose: see [`super::color_lens_search`]. Source: none; a sample counts where the other camera's depth confirms it.

use glam::DVec3;

use super::color_lens::Matches;
use super::reference_view::ReferenceView;
use super::solver::Problem;

/// Two depths are of one surface where they differ by less, relative.
const SAME_DEPTH_RELATIVE: f64 = 0.03;

/// Samples of the first camera that the second one's depth confirms.
pub(super) fn matches(problem: &Problem, pair: [usize; 2]) -> Matches<'_> {
    let views = pair.map(|camera| &problem.views[camera]);
    let [own, other] = views;
    let other_from_own = other.camera.camera_from_world() * own.camera.world_from_camera;
    let points = problem.samples[pair[0]].iter().filter_map(|sample| {
        let point = own.camera.intrinsics.ray_in_camera(sample.pixel) / sample.inverse_depth;
        let there = other_from_own.transform_point3(point);
        is_confirmed(other, there).then_some([point, there])
    });
    Matches { views, points: points.collect() }
}

/// Whether the view has the depth of a point where it sees it, away from edges and from what moves.
fn is_confirmed(view: &ReferenceView, point: DVec3) -> bool {
    let surface = view.camera.intrinsics.project(point).and_then(|image| view.surface_at(image));
    surface.is_some_and(|(_, _, here)| (f64::from(here) * point.z - 1.0).abs() < SAME_DEPTH_RELATIVE)
}
