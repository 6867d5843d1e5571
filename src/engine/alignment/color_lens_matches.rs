//! Which samples of two cameras show one surface point, so that their colors determine the color lens.
//!
//! Purpose: see [`super::color_lens_search`]. Source: none; a sample counts where the other camera's depth confirms it.

use glam::DVec2;

use super::color_lens::{BrightnessDifference, Matches};
use super::reference_view::ReferenceView;
use super::solver::Problem;
use crate::capture::sighting::tolerances::NOISY_PIXEL;
use crate::capture::sighting::{Sighting, compare};

/// Samples of the first camera that the second one's depth confirms. Beside edges of depth pictures tell most of a lens that is wrong:
/// they count, unless the matches are to judge. What lies behind without depth never counts.
pub(super) fn matches(problem: &Problem, pair: [usize; 2], judge: bool) -> Matches<'_> {
    let views = pair.map(|camera| &problem.views[camera]);
    let [own, other] = views;
    let other_from_own = other.camera.camera_from_world() * own.camera.world_from_camera;
    let confirmed = problem.samples[pair[0]].iter().filter_map(|sample| {
        let point = own.camera.intrinsics.ray_in_camera(sample.pixel) / sample.inverse_depth;
        let there = other_from_own.transform_point3(point);
        let image = other.camera.intrinsics.project(there)?;
        let levels = if judge {
            sample.pure_levels.min(other.pure_levels_at(image))
        } else {
            own.measured_levels_at(sample.pixel).min(other.measured_levels_at(image))
        };
        is_confirmed(other, image, there.z).then_some(([point, there], levels))
    });
    let (points, levels) = confirmed.unzip();
    Matches { views, points, levels }
}

/// Whether the view has this depth at an image position, away from edges and from what moves.
fn is_confirmed(view: &ReferenceView, image: DVec2, depth: f64) -> bool {
    let surface = view.surface_at(image);
    surface.is_some_and(|(_, _, here)| compare(here, depth, NOISY_PIXEL) == Sighting::Same)
}

/// The values of differences at the same matches, which are in order.
pub(super) fn common(before: &[BrightnessDifference], after: &[BrightnessDifference]) -> Vec<[f64; 2]> {
    let mut after = after.iter().peekable();
    let mut both = Vec::with_capacity(before.len());
    for own in before {
        while after.next_if(|other| other.match_index < own.match_index).is_some() {}
        if let Some(other) = after.next_if(|other| other.match_index == own.match_index) {
            both.push([own.value, other.value]);
        }
    }
    both
}
