//! Temporal redundancy (the paper, §3.2): which pixels stay the same.
//!
//! Purpose: one pass over all frames gathers what no threshold touches (range, mean and noise of every pixel over time);
//! the split into background and foreground is then a comparison per pixel that can be repeated at will.
//!
//! Source: Interactive Dynamic Environments Using Image-Based Modeling and Rendering, §3.2: a pixel that remains constant
//! over time belongs to the camera's background image, all others to the foreground image of their frame.
//! What differs: *constant* means that the range (maximum − minimum over all frames, so that slow drift cannot creep
//! past) of color and of relative depth stays within a tolerance plus what the measured noise explains; a background
//! sample is the mean over all frames.

use std::sync::Arc;

use half::f16;
use rayon::prelude::*;

use super::background::Memo;
use super::noise::{Noise, NoiseMeter, granted_range_sigmas};
use super::normal_errors::{NormalErrors, compare_with_given};
use crate::capture::{Capture, Frame, INVALID_INVERSE_DEPTH};
use crate::color;
use crate::error::Result;
use crate::grid::Grid;
use crate::job::Job;
use crate::settings::{NormalSettings, SpanLevels, SpanSettings};

/// Threshold-independent facts about one camera over all frames.
#[derive(Debug)]
pub struct CameraScan {
    /// Range of color over time, the widest of the three channels, 8-bit sRGB steps; infinite where some frame has no
    /// depth at the pixel.
    pub color_range_steps: Grid<f32>,
    /// Range of inverse depth over time as a share of its maximum, 0 to 1; 0 where always at infinity, infinite where
    /// some frame has no depth at the pixel.
    pub depth_range_relative: Grid<f32>,
    /// Mean color over time, linear.
    pub mean_color: Grid<[f16; 3]>,
    /// Mean inverse depth over time; invalid where some frame has no depth at the pixel.
    pub mean_inverse_depth: Grid<f32>,
    /// Mean given normal in world space; zero where there is none. `None` where the capture gives none.
    pub mean_normal: Option<Grid<[f32; 3]>>,
    /// Pixels without depth, over all frames.
    pub invalid: u64,
    /// The coarsest quantization step of depth met in any frame, relative.
    pub depth_step_relative: f32,
    /// Noise of static pixels.
    pub noise: Noise,
    /// Estimated against given normals on the first frame; empty where none are given.
    pub normal_errors: Vec<NormalErrors>,
}

/// [`CameraScan`] for every camera, and what was last made of it.
#[derive(Debug)]
pub struct TemporalScan {
    /// Frames that were scanned.
    pub frames: usize,
    /// Per camera, in the capture's order.
    pub cameras: Vec<CameraScan>,
    pub(super) memo: Memo,
}

impl CameraScan {
    /// Which pixels are background under `settings`, row-major, given `frames` scanned frames.
    #[must_use]
    pub fn static_pixels(&self, settings: &SpanSettings, frames: usize) -> Vec<bool> {
        if settings.levels == SpanLevels::Off {
            return vec![false; self.mean_color.len()];
        }
        let sigmas = settings.noise * granted_range_sigmas(frames);
        // A difference of one quantization step either way is no difference.
        let depth_tolerance =
            settings.depth_tolerance.max(2.0 * self.depth_step_relative) + sigmas * self.noise.depth_relative;
        let color = self.color_range_steps.as_slice().iter().zip(self.mean_color.as_slice());
        color
            .zip(self.depth_range_relative.as_slice())
            .map(|((&color_range, mean), &depth_range)| {
                depth_range <= depth_tolerance
                    && (color_range <= settings.color_tolerance
                        || color_range <= settings.color_tolerance + sigmas * self.color_noise(*mean))
            })
            .collect()
    }

    /// Standard deviation of the noise of a pixel of this color, the widest of its channels, 8-bit sRGB steps.
    #[must_use]
    pub fn color_noise(&self, color: [f16; 3]) -> f32 {
        color
            .iter()
            .map(|&channel| self.noise.color_at(color::steps_from_linear(channel)))
            .fold(0.0, f32::max)
    }
}

