//! The fewest views that show what all show.
//!
//! Purpose: a camera that moves through a static scene takes hundreds of pictures, and most repeat others.
//!
//! Source: [`GreedyCover`]. What differs: a point counts by how finely it is shown, in proportion to the finest; so a close-up adds
//! something to a wide view.

use glam::DVec2;
use rayon::prelude::*;

use super::greedy_cover::{Addition, CoveredSet, GreedyCover};
use crate::capture::camera::{Camera, PixelSide};
use crate::capture::frame::Frame;
use crate::capture::parts::Capture;
use crate::capture::sighting::tolerances::NOISY_PIXEL;
use crate::capture::sighting::{Landing, Sighting};
use crate::error::Result;

/// Views that are compared at most, spread evenly over a longer recording.
const MAX_CANDIDATES: usize = 256;
/// Points of each view that are looked for in the others, at most: columns and rows of a grid.
const GRID: (usize, usize) = (16, 12);
/// Value of a point that is shown as finely as possible.
const FINEST: u8 = 255;
/// A view that adds less than this share of everything is not worth its pixels.
const LEAST_SHARE: f64 = 2e-4;

/// Views chosen among those of a capture.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewChoice {
    /// Indices of the cameras in the order in which they were chosen, and the share of what all views show that is shown with each:
    /// its last entry is what all of them show together.
    pub chosen: Vec<(usize, f64)>,
}

impl ViewChoice {
    /// Chooses at most `most` views of a capture by its frame in the middle. Views are added by what they add, as long as that is
    /// worth anything.
    ///
    /// # Errors
    /// Those of reading the frames.
    pub fn of(capture: &Capture, most: usize) -> Result<Self> {
        let cameras = capture.cameras.len();
        let count = cameras.min(MAX_CANDIDATES.max(most));
        let candidates: Vec<usize> = (0..count).map(|index| index * cameras / count).collect();
        let frame = capture.frame_count() / 2;
        let views: Vec<CandidateView> = candidates
            .par_iter()
            .map(|&camera| {
                let picture = capture.frame(camera, frame)?;
                Ok(CandidateView::new(&capture.cameras[camera], &picture))
            })
            .collect::<Result<_>>()?;
        let shown: Vec<Vec<u8>> = views.par_iter().map(|view| view.shows_of(&views)).collect();
        let chosen = choose(&shown, most);
        Ok(Self { chosen: chosen.into_iter().map(|(index, share)| (candidates[index], share)).collect() })
    }

    /// The share of what all views show that the chosen ones show.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.chosen.last().map_or(0.0, |(_, share)| *share)
    }

    /// Whether a camera is among them.
    #[must_use]
    pub fn has(&self, camera: usize) -> bool {
        self.chosen.iter().any(|(chosen, _)| *chosen == camera)
    }
}

/// How finely each point of all views is shown by those that were taken.
struct Fineness<'a> {
    /// View by view.
    shown: &'a [Vec<u8>],
    best: Vec<u8>,
}

impl CoveredSet for Fineness<'_> {
    fn added_by(&self, view: usize) -> u64 {
        let points = self.shown[view].iter().zip(&self.best);
        points.map(|(new, old)| u64::from(new.saturating_sub(*old))).sum()
    }

    fn take(&mut self, view: usize) {
        self.best.iter_mut().zip(&self.shown[view]).for_each(|(old, new)| *old = (*old).max(*new));
    }
}

/// Views in the order of what each adds, and the share of everything that is shown with it.
fn choose(shown: &[Vec<u8>], most: usize) -> Vec<(usize, f64)> {
    let points = shown.first().map_or(0, Vec::len);
    let finest = |point: usize| shown.iter().map(|view| u64::from(view[point])).max().unwrap_or(0);
    let all = (0..points).map(finest).sum::<u64>().max(1) as f64;
    let mut fineness = Fineness { shown, best: vec![0; points] };
    let (mut chosen, mut sum) = (Vec::new(), 0);
    for Addition { view, added } in GreedyCover::new(&mut fineness, 0..shown.len()).take(most) {
        if (added as f64) < LEAST_SHARE * all && !chosen.is_empty() {
            break;
        }
        sum += added;
        chosen.push((view, sum as f64 / all));
    }
    chosen
}

/// A view that may be chosen: its points, and the depth that hides others.
struct CandidateView {
    camera: Camera,
    /// 1/z row by row.
    inverse_depth: Vec<f32>,
    /// Points in world space, and the width of a pixel there.
    points: Vec<(glam::DVec3, f64)>,
}

impl CandidateView {
    fn new(camera: &Camera, frame: &Frame) -> Self {
        let inverse_depth = frame.inverse_depth.as_slice().to_vec();
        let (width, height) = camera.intrinsics.size();
        let mut points = Vec::new();
        for row in 0..GRID.1.min(height) {
            for column in 0..GRID.0.min(width) {
                let x = (2 * column + 1) * width / (2 * GRID.0.min(width));
                let y = (2 * row + 1) * height / (2 * GRID.1.min(height));
                let inverse = f64::from(inverse_depth[y * width + x]);
                if inverse > 0.0 {
                    let (at, depth) = (DVec2::new(x as f64 + 0.5, y as f64 + 0.5), inverse.recip());
                    points.push((camera.unproject(at, depth), pixel_width(camera, depth)));
                }
            }
        }
        Self { camera: camera.clone(), inverse_depth, points }
    }

    /// How finely this view shows each point of all views: 0 where it does not.
    fn shows_of(&self, views: &[Self]) -> Vec<u8> {
        views.iter().flat_map(|view| &view.points).map(|(point, width)| self.shows(*point, *width)).collect()
    }

    fn shows(&self, point: glam::DVec3, pixel: f64) -> u8 {
        let (width, height) = self.camera.intrinsics.size();
        let Some(landing) = Landing::of(point, &self.camera, (width, height)) else { return 0 };
        let seen = self.inverse_depth[landing.pixel.1 * width + landing.pixel.0];
        if landing.compare(seen, NOISY_PIXEL) != Sighting::Same {
            return 0;
        }
        (f64::from(FINEST) * (pixel / pixel_width(&self.camera, landing.depth)).min(1.0)) as u8
    }
}

/// The longer side counts: a picture is as coarse as its coarser direction.
fn pixel_width(camera: &Camera, depth: f64) -> f64 {
    camera.intrinsics.pixel_width(depth, PixelSide::Longer)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_view_that_adds_most_comes_first_and_repetition_is_left_out() {
        let wide = vec![255, 255, 255, 0, 100];
        let same = wide.clone();
        let beside = vec![0, 0, 255, 255, 0];
        let close = vec![0, 0, 0, 0, 255];
        let shown = [same, wide, beside, close];
        let chosen = choose(&shown, 9);
        assert_eq!(chosen.iter().map(|(index, _)| *index).collect::<Vec<_>>(), [0, 2, 3]);
        assert!((chosen[2].1 - 1.0).abs() < 1e-12);
        assert_eq!(choose(&shown, 1), [(0, 865.0 / 1275.0)]);
        assert!(choose(&[], 3).is_empty());
    }
}
