//! The paper's two lengths of spans, all frames and one: range and mean of every pixel over all frames.
//!
//! Purpose: where a sample lives over all frames or in a single one, a pass over the frames that depends on no threshold finds
//! which; the split is then a comparison per pixel. (What moves is not kept by this pass, since it is not known before its end
//! what does; it is read again, frame by frame.)
//!
//! Source: Interactive Dynamic Environments Using Image-Based Modeling and Rendering, §3.2: a pixel that remains constant
//! over time belongs to the camera's background image, all others to the foreground image of their frame.
//! What differs: see [`static_test`](super::staticness); a background sample is the mean over all frames.

use glam::Vec3;
use half::f16;
use rayon::prelude::*;

use super::pixel_stats::{direction, summand};
use super::range_histogram::RangeHistogram;
use super::span_store::SpanSamples;
use super::staticness::{StaticTest, color_range_steps};
use super::value_ranges::ValueRanges;
use crate::capture::{Frame, INVALID_INVERSE_DEPTH};
use crate::color;
use crate::grid::Grid;
use crate::settings::{SpanLevels, SpanSettings};

/// Threshold-independent facts about one camera over all frames.
#[derive(Debug)]
pub struct SequenceRanges {
    /// Smallest color over time of each channel, bits of half floats that are not below 0. It has no meaning where some frame has
    /// no depth at the pixel.
    pub low_color: Grid<[i16; 3]>,
    /// Largest color over time, likewise.
    pub high_color: Grid<[i16; 3]>,
    /// Range of inverse depth over time as a share of its maximum, 0 to 1; 0 where always at infinity, infinite where
    /// some frame has no depth at the pixel.
    pub depth_relative: Grid<f32>,
    /// Mean color over time, linear.
    pub mean_color: Grid<[f16; 3]>,
    /// Mean inverse depth over time; invalid where some frame has no depth at the pixel.
    pub mean_inverse_depth: Grid<f32>,
    /// Mean given normal in world space; zero if not given. `None` if the capture gives none.
    pub mean_normal: Option<Grid<[f32; 3]>>,
    /// Ranges of scalar values over time, and those of the first frame.
    pub(super) values: ValueRanges,
}

impl SequenceRanges {
    /// Which pixels are background under `settings`, row-major.
    #[must_use]
    pub fn static_pixels(&self, settings: &SpanSettings, test: &StaticTest) -> Vec<bool> {
        if settings.levels == SpanLevels::Off {
            return vec![false; self.mean_color.len()];
        }
        let colors = self.low_color.as_slice().iter().zip(self.high_color.as_slice());
        let depths = self.depth_relative.as_slice().iter().zip(self.mean_inverse_depth.as_slice());
        let pixels = colors.zip(depths).enumerate();
        pixels
            .map(|(pixel, ((low, high), (depth, mean)))| {
                *depth <= test.granted_depth_at(*mean)
                    && test.is_color_static(*low, *high)
                    && self.values.is_static(pixel, test.value_tolerances())
            })
            .collect()
    }

    /// Range of color over time of every pixel, the widest of the three channels, 8-bit sRGB steps.
    #[must_use]
    pub fn color_steps(&self) -> impl ExactSizeIterator<Item = f32> {
        let table = color::steps_table();
        let colors = self.low_color.as_slice().iter().zip(self.high_color.as_slice());
        colors.map(|(low, high)| color_range_steps(table, low, high))
    }

    /// The means of the pixels that are `chosen`.
    #[must_use]
    pub fn samples(&self, chosen: &[bool]) -> SpanSamples {
        let chosen = || (0..chosen.len()).filter(|pixel| chosen[*pixel]);
        let normals = self.mean_normal.as_ref();
        SpanSamples {
            pixels: chosen().map(|pixel| pixel as u32).collect(),
            color: chosen().map(|pixel| self.mean_color.as_slice()[pixel]).collect(),
            inverse_depth: chosen().map(|pixel| self.mean_inverse_depth.as_slice()[pixel]).collect(),
            normal: normals
                .map(|normals| chosen().map(|pixel| Vec3::from(normals.as_slice()[pixel])).collect())
                .unwrap_or_default(),
            values: self.values.first.at_places(&chosen().map(|pixel| pixel as u32).collect::<Vec<_>>()),
        }
    }

