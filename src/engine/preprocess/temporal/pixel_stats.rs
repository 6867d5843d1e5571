//! Range and sum of every pixel over a span, as planes: what is known of a span whose frames are gone.
//!
//! Half floats from 0 up order like their bits, so that minimum and maximum of color are those of 16-bit integers; what is
//! below 0 counts as 0, as it does when shown. Sums are exact whatever their order: a half float has 11 digits and `f32` 24,
//! an `f32` 24 and `f64` 53, which leaves room for thousands of frames of about one size. Normals have components of any size;
//! `summand` keeps as many of their digits as leave the same room.

use glam::Vec3;
use half::f16;
use half::slice::HalfFloatSliceExt;

use super::staticness::{CHANNELS, StaticTest, color_range_steps};
use super::value_ranges::ValueRanges;
use crate::capture::{INVALID_INVERSE_DEPTH, Values};
use crate::color::{self, WIDENING, widened_small};
use crate::error::Result;
use crate::samples::Record;
use crate::simd::{self, VectorLoop};

/// A frame from some pixel on, flat: color three to a pixel, inverse depth one, normals (where given) three.
#[derive(Clone, Copy)]
pub(super) struct FrameRun<'a> {
    /// Bits of half floats.
    pub color: &'a [i16],
    /// 1/z; negative where there is no depth.
    pub inverse_depth: &'a [f32],
    /// World-space normals; empty where the capture gives none.
    pub normal: &'a [f32],
    /// Scalar values of the whole frame; empty where the capture gives none.
    pub values: &'a Values,
    /// The pixel in the frame that comes first.
    pub first: usize,
}

impl<'a> FrameRun<'a> {
    /// The scalar values of a pixel.
    #[inline(always)]
    pub(super) fn values_of(&self, pixel: usize) -> &'a [f32] {
        self.values.of(self.first + pixel)
    }
}

