//! One camera as alignment sees it: the pictures of one frame in several resolutions, and the pixels that do not move.

use std::sync::Arc;

use glam::DVec2;
use rayon::prelude::*;

use super::surface_extent::{measured_levels, pure_levels};
use crate::capture::{Camera, Capture, Frame, Values};
use crate::color::brightness;
use crate::error::Result;
use crate::grid::Grid;
use crate::job::Job;

/// Resolutions of the brightness: each half as fine as the one before.
pub(crate) const LEVELS: usize = 4;

/// Pixels between a pixel and the end of its surface from which on a resolution shows nothing else: an interpolated value reaches one
/// and a half of its pixels far, and one more pixel may be mixed.
const LEAST_DISTANCES: [u8; LEVELS] = [3, 5, 8, 14];

/// A pixel that differs by more between two frames moves: relative inverse depth, and brightness.
const STILL_DEPTH_RELATIVE: f32 = 0.02;
const STILL_BRIGHTNESS: f32 = 0.05;

/// A pixel is at an edge of depth where its inverse depth differs from a neighbor's by more, relative.
const EDGE_RELATIVE: f32 = 0.03;

/// A frame without its normals, which would take more memory than all that is aligned.
fn without_normals(frame: Arc<Frame>) -> Arc<Frame> {
    if frame.normal_in_world.is_none() {
        return frame;
    }
    let Frame { color, inverse_depth, depth_step_relative, .. } = &*frame;
    Arc::new(Frame {
        color: color.clone(),
        inverse_depth: inverse_depth.clone(),
        normal_in_world: None,
        depth_step_relative: *depth_step_relative,
        values: Values::default(),
    })
}

/// One camera with what it saw at one frame.
#[derive(Clone)]
pub(crate) struct ReferenceView {
    /// The camera; its pose and lens change while alignment goes on.
    pub(crate) camera: Camera,
    /// Color and depth as they were recorded, without normals.
    pub(crate) frame: Arc<Frame>,
    /// Brightness at every resolution, the finest first: the square root of luminance, which has noise of about the same width
    /// everywhere and grows in proportion to a change of exposure.
    pub(crate) brightness: Vec<Grid<f32>>,
    /// Per pixel the number of resolutions, the finest first, that show nothing but its surface around it; `None` where colors count
    /// whatever is beside.
    pure_levels: Option<Grid<u8>>,
    /// As `pure_levels`, where resolutions show nothing but surfaces with depth.
    measured_levels: Option<Grid<u8>>,
    /// Pixels that are as they are in another frame; `None` where there is only one frame.
    pub(crate) is_still: Option<Grid<bool>>,
}

impl ReferenceView {
    /// The view of a camera from the frame that is aligned, and another one that shows what moves.
    pub(crate) fn new(camera: Camera, frame: Arc<Frame>, other: Option<&Frame>) -> Self {
        let inverse_depth = &frame.inverse_depth;
        let pure_levels = Some(pure_levels(inverse_depth, &LEAST_DISTANCES));
        let measured_levels = Some(measured_levels(inverse_depth, &LEAST_DISTANCES));
        Self { pure_levels, measured_levels, ..Self::without_extent(camera, frame, other) }
    }

    /// A view whose colors count whatever is beside a surface.
    pub(crate) fn without_extent(camera: Camera, frame: Arc<Frame>, other: Option<&Frame>) -> Self {
        let frame = without_normals(frame);
        let is_still = other.map(|other| still_pixels(&frame, other));
        let brightness = brightness_levels(&frame, LEVELS);
        Self { camera, frame, brightness, pure_levels: None, measured_levels: None, is_still }
    }

    /// A view with the depth of a frame and brightness at one resolution alone, for residuals at that resolution.
    pub(crate) fn of_level(camera: Camera, frame: &Frame, level: usize) -> Self {
        let mut brightness = brightness_levels(frame, level + 1);
        brightness[..level].fill_with(|| Grid::filled(0, 0, 0.0));
        let frame = Frame {
            color: Grid::filled(0, 0, [half::f16::ZERO; 3]),
            inverse_depth: frame.inverse_depth.clone(),
            normal_in_world: None,
            depth_step_relative: frame.depth_step_relative,
            values: Values::default(),
        };
        let frame = Arc::new(frame);
        Self { camera, frame, brightness, pure_levels: None, measured_levels: None, is_still: None }
    }

    /// Lets colors count whatever is beside a surface, as long as it has depth.
    pub(crate) fn count_colors_beside_edges(&mut self) {
        self.pure_levels = None;
    }

    /// All views of a capture at its first frame. The frame in the middle shows what moves.
    ///
    /// # Errors
    /// Whatever the capture gives (naming file and frame), and `Cancelled`.
    pub(crate) fn all_of(capture: &Capture, job: &Job) -> Result<Vec<Self>> {
        let cameras = capture.cameras.par_iter().enumerate();
        let views = cameras.map(|(index, camera)| {
            job.check()?;
            let middle = capture.frame_count() / 2;
            let other = if middle > 0 { Some(capture.frame(index, middle)?) } else { None };
            Ok(Self::new(camera.clone(), capture.frame(index, 0)?, other.as_deref()))
        });
        views.collect()
    }

    /// Whether the pixel is known to stay as it is.
    pub(crate) fn is_still(&self, x: usize, y: usize) -> bool {
        self.is_still.as_ref().is_none_or(|still| still[(x, y)])
    }

