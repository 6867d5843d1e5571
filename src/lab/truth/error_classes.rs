//! Classes of a true picture's pixels: seen by no camera, at a silhouette, or neither.

use std::sync::Arc;

use glam::DVec2;
use rayon::prelude::*;

use crate::metrics::{ClassMap, ErrorClass};
use crate::rivals::RecordedView;
use overlook_engine::capture::sighting::tolerances::SEEN_POINTS;
use overlook_engine::capture::sighting::{Landing, Sighting};
use overlook_engine::capture::{Camera, Capture, Frame, Intrinsics, TruthView};
use overlook_engine::error::Result;
use overlook_engine::grid::Grid;
use overlook_engine::job::Job;

/// Two pixels beside each other whose depths differ by more than this share have a step between them.
const STEP: f64 = 0.05;

/// Most steps from a pixel at an edge to the step in depth, each to one of the four neighbors.
const REACH_PX: usize = 2;

/// Depth of pixels at infinity and of pixels without depth.
const FAR: f64 = 1e6;

/// The class of every pixel of the truth at `camera`; `None` where it has no depth, so that nothing is known.
#[must_use]
pub fn class_map(camera: &Camera, truth: &Frame, seen: &[RecordedView]) -> Option<ClassMap> {
    let (width, height) = truth.size();
    let depths = &truth.inverse_depth;
    if !depths.as_slice().iter().any(|inverse_depth| *inverse_depth > 0.0) {
        return None;
    }
    let edges = edges(depths);
    let class = |pixel: usize| {
        let at = (pixel % width, pixel / width);
        let inverse_depth = f64::from(depths[at]);
        if inverse_depth <= 0.0 {
            return None;
        }
        let center = DVec2::new(at.0 as f64 + 0.5, at.1 as f64 + 0.5);
        let point = camera.unproject(center, 1.0 / inverse_depth);
        let is_seen = seen.iter().any(|seen| sees(seen, point));
        Some(if !is_seen {
            ErrorClass::Unseen
        } else if edges[at] {
            ErrorClass::Edge
        } else {
            ErrorClass::Inner
        })
    };
    Some(Grid::from_vec(width, height, (0..width * height).into_par_iter().map(class).collect()))
}

/// The classes at every view whose truth is known, for a capture as it is.
///
/// # Errors
/// Those of loading frames and truth; `Cancelled`.
pub fn class_maps(capture: &Capture, views: &[TruthView], job: &Job) -> Result<Vec<Option<Arc<ClassMap>>>> {
    let of_view = |view: &TruthView| {
        job.check()?;
        let (Some(load), Some(frame)) = (&view.truth, capture.frame_index(view.frame_number)) else {
            return Ok(None);
        };
        Ok(class_map(&view.camera, &load()?, &seen_at(capture, frame)?).map(Arc::new))
    };
    views.iter().map(of_view).collect()
}

/// What all cameras of a capture saw at a frame, by its index.
///
/// # Errors
///
/// Those of reading the frame's files.
pub fn seen_at(capture: &Capture, frame: usize) -> Result<Vec<RecordedView>> {
    let view = |index: usize| {
        Ok(RecordedView { camera: capture.cameras[index].clone(), frame: capture.frame(index, frame)? })
    };
    (0..capture.cameras.len()).map(view).collect()
}

/// Whether a camera's depth agrees with a point in the world.
fn sees(RecordedView { camera, frame }: &RecordedView, point_in_world: glam::DVec3) -> bool {
    let Some((position, depth)) = camera.project(point_in_world) else { return false };
    is_surface_at(&camera.intrinsics, frame, position, depth)
}

/// Whether a picture has a surface of this depth at an image position, or one pixel beside it.
pub(crate) fn is_surface_at(lens: &Intrinsics, frame: &Frame, position: DVec2, depth: f64) -> bool {
    let (width, height) = frame.size();
    let Some(landing) = Landing::at(lens, position, depth, (width, height)) else { return false };
    let (x, y) = landing.pixel;
    let rows = y.saturating_sub(1)..(y + 2).min(height);
    let columns = || x.saturating_sub(1)..(x + 2).min(width);
    rows.flat_map(|y| columns().map(move |x| (x, y)))
        .any(|at| landing.compare(frame.inverse_depth[at], SEEN_POINTS) == Sighting::Same)
}