    /// How far the ranges of all pixels reach.
    #[must_use]
    pub fn shares(&self, test: &StaticTest) -> RangeHistogram {
        let mut shares = RangeHistogram::default();
        let colors = self.low_color.as_slice().iter().zip(self.high_color.as_slice());
        let granted: Vec<f32> = colors.map(|(low, high)| test.granted_within(*low, *high)).collect();
        let color: Vec<f32> = self.color_steps().collect();
        let depth =
            test.comparable(self.depth_relative.as_slice().to_vec(), self.mean_inverse_depth.as_slice());
        shares.count(&color, &depth, &granted, test);
        shares
    }
}

#[derive(Clone, Copy)]
struct PixelSum {
    low_color: [i16; 3],
    high_color: [i16; 3],
    color: [f32; 3],
    min_inverse_depth: f32,
    max_inverse_depth: f32,
    inverse_depth: f64,
    /// Sums of [`summand`].
    normal: [f64; 3],
    invalid: u32,
}

const EMPTY_SUM: PixelSum = PixelSum {
    low_color: [i16::MAX; 3],
    high_color: [0; 3],
    color: [0.0; 3],
    min_inverse_depth: f32::INFINITY,
    max_inverse_depth: f32::NEG_INFINITY,
    inverse_depth: 0.0,
    normal: [0.0; 3],
    invalid: 0,
};

/// Gathers [`SequenceRanges`] frame by frame.
pub(crate) struct CameraSum {
    width: usize,
    pixels: Vec<PixelSum>,
    has_normals: bool,
    values: ValueRanges,
}

impl CameraSum {
    pub(crate) fn new(width: usize, height: usize) -> Self {
        Self {
            width,
            pixels: vec![EMPTY_SUM; width * height],
            has_normals: false,
            values: ValueRanges::default(),
        }
    }

    /// Adds the next frame. Frames must come in order: floating-point sums depend on it.
    pub(crate) fn add(&mut self, frame: &Frame) {
        let width = self.width.max(1);
        self.pixels.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
            let colors = frame.color.row(y);
            let depths = frame.inverse_depth.row(y);
            for ((sum, color), &inverse_depth) in row.iter_mut().zip(colors).zip(depths) {
                add_pixel(sum, *color, inverse_depth);
            }
            if let Some(normals) = &frame.normal_in_world {
                for (sum, normal) in row.iter_mut().zip(normals.row(y)) {
                    (0..3).for_each(|axis| sum.normal[axis] += summand(normal[axis]));
                }
            }
        });
        self.has_normals |= frame.normal_in_world.is_some();
        if self.values.first.is_empty() {
            self.values = ValueRanges::of(frame.values.clone());
        } else {
            self.values.add_frame(|pixel| frame.values.of(pixel));
        }
    }

    /// Ranges and means over this many frames, and the number of pixels without depth.
    pub(crate) fn finish(self, frames: usize) -> (SequenceRanges, u64) {
        let (width, height) = (self.width, self.pixels.len() / self.width.max(1));
        let grid = |values| Grid::from_vec(width, height, values);
        let count = frames as f32;
        let pixels = &self.pixels;
        let ranges = SequenceRanges {
            low_color: Grid::from_vec(width, height, pixels.iter().map(|sum| sum.low_color).collect()),
            high_color: Grid::from_vec(width, height, pixels.iter().map(|sum| sum.high_color).collect()),
            depth_relative: grid(pixels.iter().map(depth_range_relative).collect()),
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
                    pixels.iter().map(|sum| direction(sum.normal).to_array()).collect(),
                )
            }),
            values: self.values,
        };
        (ranges, self.pixels.iter().map(|sum| u64::from(sum.invalid)).sum())
    }
}

fn add_pixel(sum: &mut PixelSum, color: [f16; 3], inverse_depth: f32) {
    if inverse_depth < 0.0 {
        sum.invalid += 1;
        return;
    }
    for channel in 0..3 {
        // Half floats from 0 up are in the order of their bits; what is below 0 counts as 0, as it does when shown.
        let bits = (color[channel].to_bits() as i16).max(0);
        sum.low_color[channel] = sum.low_color[channel].min(bits);
        sum.high_color[channel] = sum.high_color[channel].max(bits);
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
