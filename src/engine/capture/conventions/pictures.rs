//! Two readings beside each other as pictures: what the other views show of one view's picture, under each.
//!
//! Purpose: a person sees at once which of two readings is right, as under the right one the colors of all views meet in one picture.
//! Every pixel of depth is carried into one view and painted there, the nearest in front; nothing is filled or pruned.

use std::sync::Arc;

use glam::{DAffine3, DVec2};
use half::f16;
use rayon::prelude::*;

use super::agreement::Comparison;
use super::chosen_views::ComparedViews;
use super::reading::{PixelRay, Reading};
use super::search::WIDE;
use super::views::{ComparedView, POINTS};
use crate::capture::camera::Intrinsics;
use crate::capture::frame::Frame;
use crate::capture::parts::Capture;
use crate::error::{Error, Result};
use crate::grid::Grid;

/// Columns and rows that a painted pixel covers at most, for views from far behind the others.
const MOST_COVERED: f64 = 4.0;

/// Two readings of a capture beside each other.
#[derive(Clone, Debug)]
pub struct ReadingPictures {
    /// Name of the camera whose view is shown.
    pub camera: String,
    /// What it recorded, linear Rec.709.
    pub recorded: Grid<[f32; 3]>,
    /// What the other views show of the same under each reading.
    pub readings: [RegisteredViews; 2],
}

/// What all other views show of one, under one reading.
#[derive(Clone, Debug)]
pub struct RegisteredViews {
    /// Linear Rec.709, as large as [`ReadingPictures::recorded`]; `None` where no point of another view is.
    pub color: Grid<Option<[f32; 3]>>,
    /// Points that are on a surface of the view that they are carried into, as a share of all points of all compared pairs.
    pub agree: f64,
    /// Points that are in front of all surfaces of that view, which would have seen them; the same share.
    pub contradict: f64,
}

/// Shows two readings of a capture in the view that most points of the others are carried into under the second one, in a picture of
/// at most `width` columns.
///
/// # Errors
/// Those of reading frames, and `Invalid` where there is one view only.
pub fn pictures(capture: &Capture, readings: [Reading; 2], width: usize) -> Result<ReadingPictures> {
    let chosen = ComparedViews::of(capture);
    let frames = chosen.frames(capture)?;
    let comparison = chosen.comparison(capture, &frames);
    let target = best_target(&comparison, &readings[1])
        .ok_or_else(|| Error::invalid(&capture.name, "there is one view only; nothing can be compared"))?;
    let lens = small(&comparison.views[target].intrinsics, width);
    let show = |reading: &Reading| {
        let votes = comparison.votes(reading, POINTS, WIDE);
        let share = |count: usize| count as f64 / votes.tried.max(1) as f64;
        let color = registered(&comparison, &frames, reading, target, &lens);
        RegisteredViews { color, agree: share(votes.agree), contradict: share(votes.contradict) }
    };
    let (first, second) = rayon::join(|| show(&readings[0]), || show(&readings[1]));
    Ok(ReadingPictures {
        camera: capture.cameras[chosen.cameras[target]].name.clone(),
        recorded: shrunk(&frames[target], &lens),
        readings: [first, second],
    })
}

/// The view that most points of others agree with; `None` where there is no other.
fn best_target(comparison: &Comparison, reading: &Reading) -> Option<usize> {
    let count = comparison.views.len();
    let agreeing = |target: usize| {
        let pairs = (0..count).filter(|from| *from != target).map(|from| (from, target));
        comparison.votes_of(reading, pairs, POINTS, WIDE).agree
    };
    (count > 1).then(|| (0..count).max_by_key(|&target| (agreeing(target), std::cmp::Reverse(target))))?
}

/// The lens of a picture with at most `width` columns.
pub(super) fn small(lens: &Intrinsics, width: usize) -> Intrinsics {
    let scale = (width as f64 / f64::from(lens.width)).min(1.0);
    let side = |pixels: u32| (f64::from(pixels) * scale).round().max(1.0) as u32;
    Intrinsics {
        width: side(lens.width),
        height: side(lens.height),
        fx: lens.fx * scale,
        fy: lens.fy * scale,
        cx: lens.cx * scale,
        cy: lens.cy * scale,
        projection: lens.projection,
    }
}

/// A picture that is being painted: planar z and color of the nearest point of each pixel.
struct Canvas {
    lens: Intrinsics,
    nearest: Vec<(f32, [f16; 3])>,
}

impl Canvas {
    fn new(lens: Intrinsics) -> Self {
        Self { lens, nearest: vec![(f32::INFINITY, [f16::ZERO; 3]); lens.pixel_count()] }
    }