/// How far the scalar values of the first pixels of some frames range.
fn value_ranges(frames: &[FrameRun<'_>], pixels: usize) -> ValueRanges {
    let Some((first, later)) = frames.split_first() else { return ValueRanges::default() };
    if first.values.is_empty() {
        return ValueRanges::default();
    }
    let mut ranges = ValueRanges::of(first.values.part_of(first.first..first.first + pixels));
    for frame in later {
        ranges.add_frame(|pixel| frame.values_of(pixel));
    }
    ranges
}

/// See the module's page. One entry per pixel, or three.
#[derive(Clone, Debug, Default)]
pub(crate) struct SpanSums {
    /// Frames that were added.
    pub(crate) frames: u32,
    /// Whether the pixel was static over every part of the span that was looked at.
    pub(crate) is_open: Vec<bool>,
    pub(crate) min_color: Vec<i16>,
    pub(crate) max_color: Vec<i16>,
    pub(crate) color: Vec<f32>,
    pub(crate) min_inverse_depth: Vec<f32>,
    pub(crate) max_inverse_depth: Vec<f32>,
    pub(crate) inverse_depth: Vec<f64>,
    /// Sums of [`summand`]; empty where the capture gives none.
    pub(crate) normal: Vec<f64>,
    /// Ranges of scalar values; empty where the capture gives none.
    pub(crate) values: ValueRanges,
}

impl SpanSums {
    /// The sums over the first `pixels` pixels of some frames, at least one.
    pub(super) fn of(frames: &[FrameRun<'_>], pixels: usize) -> Self {
        let normals = frames.first().map_or(0, |frame| frame.normal.len().min(3 * pixels));
        let open = vec![true; pixels];
        let mut sums = Self::zeroed(frames.len() as u32, open, normals, value_ranges(frames, pixels));
        simd::run(Add { sums: &mut sums, frames });
        sums
    }

    /// Nothing was added yet.
    fn zeroed(frames: u32, is_open: Vec<bool>, normals: usize, values: ValueRanges) -> Self {
        let pixels = is_open.len();
        Self {
            frames,
            is_open,
            min_color: vec![0; 3 * pixels],
            max_color: vec![0; 3 * pixels],
            color: vec![0.0; 3 * pixels],
            min_inverse_depth: vec![0.0; pixels],
            max_inverse_depth: vec![0.0; pixels],
            inverse_depth: vec![0.0; pixels],
            normal: vec![0.0; normals],
            values,
        }
    }

    /// Pixels.
    pub(super) fn pixels(&self) -> usize {
        self.inverse_depth.len()
    }

    /// Whether any pixel has no depth in some frame.
    pub(super) fn lacks_depth(&self) -> bool {
        self.min_inverse_depth.iter().fold(false, |lacks, w| lacks | (*w < 0.0))
    }

    /// Whether the pixel is open and stays within the tolerance.
    #[inline(always)]
    pub(super) fn is_static(&self, pixel: usize, test: &StaticTest) -> bool {
        self.is_static_with(self, pixel, test)
    }

    /// Whether the pixel is open in both and stays within the tolerance over both together.
    #[inline(always)]
    pub(super) fn is_static_with(&self, later: &Self, pixel: usize, test: &StaticTest) -> bool {
        if !(self.is_open[pixel] & later.is_open[pixel]) {
            return false;
        }
        let farthest = smaller(self.min_inverse_depth[pixel], later.min_inverse_depth[pixel]);
        let nearest = larger(self.max_inverse_depth[pixel], later.max_inverse_depth[pixel]);
        if relative_range(farthest, nearest) > test.granted_depth_at(nearest) {
            return false;
        }
        let low =
            |channel: usize| self.min_color[3 * pixel + channel].min(later.min_color[3 * pixel + channel]);
        let high =
            |channel: usize| self.max_color[3 * pixel + channel].max(later.max_color[3 * pixel + channel]);
        test.is_color_static([0, 1, 2].map(low), [0, 1, 2].map(high))
            && self.values.is_static_with(&later.values, pixel, test.value_tolerances())
    }

    /// Adds the frames that follow.
    pub(super) fn merge(&mut self, later: &Self) {
        self.frames += later.frames;
        self.values.merge(&later.values);
        simd::run(Merge { sums: self, later });
    }

    /// Takes the pixel out: no longer span is static there.
    pub(super) fn close(&mut self, pixel: usize) {
        self.is_open[pixel] = false;
    }

    /// Whether the pixel was not taken out, here or in a part of the span.
    pub(super) fn is_open(&self, pixel: usize) -> bool {
        self.is_open[pixel]
    }
}

/// A range of inverse depth as a share of its maximum; infinite where the smallest is negative: there is a frame without depth.
#[inline(always)]
pub(crate) fn relative_range(farthest: f32, nearest: f32) -> f32 {
    if farthest < 0.0 {
        f32::INFINITY
    } else if nearest > farthest {
        (nearest - farthest) / nearest
    } else {
        0.0
    }
}

/// A component of a unit normal as a multiple of 2⁻⁴⁰: sums of up to 8192 of them are exact, whatever their order.
#[inline(always)]
pub(crate) fn summand(component: f32) -> f64 {
    /// So large that what is added to it is rounded to multiples of 2⁻⁴⁰.
    const ROUNDING: f64 = 6144.0;
    f64::from(component) + ROUNDING - ROUNDING
}

/// The direction of a sum of normals.
pub(crate) fn direction(sum: [f64; 3]) -> Vec3 {
    Vec3::from(sum.map(|component| component as f32)).normalize_or_zero()
}

#[inline(always)]
pub(crate) fn smaller(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

#[inline(always)]
pub(crate) fn larger(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

/// Pixels whose sums are held in registers while frame after frame is added.
pub(crate) const REGISTER_PIXELS: usize = 16;

/// How many pixels ahead frames are prefetched.
const AHEAD: usize = 96;

/// Half floats in a cache line.
const LINE_COLORS: usize = 32;

/// Components of normals in a cache line.
const LINE_NORMALS: usize = 16;

struct Add<'a> {
    sums: &'a mut SpanSums,
    frames: &'a [FrameRun<'a>],
}

impl VectorLoop for Add<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { sums, frames } = self;
        let pixels = sums.pixels();
        for first in (0..pixels).step_by(REGISTER_PIXELS) {
            let count = REGISTER_PIXELS.min(pixels - first);
            let mut held = PixelSums::NOTHING;
            for frame in frames {
                // So many frames at once are more than the processor follows by itself.
                simd::prefetch(frame.color, 3 * (first + AHEAD));
                simd::prefetch(frame.color, 3 * (first + AHEAD) + LINE_COLORS);
                simd::prefetch(frame.inverse_depth, first + AHEAD);
                if let (Some(color), Some(w)) =
                    (frame.color[3 * first..].first_chunk(), frame.inverse_depth[first..].first_chunk())
                {
                    held.add(color, w);
                } else {
                    let (mut color, mut w) = ([0; 3 * REGISTER_PIXELS], [0.0; REGISTER_PIXELS]);
                    color[..3 * count].copy_from_slice(&frame.color[3 * first..][..3 * count]);
                    w[..count].copy_from_slice(&frame.inverse_depth[first..][..count]);
                    held.add(&color, &w);
                }
            }
            held.give(sums, first, count);
        }
        add_normals(&mut sums.normal, frames);
    }
}

