//! The views that readings are tried on: numbers as the files have them, and the pixels that are carried from view to view.

use std::ops::Range;

use glam::{DAffine3, DVec2};

use crate::capture::camera::{Camera, Intrinsics};
use crate::capture::depth_claim::DepthClaim;
use crate::median::median;

/// Points that are carried out of each view, at most.
pub(super) const POINTS: usize = 256;

/// Between neighbors on one surface numbers differ by less than this share; across an edge by more.
const EDGE: f64 = 0.06;

/// One pixel of a view.
pub(super) struct SourcePoint {
    /// The pixel's center.
    pub pixel: DVec2,
    /// The number of its depth.
    pub value: f64,
}

/// One picture of depth, as it was read.
pub(super) struct ComparedView {
    /// As claimed.
    pub intrinsics: Intrinsics,
    /// The matrix of the pose, camera to world, of our camera space as the capture's convention gives it.
    pub world_from_camera: DAffine3,
    /// The numbers of depth, row by row; NaN for no depth, and where nothing was hit.
    pub values: Vec<f32>,
    /// In an order whose first entries, however many, are spread over the picture.
    pub points: Vec<SourcePoint>,
}

impl ComparedView {
    /// A view of a picture of inverse planar z (1/unit; 0 and below are no depth).
    pub(super) fn new(camera: &Camera, inverse_depth: impl Fn(usize) -> f32, claim: &DepthClaim) -> Self {
        let intrinsics = camera.intrinsics;
        let (width, height) = intrinsics.size();
        let value_at = |index: usize| {
            let inverse = f64::from(inverse_depth(index));
            let ray = intrinsics.ray_in_camera(center(index % width, index / width));
            if inverse > 0.0 {
                claim.value(inverse.recip(), ray, &camera.world_from_camera) as f32
            } else {
                f32::NAN
            }
        };
        let values: Vec<f32> = (0..width * height).map(value_at).collect();
        let points = spread_points((width, height), &values);
        Self { intrinsics, world_from_camera: camera.world_from_camera, values, points }
    }

    /// The rows of up to three numbers around an image position within the picture.
    pub(super) fn around(&self, at: DVec2) -> impl Iterator<Item = &[f32]> {
        let (width, height) = self.intrinsics.size();
        let span = |at: f64, size: usize| -> Range<usize> {
            (at as usize).saturating_sub(1)..(at as usize + 2).min(size)
        };
        let columns = span(at.x, width);
        span(at.y, height).map(move |y| &self.values[y * width..][columns.clone()])
    }

    /// The median of the points' numbers; `None` without any.
    pub(super) fn middle_value(&self) -> Option<f64> {
        let mut values: Vec<f64> = self.points.iter().map(|point| point.value).collect();
        median(&mut values)
    }
}

fn center(x: usize, y: usize) -> DVec2 {
    DVec2::new(x as f64 + 0.5, y as f64 + 0.5)
}

/// Pixels with depth, off its edges; any with depth where surfaces are too steep for that.
fn spread_points((width, height): (usize, usize), values: &[f32]) -> Vec<SourcePoint> {
    /// Positions that are looked at for each point that is wanted.
    const TRIES: usize = 8;
    /// Fewer points off edges than this are too few.
    const FEW: usize = 48;
    let is_smooth = |x: usize, y: usize| {
        let here = values[y * width + x];
        let beside = [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)];
        beside.into_iter().filter(|(x, y)| *x < width && *y < height).all(|(x, y)| {
            let there = values[y * width + x];
            f64::from((there - here).abs()) <= EDGE * f64::from(here.abs())
        })
    };
    let mut seen = std::collections::HashSet::new();
    let (mut smooth, mut any) = (Vec::new(), Vec::new());
    for (x, y) in spread(width, height).take(TRIES * POINTS) {
        let value = values[y * width + x];
        if !value.is_finite() || !seen.insert((x, y)) {
            continue;
        }
        let point = SourcePoint { pixel: center(x, y), value: f64::from(value) };
        if is_smooth(x, y) {
            smooth.push(point);
        } else {
            any.push(point);
        }
        if smooth.len() == POINTS {
            break;
        }
    }
    if smooth.len() < FEW {
        any.truncate(POINTS - smooth.len());
        smooth.extend(any);
    }
    smooth
}

/// Pixels in an order whose first entries, however many, cover the picture evenly: the additive recurrence of the plastic number.
fn spread(width: usize, height: usize) -> impl Iterator<Item = (usize, usize)> {
    const STEP: DVec2 = DVec2::new(0.754_877_666_246_692_8, 0.569_840_290_998_053_2);
    (0..).map(move |index: u32| {
        let at = (STEP * f64::from(index) + 0.5).fract();
        ((at.x * width as f64) as usize, (at.y * height as f64) as usize)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_points_cover_the_picture() {
        let quarters: std::collections::HashSet<_> =
            spread(64, 48).take(12).map(|(x, y)| (x / 32, y / 24)).collect();
        assert_eq!(quarters.len(), 4);
        assert!(spread(7, 3).take(1000).all(|(x, y)| x < 7 && y < 3));
    }
}