    /// How many resolutions, the finest first, show nothing but one surface around an image position; 0 outside of the picture.
    pub(crate) fn pure_levels_at(&self, image: DVec2) -> usize {
        self.pure_levels.as_ref().map_or(LEVELS, |levels| levels_at(levels, image))
    }

    /// How many resolutions show nothing but surfaces with depth.
    pub(crate) fn measured_levels_at(&self, image: DVec2) -> usize {
        self.measured_levels.as_ref().map_or(LEVELS, |levels| levels_at(levels, image))
    }

    /// The pixel at an image position, and its inverse depth; `None` where it has none, at an edge of depth, near the border of the
    /// picture, and where something moves.
    pub(crate) fn surface_at(&self, image: DVec2) -> Option<(usize, usize, f32)> {
        let depth = &self.frame.inverse_depth;
        let (width, height) = depth.size();
        let is_inside =
            image.x >= 1.0 && image.y >= 1.0 && image.x < width as f64 - 1.0 && image.y < height as f64 - 1.0;
        if !is_inside {
            return None;
        }
        let (x, y) = (image.x as usize, image.y as usize);
        let values = depth.as_slice();
        let at = y * width + x;
        let here = values[at];
        if here <= 0.0 || !self.is_still(x, y) {
            return None;
        }
        let limit = EDGE_RELATIVE * here;
        let is_edge = [at - 1, at + 1, at - width, at + width]
            .iter()
            .any(|&neighbor| values[neighbor] > 0.0 && (values[neighbor] - here).abs() > limit);
        (!is_edge).then_some((x, y, here))
    }

    /// Brightness at an image position in pixels of the finest level, and how it changes with the position, per such pixel;
    /// `None` near the border and beyond.
    pub(crate) fn brightness_at(&self, level: usize, u: f64, v: f64) -> Option<[f64; 3]> {
        let picture = &self.brightness[level];
        let scale = 0.5_f64.powi(level as i32);
        let (x, y) = (u * scale - 0.5, v * scale - 0.5);
        let (column, row) = (x.floor(), y.floor());
        let (width, height) = picture.size();
        if !(column >= 1.0 && row >= 1.0 && column + 2.0 < width as f64 && row + 2.0 < height as f64) {
            return None;
        }
        let (right, down) = (x - column, y - row);
        let start = (row as usize - 1) * width + column as usize - 1;
        let values = picture.as_slice();
        let at = |dx: usize, dy: usize| f64::from(values[start + dy * width + dx]);
        let mix = |a: f64, b: f64, share: f64| a + (b - a) * share;
        let along = |dy: usize| mix(at(1, dy), at(2, dy), right);
        let value = mix(along(1), along(2), down);
        // Central differences, interpolated as the value is.
        let slope = |dy: usize| mix(at(2, dy) - at(0, dy), at(3, dy) - at(1, dy), right);
        let across = mix(slope(1), slope(2), down);
        let downward = mix(along(2) - along(0), along(3) - along(1), down);
        Some([value, 0.5 * across * scale, 0.5 * downward * scale])
    }
}

/// Pixels of a frame that are as they are in another one of the same camera.
pub(crate) fn still_pixels(frame: &Frame, other: &Frame) -> Grid<bool> {
    let (width, height) = frame.size();
    let depths = frame.inverse_depth.as_slice().iter().zip(other.inverse_depth.as_slice());
    let colors = frame.color.as_slice().iter().zip(other.color.as_slice());
    let still = depths.zip(colors).map(|((depth, there), (color, then))| {
        (depth - there).abs() <= STILL_DEPTH_RELATIVE * depth.abs().max(there.abs())
            && (brightness_of(*color) - brightness_of(*then)).abs() <= STILL_BRIGHTNESS
    });
    Grid::from_vec(width, height, still.collect())
}

fn brightness_of(color: [half::f16; 3]) -> f32 {
    brightness(color.map(f32::from))
}

/// The brightness of a frame at some resolutions, the finest first.
fn brightness_levels(frame: &Frame, count: usize) -> Vec<Grid<f32>> {
    let (width, height) = frame.size();
    let finest = frame.color.as_slice().iter().copied().map(brightness_of).collect();
    let mut levels = vec![Grid::from_vec(width, height, finest)];
    while levels.len() < count {
        let coarser = halved(&levels[levels.len() - 1]);
        levels.push(coarser);
    }
    levels
}

/// The mean of every 2×2 pixels; a last odd column or row is left out.
fn halved(picture: &Grid<f32>) -> Grid<f32> {
    let (width, height) = ((picture.width() / 2).max(1), (picture.height() / 2).max(1));
    let right = usize::from(picture.width() > 1);
    let below = usize::from(picture.height() > 1);
    Grid::from_fn(width, height, |x, y| {
        let [x, y] = [2 * x, 2 * y];
        0.25 * (picture[(x, y)]
            + picture[(x + right, y)]
            + picture[(x, y + below)]
            + picture[(x + right, y + below)])
    })
}

fn levels_at(levels: &Grid<u8>, image: DVec2) -> usize {
    let is_inside = image.x >= 0.0 && image.y >= 0.0;
    let levels = levels.get(image.x as usize, image.y as usize).filter(|_| is_inside);
    levels.map_or(0, |levels| usize::from(*levels))
}