/// The pixels within [`REACH_PX`] of a step between two neighbors.
fn edges(inverse_depth: &Grid<f32>) -> Grid<bool> {
    let (width, height) = inverse_depth.size();
    let depth = |at: (usize, usize)| {
        let inverse_depth = f64::from(inverse_depth[at]);
        if inverse_depth > 0.0 { 1.0 / inverse_depth } else { FAR }
    };
    let is_step = |at, before| (depth(at) / depth(before) - 1.0).abs() > STEP;
    let mut edges = Grid::from_fn(width, height, |x, y| {
        (x > 0 && is_step((x, y), (x - 1, y))) || (y > 0 && is_step((x, y), (x, y - 1)))
    });
    for _ in 0..REACH_PX {
        let before = edges.clone();
        edges = Grid::from_fn(width, height, |x, y| {
            let beside = |(x, y)| before.get(x, y).copied().unwrap_or(false);
            before[(x, y)]
                || beside((x + 1, y))
                || beside((x, y + 1))
                || beside((x.wrapping_sub(1), y))
                || beside((x, y.wrapping_sub(1)))
        });
    }
    edges
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// A camera at `x` that looks along +z, at a wall 4 away whose left half is covered by a board 2 away.
    fn recorded(x: f64, board: bool) -> RecordedView {
        let intrinsics = Intrinsics::centered(32, 8, 16.0);
        let mut camera = Camera::look_at("c", intrinsics, DVec3::ZERO, DVec3::Z, DVec3::NEG_Y);
        camera.world_from_camera.translation.x = x;
        let depth = |column: usize, _: usize| {
            let ray = (column as f64 + 0.5 - 16.0) / 16.0;
            let on_board = x + 2.0 * ray < 0.0;
            if board && on_board { 0.5 } else { 0.25 }
        };
        let frame = Frame {
            color: Grid::filled(32, 8, [half::f16::ZERO; 3]),
            inverse_depth: Grid::from_fn(32, 8, depth),
            normal_in_world: None,
            depth_step_relative: 0.0,
            values: overlook_engine::capture::Values::default(),
        };
        RecordedView { camera, frame: Arc::new(frame) }
    }

    #[test]
    fn what_a_board_hides_from_every_camera_is_unseen_and_its_rim_is_an_edge() {
        let RecordedView { camera, frame: truth } = recorded(1.0, true);
        let seen_from_left = [recorded(0.0, true)];
        let map = class_map(&camera, &truth, &seen_from_left).unwrap();
        let row: Vec<_> = (0..32).map(|x| map[(x, 4)].unwrap()).collect();
        // The board ends at column 8; the wall behind is hidden from x = 0 up to its own edge at 0, which is column 12.
        assert!(row[..5].iter().all(|class| *class == ErrorClass::Unseen || *class == ErrorClass::Inner));
        assert_eq!(row[7], ErrorClass::Edge);
        assert!(row[13..28].iter().all(|class| *class == ErrorClass::Inner), "{row:?}");
        let with_itself = class_map(&camera, &truth, &[recorded(1.0, true)]).unwrap();
        assert!(!with_itself.as_slice().contains(&Some(ErrorClass::Unseen)));
        assert_eq!(with_itself.as_slice().iter().filter(|of| **of == Some(ErrorClass::Edge)).count(), 8 * 5);
        let none = class_map(&camera, &truth, &[]).unwrap();
        assert!(none.as_slice().iter().all(|class| *class == Some(ErrorClass::Unseen)));
    }

    #[test]
    fn a_truth_without_depth_has_no_classes() {
        let RecordedView { camera, frame: truth } = recorded(0.0, false);
        let flat = Frame { inverse_depth: Grid::filled(32, 8, 0.0), ..(*truth).clone() };
        assert!(class_map(&camera, &flat, &[recorded(0.0, false)]).is_none());
    }
}
