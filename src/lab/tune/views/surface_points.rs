//! Surface points that the views saw, spread evenly over their pictures.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use overlook_engine::capture::overlap::DepthBounds;
use overlook_engine::capture::{Camera, Capture, Frame, PixelSide};
use overlook_engine::error::Result;
use overlook_engine::job::Job;

/// About the most points of all views together.
const POINTS: usize = 1 << 20;
/// Fewest and most points of a view.
const OF_VIEW: [usize; 2] = [64, 4096];

/// A pixel gives no point if its depth differs from a neighbor's by more than this share: it may show either surface.
const STEP: f32 = 0.05;

/// A point of a surface that a view saw.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfacePoint {
    pub(super) in_world: DVec3,
    /// Width of the pixel that saw it, in units of the world.
    pub(super) pixel_width: f64,
}

/// The points of one view at one frame, row by row.
#[derive(Clone, Debug)]
pub(super) struct SeenPoints {
    pub(super) view: usize,
    pub(super) frame: usize,
    pub(super) points: Vec<SurfacePoint>,
    /// How far away the view saw anything.
    pub(super) bounds: DepthBounds,
}

/// The surface points of all views at some frames, view by view.
///
/// # Errors
/// Those of loading frames, and `Cancelled`.
pub(super) fn seen_points(capture: &Capture, frames: &[usize], job: &Job) -> Result<Vec<SeenPoints>> {
    let pictures: Vec<(usize, usize)> =
        (0..capture.cameras.len()).flat_map(|view| frames.iter().map(move |frame| (view, *frame))).collect();
    let of_view = (POINTS / capture.cameras.len().max(1)).clamp(OF_VIEW[0], OF_VIEW[1]);
    let of_picture = of_view.div_ceil(frames.len().max(1));
    let seen = pictures.into_par_iter().map(|(view, frame)| {
        job.check()?;
        let picture = capture.frame(view, frame)?;
        let points = points_of(&capture.cameras[view], &picture, of_picture);
        let depths = picture.inverse_depth.as_slice().iter().enumerate();
        let surfaces = depths.filter(|(_, w)| **w > 0.0).map(|(pixel, w)| (pixel as u32, *w));
        let bounds = DepthBounds::new(picture.size(), surfaces);
        job.advance(1);
        Ok(SeenPoints { view, frame, points, bounds })
    });
    seen.collect()
}

/// About `count` points of one picture, on a lattice.
fn points_of(camera: &Camera, frame: &Frame, count: usize) -> Vec<SurfacePoint> {
    let (width, height) = frame.size();
    let step = (width * height / count.max(1)).isqrt().max(1);
    let depths = &frame.inverse_depth;
    let is_alike = |here: f32, there: Option<&f32>| {
        there.is_none_or(|there| *there < 0.0 || (there / here - 1.0).abs() <= STEP)
    };
    let mut points = Vec::new();
    for y in (step / 2..height).step_by(step) {
        for x in (step / 2..width).step_by(step) {
            let here = depths[(x, y)];
            let beside = [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)]
                .map(|(x, y)| depths.get(x, y));
            if here > 0.0 && beside.into_iter().all(|there| is_alike(here, there)) {
                let depth = 1.0 / f64::from(here);
                let center = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                points.push(SurfacePoint {
                    in_world: camera.unproject(center, depth),
                    pixel_width: camera.intrinsics.pixel_width(depth, PixelSide::Mean),
                });
            }
        }
    }
    points
}