#[derive(Clone, Copy)]
struct PixelSum {
    min_steps: [f32; 3],
    max_steps: [f32; 3],
    color: [f32; 3],
    min_inverse_depth: f32,
    max_inverse_depth: f32,
    inverse_depth: f64,
    normal: [f32; 3],
    invalid: u32,
}

const EMPTY_SUM: PixelSum = PixelSum {
    min_steps: [f32::INFINITY; 3],
    max_steps: [f32::NEG_INFINITY; 3],
    color: [0.0; 3],
    min_inverse_depth: f32::INFINITY,
    max_inverse_depth: f32::NEG_INFINITY,
    inverse_depth: 0.0,
    normal: [0.0; 3],
    invalid: 0,
};

/// Noise is measured on every `NOISE_ROW_STRIDE`-th row: plenty for a median.
const NOISE_ROW_STRIDE: usize = 4;

struct CameraSum {
    width: usize,
    pixels: Vec<PixelSum>,
    meter: NoiseMeter,
    previous: Option<Arc<Frame>>,
    depth_step_relative: f32,
    has_normals: bool,
    normal_errors: Vec<NormalErrors>,
}

impl CameraSum {
    fn new(width: usize, height: usize) -> Self {
        Self {
            width,
            pixels: vec![EMPTY_SUM; width * height],
            meter: NoiseMeter::default(),
            previous: None,
            depth_step_relative: 0.0,
            has_normals: false,
            normal_errors: Vec::new(),
        }
    }

    /// Adds the next frame. Frames must come in order: floating-point sums depend on it.
    fn add(&mut self, frame: Arc<Frame>) {
        let width = self.width.max(1);
        let steps = color::steps_table();
        self.pixels.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
            let colors = frame.color.row(y);
            let depths = frame.inverse_depth.row(y);
            for ((sum, color), &inverse_depth) in row.iter_mut().zip(colors).zip(depths) {
                add_pixel(sum, *color, inverse_depth, steps);
            }
            if let Some(normals) = &frame.normal_in_world {
                for (sum, normal) in row.iter_mut().zip(normals.row(y)) {
                    (0..3).for_each(|axis| sum.normal[axis] += normal[axis]);
                }
            }
        });
        if let Some(previous) = &self.previous {
            measure_noise(&mut self.meter, previous, &frame, steps);
        }
        self.depth_step_relative = self.depth_step_relative.max(frame.depth_step_relative);
        self.has_normals |= frame.normal_in_world.is_some();
        self.previous = Some(frame);
    }

    fn finish(self, frames: usize) -> CameraScan {
        let (width, height) = (self.width, self.pixels.len() / self.width.max(1));
        let grid = |values| Grid::from_vec(width, height, values);
        let count = frames as f32;
        let pixels = &self.pixels;
        CameraScan {
            color_range_steps: grid(
                pixels
                    .iter()
                    .map(|sum| {
                        let range = (0..3).map(|c| sum.max_steps[c] - sum.min_steps[c]).fold(0.0, f32::max);
                        if sum.invalid > 0 { f32::INFINITY } else { range }
                    })
                    .collect(),
            ),
            depth_range_relative: grid(pixels.iter().map(depth_range_relative).collect()),
            mean_color: Grid::from_vec(
                width,
                height,
                pixels.iter().map(|sum| sum.color.map(|c| f16::from_f32(c / count))).collect(),
            ),
            mean_inverse_depth: grid(pixels.iter().map(|sum| mean_inverse_depth(sum, frames)).collect()),
            mean_normal: self.has_normals.then(|| {
                Grid::from_vec(
                    width,
                    height,
                    pixels
                        .iter()
                        .map(|sum| glam::Vec3::from(sum.normal).normalize_or_zero().to_array())
                        .collect(),
                )
            }),
            invalid: pixels.iter().map(|sum| u64::from(sum.invalid)).sum(),
            depth_step_relative: self.depth_step_relative,
            noise: self.meter.noise(),
            normal_errors: self.normal_errors,
        }
    }
}