    /// Paints a point at an image position; `side` is the width of the square that it covers, pixels.
    fn paint(&mut self, at: DVec2, side: f64, depth: f32, color: [f16; 3]) {
        let (width, height) = self.lens.size();
        let first = |center: f64| (center - 0.5 * (side - 1.0)).floor().max(0.0) as usize;
        let end = |center: f64, size: usize| {
            ((center + 0.5 * (side - 1.0)).floor() + 1.0).clamp(0.0, size as f64) as usize
        };
        for y in first(at.y)..end(at.y, height) {
            for x in first(at.x)..end(at.x, width) {
                let pixel = &mut self.nearest[y * width + x];
                if depth < pixel.0 {
                    *pixel = (depth, color);
                }
            }
        }
    }

    fn merge(mut self, other: &Self) -> Self {
        for (pixel, other) in self.nearest.iter_mut().zip(&other.nearest) {
            if other.0 < pixel.0 {
                *pixel = *other;
            }
        }
        self
    }

    fn into_picture(self) -> Grid<Option<[f32; 3]>> {
        let color = |(depth, color): (f32, [f16; 3])| depth.is_finite().then(|| color.map(f16::to_f32));
        let (width, height) = self.lens.size();
        Grid::from_vec(width, height, self.nearest.into_iter().map(color).collect())
    }
}

/// What all views but `target` show of it.
fn registered(
    comparison: &Comparison,
    frames: &[Arc<Frame>],
    reading: &Reading,
    target: usize,
    lens: &Intrinsics,
) -> Grid<Option<[f32; 3]>> {
    let poses = comparison.poses(reading);
    let lens = &reading.lens.of(lens);
    let sources = (0..frames.len()).into_par_iter().filter(|source| *source != target);
    let painted = sources.map(|source| {
        let mut canvas = Canvas::new(*lens);
        let target_from_source = poses[target].inverse() * poses[source];
        let view = &comparison.views[source];
        let source_lens = reading.lens.of(&view.intrinsics);
        let depth =
            |value: f64, ray: PixelRay| reading.planar_z(value, ray, &poses[source], comparison.near_clip);
        carry(view, &source_lens, &frames[source], &target_from_source, depth, &mut canvas);
        canvas
    });
    let all = painted.reduce(|| Canvas::new(*lens), |all, canvas| all.merge(&canvas));
    all.into_picture()
}

/// Paints all pixels of one view; `depth` gives planar z of a number and its ray.
fn carry(
    view: &ComparedView,
    source_lens: &Intrinsics,
    frame: &Frame,
    target_from_source: &DAffine3,
    depth: impl Fn(f64, PixelRay) -> f64,
    canvas: &mut Canvas,
) {
    let (width, _) = view.intrinsics.size();
    let (columns, rows) = canvas.lens.size();
    let whole = DVec2::new(columns as f64, rows as f64);
    for (index, &value) in view.values.iter().enumerate().filter(|(_, value)| value.is_finite()) {
        let center = DVec2::new((index % width) as f64 + 0.5, (index / width) as f64 + 0.5);
        let ray = PixelRay::through(source_lens, center);
        let z = depth(f64::from(value), ray);
        let point = target_from_source.transform_point3(ray.to_unit_z * z);
        let Some(at) = canvas.lens.project(point).filter(|_| z > 0.0) else { continue };
        if !(at.cmpge(DVec2::ZERO).all() && at.cmplt(whole).all()) {
            continue;
        }
        let side = z / source_lens.fx * canvas.lens.fx / point.z;
        let color = frame.color.as_slice()[index];
        canvas.paint(at, side.ceil().clamp(1.0, MOST_COVERED), point.z as f32, color);
    }
}

/// A recorded picture in the size of `lens`: the mean of the pixels that each of its pixels covers.
pub(super) fn shrunk(frame: &Frame, lens: &Intrinsics) -> Grid<[f32; 3]> {
    let ((width, height), (columns, rows)) = (frame.size(), lens.size());
    let span = |at: usize, of: usize, all: usize| {
        let start = at * all / of;
        start..((at + 1) * all / of).max(start + 1).min(all)
    };
    let mean = |index: usize| {
        let (xs, ys) = (span(index % columns, columns, width), span(index / columns, rows, height));
        let count = (xs.len() * ys.len()) as f32;
        let mut sum = [0.0_f32; 3];
        for y in ys {
            for x in xs.clone() {
                let color = frame.color[(x, y)];
                for (sum, color) in sum.iter_mut().zip(color) {
                    *sum += color.to_f32();
                }
            }
        }
        sum.map(|sum| sum / count)
    };
    Grid::from_vec(columns, rows, (0..columns * rows).map(mean).collect())
}