/// Writes the sums of [`summand`] over all frames; of a frame without normals nothing is added.
#[inline(always)]
fn add_normals(sums: &mut [f64], frames: &[FrameRun<'_>]) {
    for (first, sums) in (0..).step_by(3 * REGISTER_PIXELS).zip(sums.chunks_mut(3 * REGISTER_PIXELS)) {
        let mut held = [0.0; 3 * REGISTER_PIXELS];
        for frame in frames {
            (0..3).for_each(|line| simd::prefetch(frame.normal, first + 3 * AHEAD + line * LINE_NORMALS));
            let normal = frame.normal.get(first..).unwrap_or_default();
            if let Some(normal) = normal.first_chunk::<{ 3 * REGISTER_PIXELS }>() {
                for i in 0..3 * REGISTER_PIXELS {
                    held[i] += summand(normal[i]);
                }
            } else {
                held.iter_mut().zip(normal).for_each(|(sum, component)| *sum += summand(*component));
            }
        }
        sums.copy_from_slice(&held[..sums.len()]);
    }
}

/// The sums of some pixels, and their ranges.
struct PixelSums {
    min_color: [i16; 3 * REGISTER_PIXELS],
    max_color: [i16; 3 * REGISTER_PIXELS],
    /// Sums of [`widened_small`].
    color: [f32; 3 * REGISTER_PIXELS],
    min_inverse_depth: [f32; REGISTER_PIXELS],
    max_inverse_depth: [f32; REGISTER_PIXELS],
    inverse_depth: [f64; REGISTER_PIXELS],
}

impl PixelSums {
    const NOTHING: Self = Self {
        min_color: [i16::MAX; 3 * REGISTER_PIXELS],
        max_color: [0; 3 * REGISTER_PIXELS],
        color: [0.0; 3 * REGISTER_PIXELS],
        min_inverse_depth: [f32::INFINITY; REGISTER_PIXELS],
        max_inverse_depth: [INVALID_INVERSE_DEPTH; REGISTER_PIXELS],
        inverse_depth: [0.0; REGISTER_PIXELS],
    };

    #[inline(always)]
    fn add(&mut self, color: &[i16; 3 * REGISTER_PIXELS], inverse_depth: &[f32; REGISTER_PIXELS]) {
        for i in 0..3 * REGISTER_PIXELS {
            self.min_color[i] = self.min_color[i].min(color[i].max(0));
        }
        for i in 0..3 * REGISTER_PIXELS {
            self.max_color[i] = self.max_color[i].max(color[i]);
        }
        for i in 0..3 * REGISTER_PIXELS {
            self.color[i] += widened_small(color[i]);
        }
        for i in 0..REGISTER_PIXELS {
            self.min_inverse_depth[i] = smaller(self.min_inverse_depth[i], inverse_depth[i]);
            self.max_inverse_depth[i] = larger(self.max_inverse_depth[i], inverse_depth[i]);
        }
        for i in 0..REGISTER_PIXELS {
            self.inverse_depth[i] += f64::from(inverse_depth[i]);
        }
    }

    /// Writes the first `count` pixels to those of `sums` from `first` on.
    #[inline(always)]
    fn give(&self, sums: &mut SpanSums, first: usize, count: usize) {
        let colors = 3 * first..3 * (first + count);
        sums.min_color[colors.clone()].copy_from_slice(&self.min_color[..3 * count]);
        sums.max_color[colors.clone()].copy_from_slice(&self.max_color[..3 * count]);
        for (sum, held) in sums.color[colors].iter_mut().zip(&self.color) {
            *sum = held * WIDENING;
        }
        let pixels = first..first + count;
        sums.min_inverse_depth[pixels.clone()].copy_from_slice(&self.min_inverse_depth[..count]);
        sums.max_inverse_depth[pixels.clone()].copy_from_slice(&self.max_inverse_depth[..count]);
        sums.inverse_depth[pixels].copy_from_slice(&self.inverse_depth[..count]);
    }
}

struct Merge<'a> {
    sums: &'a mut SpanSums,
    later: &'a SpanSums,
}

impl VectorLoop for Merge<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { sums, later } = self;
        for (open, &other) in sums.is_open.iter_mut().zip(&later.is_open) {
            *open &= other;
        }
        for (low, &other) in sums.min_color.iter_mut().zip(&later.min_color) {
            *low = (*low).min(other);
        }
        for (high, &other) in sums.max_color.iter_mut().zip(&later.max_color) {
            *high = (*high).max(other);
        }
        for (sum, &other) in sums.color.iter_mut().zip(&later.color) {
            *sum += other;
        }
        for (low, &other) in sums.min_inverse_depth.iter_mut().zip(&later.min_inverse_depth) {
            *low = smaller(*low, other);
        }
        for (high, &other) in sums.max_inverse_depth.iter_mut().zip(&later.max_inverse_depth) {
            *high = larger(*high, other);
        }
        for (sum, &other) in sums.inverse_depth.iter_mut().zip(&later.inverse_depth) {
            *sum += other;
        }
        for (sum, &other) in sums.normal.iter_mut().zip(&later.normal) {
            *sum += other;
        }
    }
}

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

