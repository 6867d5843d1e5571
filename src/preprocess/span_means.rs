//! What the sums over a span tell of its pixels: mean color, depth and normal, which become a sample, and how far they ranged.

use glam::Vec3;
use half::f16;
use half::slice::HalfFloatSliceExt;

use super::span_sums::{SpanSums, direction, relative_range};
use super::static_test::{CHANNELS, StaticTest, color_range_steps};
use crate::color;
use crate::simd::{self, Work};

impl SpanSums {
    /// Range of color of every pixel, the widest of the three channels, 8-bit sRGB steps.
    #[must_use]
    pub fn color_ranges_steps(&self) -> Vec<f32> {
        let table = color::steps_table();
        let (lows, highs) = (self.min_color.as_chunks::<3>().0, self.max_color.as_chunks::<3>().0);
        lows.iter().zip(highs).map(|(low, high)| color_range_steps(table, low, high)).collect()
    }

    /// Range of color that is granted to every pixel, 8-bit sRGB steps.
    pub(super) fn granted_color_steps(&self, test: &StaticTest) -> Vec<f32> {
        let (lows, highs) = (self.min_color.as_chunks::<3>().0, self.max_color.as_chunks::<3>().0);
        lows.iter().zip(highs).map(|(low, high)| test.granted_within(low, high)).collect()
    }

    /// Range of inverse depth of every pixel as a share of its maximum, 0 to 1; infinite where some frame has no depth.
    #[must_use]
    pub fn depth_ranges_relative(&self) -> Vec<f32> {
        let ranges = self.min_inverse_depth.iter().zip(&self.max_inverse_depth);
        ranges.map(|(farthest, nearest)| relative_range(*farthest, *nearest)).collect()
    }

    /// Mean color, linear.
    #[inline(always)]
    #[must_use]
    pub fn mean_color(&self, pixel: usize) -> [f16; 3] {
        let count = self.frames as f32;
        [0, 1, 2].map(|channel| f16::from_f32(self.color[3 * pixel + channel] / count))
    }

    /// Writes [`SpanSums::mean_color`] and [`SpanSums::mean_inverse_depth`] of every pixel.
    pub(super) fn write_means(&self, color: &mut [[f16; 3]], inverse_depth: &mut [f32]) {
        simd::run(Means { sums: self, color, inverse_depth });
    }

    /// Mean inverse depth; exactly what was recorded where that is the same in every frame.
    #[inline(always)]
    #[must_use]
    pub fn mean_inverse_depth(&self, pixel: usize) -> f32 {
        let farthest = self.min_inverse_depth[pixel];
        if farthest == self.max_inverse_depth[pixel] {
            farthest
        } else {
            (self.inverse_depth[pixel] / f64::from(self.frames)) as f32
        }
    }

    /// Mean direction of the given normals; `None` where the capture gives none.
    #[must_use]
    pub fn mean_normal(&self, pixel: usize) -> Option<Vec3> {
        Some(direction(*self.normal.get(3 * pixel..)?.first_chunk()?))
    }
}

struct Means<'a> {
    sums: &'a SpanSums,
    color: &'a mut [[f16; 3]],
    inverse_depth: &'a mut [f32],
}

impl Work for Means<'_> {
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
            *mean = sums.mean_inverse_depth(pixel);
        }
    }
}
