//! What the sums over a span tell of its pixels: mean color, depth and normal, which become a sample, and how far they ranged.

use glam::Vec3;
use half::f16;
use half::slice::HalfFloatSliceExt;

use super::pixel_stats::{SpanSums, direction, relative_range};
use super::staticness::{CHANNELS, StaticTest, color_range_steps};
use crate::color;
use crate::simd::{self, VectorLoop};

/// Range of color of every pixel, the widest of the three channels, 8-bit sRGB steps.
pub(crate) fn color_ranges_steps(sums: &SpanSums) -> Vec<f32> {
    let table = color::steps_table();
    let (lows, highs) = (sums.min_color.as_chunks::<3>().0, sums.max_color.as_chunks::<3>().0);
    lows.iter().zip(highs).map(|(low, high)| color_range_steps(table, low, high)).collect()
}

/// Range of color that is granted to every pixel, 8-bit sRGB steps.
pub(crate) fn granted_color_steps(sums: &SpanSums, test: &StaticTest) -> Vec<f32> {
    let (lows, highs) = (sums.min_color.as_chunks::<3>().0, sums.max_color.as_chunks::<3>().0);
    lows.iter().zip(highs).map(|(low, high)| test.granted_within(*low, *high)).collect()
}

/// Range of inverse depth of every pixel as a share of its maximum, 0 to 1; infinite where some frame has no depth.
pub(crate) fn depth_ranges_relative(sums: &SpanSums) -> Vec<f32> {
    let ranges = sums.min_inverse_depth.iter().zip(&sums.max_inverse_depth);
    ranges.map(|(farthest, nearest)| relative_range(*farthest, *nearest)).collect()
}

/// Mean color, linear.
#[inline(always)]
pub(crate) fn mean_color(sums: &SpanSums, pixel: usize) -> [f16; 3] {
    let count = sums.frames as f32;
    [0, 1, 2].map(|channel| f16::from_f32(sums.color[3 * pixel + channel] / count))
}

/// Writes [`mean_color`] and [`mean_inverse_depth`] of every pixel.
pub(crate) fn write_means(sums: &SpanSums, color: &mut [[f16; 3]], inverse_depth: &mut [f32]) {
    simd::run(Means { sums, color, inverse_depth });
}

/// Mean inverse depth; exactly what was recorded where that is the same in every frame.
#[inline(always)]
pub(crate) fn mean_inverse_depth(sums: &SpanSums, pixel: usize) -> f32 {
    let farthest = sums.min_inverse_depth[pixel];
    if farthest == sums.max_inverse_depth[pixel] {
        farthest
    } else {
        (sums.inverse_depth[pixel] / f64::from(sums.frames)) as f32
    }
}

/// Mean direction of the given normals; `None` where the capture gives none.
pub(crate) fn mean_normal(sums: &SpanSums, pixel: usize) -> Option<Vec3> {
    Some(direction(*sums.normal.get(3 * pixel..)?.first_chunk()?))
}

struct Means<'a> {
    sums: &'a SpanSums,
    color: &'a mut [[f16; 3]],
    inverse_depth: &'a mut [f32],
}

impl VectorLoop for Means<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { sums, color, inverse_depth } = self;
        let frames = sums.frames as f32;
        for (sums, halves) in sums.color.chunks(CHANNELS).zip(color.as_flattened_mut().chunks_mut(CHANNELS)) {
            let mut means = [0.0; CHANNELS];
            means.iter_mut().zip(sums).for_each(|(mean, sum)| *mean = sum / frames);
            halves.convert_from_f32_slice(&means[..halves.len()]);
        }
        for (pixel, mean) in inverse_depth.iter_mut().enumerate() {
            *mean = mean_inverse_depth(sums, pixel);
        }
    }
}