impl Record for SpanSums {
    /// Frames, pixels, whether there are normals, and channels of values.
    type RecordShape = (u32, usize, bool, usize);

    fn bytes(&self) -> usize {
        self.planes().iter().map(|plane| plane.len()).sum()
    }

    fn shape(&self) -> (u32, usize, bool, usize) {
        (self.frames, self.pixels(), !self.normal.is_empty(), self.values.first.channels())
    }

    fn planes(&self) -> Vec<&[u8]> {
        vec![
            bytemuck::cast_slice(&self.is_open),
            bytemuck::cast_slice(&self.min_color),
            bytemuck::cast_slice(&self.max_color),
            bytemuck::cast_slice(&self.color),
            bytemuck::cast_slice(&self.min_inverse_depth),
            bytemuck::cast_slice(&self.max_inverse_depth),
            bytemuck::cast_slice(&self.inverse_depth),
            bytemuck::cast_slice(&self.normal),
            self.values.low.as_bytes(),
            self.values.high.as_bytes(),
            self.values.first.as_bytes(),
        ]
    }

    fn read(
        &(frames, pixels, normals, channels): &(u32, usize, bool, usize),
        fill: impl FnOnce(&mut [&mut [u8]]) -> Result<()>,
    ) -> Result<Self> {
        let mut is_open = vec![0_u8; pixels];
        let normals = if normals { 3 * pixels } else { 0 };
        let values = ValueRanges::missing(channels, pixels);
        let mut sums = Self::zeroed(frames, vec![false; pixels], normals, values);
        fill(&mut [
            &mut is_open,
            bytemuck::cast_slice_mut(&mut sums.min_color),
            bytemuck::cast_slice_mut(&mut sums.max_color),
            bytemuck::cast_slice_mut(&mut sums.color),
            bytemuck::cast_slice_mut(&mut sums.min_inverse_depth),
            bytemuck::cast_slice_mut(&mut sums.max_inverse_depth),
            bytemuck::cast_slice_mut(&mut sums.inverse_depth),
            bytemuck::cast_slice_mut(&mut sums.normal),
            sums.values.low.as_bytes_mut(),
            sums.values.high.as_bytes_mut(),
            sums.values.first.as_bytes_mut(),
        ])?;
        sums.is_open = is_open.into_iter().map(|open| open != 0).collect();
        Ok(sums)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::widened;

    #[test]
    fn sums_of_normals_are_the_same_in_any_order_and_those_of_equal_ones_point_where_they_do() {
        let mut state = 1_u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 23) as f32 - 1.0
        };
        let normals: Vec<Vec3> = (0..4000)
            .map(|_| Vec3::new(random().powi(9), random().powi(5), random().powi(3)).normalize_or_zero())
            .collect();
        let sum = |normals: &mut dyn Iterator<Item = &Vec3>| {
            let mut sum = [0.0; 3];
            normals.for_each(|n| (0..3).for_each(|axis| sum[axis] += summand(n[axis])));
            sum.map(f64::to_bits)
        };
        assert_eq!(sum(&mut normals.iter()), sum(&mut normals.iter().rev()));
        for normal in &normals {
            let sum = normal.to_array().map(|component| 16.0 * summand(component));
            assert!(direction(sum).abs_diff_eq(*normal, 4e-7), "{normal}");
        }
    }

    #[test]
    fn half_floats_are_widened_and_added_up_exactly() {
        let halves: Vec<f16> = (0..=u16::MAX).map(f16::from_bits).filter(|half| half.is_finite()).collect();
        let bits: Vec<i16> = halves.iter().map(|half| half.to_bits() as i16).collect();
        for (half, bits) in halves.iter().zip(&bits) {
            assert_eq!(widened(*bits).to_bits(), half.to_f32().to_bits(), "{half:?}");
        }
        let pixels = halves.len() / 3;
        let inverse_depth = vec![1.0; pixels];
        let run = FrameRun {
            color: &bits,
            inverse_depth: &inverse_depth,
            normal: &[],
            values: &crate::capture::NO_VALUES,
            first: 0,
        };
        let sums = SpanSums::of(&[run; 4], pixels);
        for pixel in 0..pixels {
            assert_eq!(
                mean_color(&sums, pixel),
                [0, 1, 2].map(|channel| halves[3 * pixel + channel]),
                "{pixel}"
            );
        }
    }
}