fn add_pixel(sum: &mut PixelSum, color: [f16; 3], inverse_depth: f32, steps: &[f32]) {
    if inverse_depth < 0.0 {
        sum.invalid += 1;
        return;
    }
    for channel in 0..3 {
        let value = steps[color[channel].to_bits() as usize];
        sum.min_steps[channel] = sum.min_steps[channel].min(value);
        sum.max_steps[channel] = sum.max_steps[channel].max(value);
        sum.color[channel] += color[channel].to_f32();
    }
    sum.min_inverse_depth = sum.min_inverse_depth.min(inverse_depth);
    sum.max_inverse_depth = sum.max_inverse_depth.max(inverse_depth);
    sum.inverse_depth += f64::from(inverse_depth);
}

fn depth_range_relative(sum: &PixelSum) -> f32 {
    if sum.invalid > 0 || sum.max_inverse_depth < 0.0 {
        f32::INFINITY
    } else if sum.max_inverse_depth == 0.0 {
        0.0
    } else {
        (sum.max_inverse_depth - sum.min_inverse_depth) / sum.max_inverse_depth
    }
}

fn mean_inverse_depth(sum: &PixelSum, frames: usize) -> f32 {
    if sum.invalid > 0 || sum.max_inverse_depth < 0.0 {
        INVALID_INVERSE_DEPTH
    } else if sum.min_inverse_depth == sum.max_inverse_depth {
        // Exactly what was recorded, without the rounding of a sum.
        sum.min_inverse_depth
    } else {
        (sum.inverse_depth / frames as f64) as f32
    }
}

fn measure_noise(meter: &mut NoiseMeter, before: &Frame, after: &Frame, steps: &[f32]) {
    let (_, height) = after.size();
    for y in (0..height).step_by(NOISE_ROW_STRIDE) {
        let depths = before.inverse_depth.row(y).iter().zip(after.inverse_depth.row(y));
        let colors = before.color.row(y).iter().zip(after.color.row(y));
        for ((&w_before, &w_after), (c_before, c_after)) in depths.zip(colors) {
            // The sky is often a constant and would speak for a noise-free scene.
            if w_before > 0.0 && w_after > 0.0 {
                meter.add_depth(w_before, w_after);
                for channel in 0..3 {
                    meter.add_color(
                        steps[c_before[channel].to_bits() as usize],
                        steps[c_after[channel].to_bits() as usize],
                    );
                }
            }
        }
    }
}

/// One pass over all frames of all cameras. Deterministic whatever the thread count.
///
/// # Errors
/// Whatever the capture gives (naming file and frame), and `Cancelled`.
pub fn scan(capture: &Capture, normals: &NormalSettings, job: &Job) -> Result<TemporalScan> {
    let frames = capture.frame_count();
    job.start("Reading frames", frames * capture.cameras.len());
    let mut sums: Vec<CameraSum> = capture
        .cameras
        .iter()
        .map(|camera| {
            let (width, height) = camera.intrinsics.size();
            CameraSum::new(width, height)
        })
        .collect();
    let batch = rayon::current_num_threads().div_ceil(capture.cameras.len().max(1)).max(1);
    for start in (0..frames).step_by(batch) {
        let range = start..(start + batch).min(frames);
        sums.par_iter_mut().enumerate().try_for_each(|(camera, sum)| {
            let decoded: Vec<Arc<Frame>> = range
                .clone()
                .into_par_iter()
                .map(|frame| {
                    job.check()?;
                    let decoded = capture.frame(camera, frame);
                    job.advance(1);
                    decoded
                })
                .collect::<Result<_>>()?;
            if let (0, Some(first)) = (range.start, decoded.first()) {
                sum.normal_errors = compare_with_given(first, &capture.cameras[camera], normals);
            }
            for frame in decoded {
                sum.add(frame);
            }
            Ok(())
        })?;
    }
    Ok(TemporalScan {
        frames,
        cameras: sums.into_par_iter().map(|sum| sum.finish(frames)).collect(),
        memo: Memo::default(),
    })
}
