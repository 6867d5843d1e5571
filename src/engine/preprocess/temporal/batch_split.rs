//! The spans within a batch of frames: a pixel that is not static over all of them goes down into halves until it is.

use std::sync::Arc;

use glam::Vec3;
use half::f16;

use super::pixel_stats::{FrameRun, direction, relative_range, summand};
use super::span_store::SpanSamples;
use super::span_tree::halves;
use super::staticness::StaticTest;
use super::value_ranges::are_static;
use crate::capture::Frame;
use crate::color::widened;
use crate::samples::Span;
use crate::simd::{self, LANES, VectorLoop};

/// The spans within a batch.
pub(crate) struct ShortSpans {
    /// Halves of halves, each before its own halves.
    pub(crate) given: Vec<(Span, SpanSamples)>,
    /// `[index in given]`
    nodes: Vec<BatchNode>,
    /// `[index in given]`: of the pixels that go down.
    ranges: Vec<BatchRanges>,
    /// Pixels that wait until there are enough of them, ascending.
    waiting: [usize; LANES],
    waiting_count: usize,
}

/// A span within a batch.
#[derive(Clone, Copy)]
struct BatchNode {
    /// Frames of the batch, from one up to another.
    start: usize,
    end: usize,
    /// Indices of the halves; none where the span is one frame.
    halves: Option<[usize; 2]>,
}

/// Smallest and largest color and inverse depth of each pixel, as bits: of numbers that are not negative they are in the same
/// order, and a depth that is missing comes before all others.
#[derive(Clone, Copy)]
struct BatchRanges {
    low_color: [[i16; LANES]; 3],
    high_color: [[i16; LANES]; 3],
    low_depth: [i32; LANES],
    high_depth: [i32; LANES],
}

impl BatchRanges {
    const NOTHING: Self = Self {
        low_color: [[i16::MAX; LANES]; 3],
        high_color: [[0; LANES]; 3],
        low_depth: [i32::MAX; LANES],
        high_depth: [i32::MIN; LANES],
    };

    /// Over one frame.
    #[inline(always)]
    fn of(run: &FrameRun<'_>, pixels: &[usize; LANES]) -> Self {
        let mut ranges = Self::NOTHING;
        for (i, &pixel) in pixels.iter().enumerate() {
            let color = &run.color[3 * pixel..3 * pixel + 3];
            (0..3).for_each(|channel| ranges.low_color[channel][i] = color[channel].max(0));
            // A depth of −0 is one of 0.
            ranges.low_depth[i] = (run.inverse_depth[pixel] + 0.0).to_bits() as i32;
        }
        (ranges.high_color, ranges.high_depth) = (ranges.low_color, ranges.low_depth);
        ranges
    }

    #[inline(always)]
    fn with(&self, other: &Self) -> Self {
        let mut both = *self;
        for channel in 0..3 {
            for i in 0..LANES {
                both.low_color[channel][i] = self.low_color[channel][i].min(other.low_color[channel][i]);
                both.high_color[channel][i] = self.high_color[channel][i].max(other.high_color[channel][i]);
            }
        }
        for i in 0..LANES {
            both.low_depth[i] = self.low_depth[i].min(other.low_depth[i]);
            both.high_depth[i] = self.high_depth[i].max(other.high_depth[i]);
        }
        both
    }

    /// The pixels that have a depth in every frame, whose relative range does not exceed what is granted: one bit each.
    #[inline(always)]
    fn with_static_depth(&self, granted: impl Fn(f32) -> f32) -> u32 {
        let depth = |bits: i32| f32::from_bits(bits as u32);
        simd::mask(|i| {
            let nearest = depth(self.high_depth[i]);
            relative_range(depth(self.low_depth[i]), nearest) <= granted(nearest)
        })
    }

    /// Whether the color of one pixel stays within the tolerance; see [`StaticTest::is_color_static`].
    #[inline(always)]
    fn is_color_static(&self, i: usize, test: &StaticTest) -> bool {
        let of = |color: &[[i16; LANES]; 3]| [color[0][i], color[1][i], color[2][i]];
        test.is_color_static(of(&self.low_color), of(&self.high_color))
    }
}

impl ShortSpans {
    /// With room for this many samples of each span at first.
    pub(crate) fn new(batch: &Batch<'_>, room: usize) -> Self {
        let mut spans = vec![batch.span];
        let mut nodes = Vec::new();
        let mut next = 0;
        while next < spans.len() {
            let span = spans[next];
            let local = |frame: u32| (frame - batch.span.start) as usize;
            let halves = halves(span).map(|halves| {
                spans.extend(halves);
                [spans.len() - 2, spans.len() - 1]
            });
            nodes.push(BatchNode { start: local(span.start), end: local(span.end), halves });
            next += 1;
        }
        let ranges = vec![BatchRanges::NOTHING; spans.len()];
        let given = spans.into_iter().map(|span| (span, SpanSamples::with_capacity(room))).collect();
        Self { given, nodes, ranges, waiting: [0; LANES], waiting_count: 0 }
    }

    /// The split of no frames.
    pub(crate) fn none() -> Self {
        let (given, nodes, ranges) = (Vec::new(), Vec::new(), Vec::new());
        Self { given, nodes, ranges, waiting: [0; LANES], waiting_count: 0 }
    }

    /// Takes a pixel of `runs` that is not static over the batch. `first` is the index of the first pixel of the runs in the picture.
    #[inline(always)]
    pub(crate) fn push(&mut self, batch: &Batch<'_>, runs: &[FrameRun<'_>], first: usize, pixel: usize) {
        self.waiting[self.waiting_count % LANES] = pixel;
        self.waiting_count += 1;
        if self.waiting_count == LANES {
            self.descend(batch, runs, first);
        }
    }

    /// Gives out the spans over which the pixels that wait are static: those of one run after the other.
    pub(crate) fn descend(&mut self, batch: &Batch<'_>, runs: &[FrameRun<'_>], first: usize) {
        let count = std::mem::take(&mut self.waiting_count);
        if count > 0 {
            // Missing places repeat a pixel; its results are not looked at.
            let pixel = self.waiting[0];
            self.waiting[count..].fill(pixel);
            simd::run(Descend {
                spans: self,
                test: batch.test,
                runs,
                first,
                asked: u32::MAX >> (32 - count),
            });
        }
    }
}

struct Descend<'a> {
    spans: &'a mut ShortSpans,
    test: &'a StaticTest,
    runs: &'a [FrameRun<'a>],
    first: usize,
    /// One bit for each pixel that there is.
    asked: u32,
}

impl VectorLoop for Descend<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self {
            spans: ShortSpans { given, nodes, ranges, waiting: pixels, .. },
            test,
            runs,
            first,
            asked,
        } = self;
        // Halves come after what they are halves of: from the back, each range is that of two known ones.
        for (index, node) in nodes.iter().enumerate().skip(1).rev() {
            ranges[index] = match node.halves {
                None => BatchRanges::of(&runs[node.start], pixels),
                Some([left, right]) => ranges[left].with(&ranges[right]),
            };
        }
        // The batch itself is known not to be static.
        let mut open = [0; 2 * BATCH];
        open[0] = asked;
        for (index, node) in nodes.iter().enumerate() {
            let (range, runs) = (&ranges[index], &runs[node.start..node.end]);
            let mut is_static = 0;
            if index > 0 && open[index] != 0 {
                let is_of_one_frame = node.halves.is_none();
                let granted =
                    |nearest: f32| if is_of_one_frame { f32::MAX } else { test.granted_depth_at(nearest) };
                is_static = open[index] & range.with_static_depth(granted);
            }
            let mut left = is_static;
            while left != 0 {
                let i = left.trailing_zeros() as usize % LANES;
                left &= left - 1;
                let pixel = pixels[i];
                if node.halves.is_some()
                    && !(range.is_color_static(i, test) && has_static_values(runs, pixel, test))
                {
                    is_static &= !(1 << i);
                    continue;
                }
                let samples = &mut given[index].1;
                samples.pixels.push((first + pixel) as u32);
                samples.color.push(match runs {
                    [run] => bytemuck::cast(*run.color[3 * pixel..].first_chunk::<3>().unwrap_or(&[0; 3])),
                    runs => mean(runs, pixel).map(f16::from_f32),
                });
                samples.inverse_depth.push(mean_depth(runs, pixel, range.low_depth[i], range.high_depth[i]));
                if !runs[0].normal.is_empty() {
                    samples.normal.push(mean_normal(runs, pixel));
                }
                samples.values.push(runs[0].values_of(pixel));
            }
            if let Some([left, right]) = node.halves {
                let still_open = open[index] & !is_static;
                (open[left], open[right]) = (still_open, still_open);
            }
        }
    }
}

/// Whether the scalar values of a pixel stay within their tolerances.
#[inline(always)]
fn has_static_values(runs: &[FrameRun<'_>], pixel: usize, test: &StaticTest) -> bool {
    let tolerances = test.value_tolerances();
    tolerances.is_empty() || are_static(runs.iter().map(|run| run.values_of(pixel)), tolerances)
}

fn mean(runs: &[FrameRun<'_>], pixel: usize) -> [f32; 3] {
    let mut sums = [0.0; 3];
    for run in runs {
        let color = &run.color[3 * pixel..3 * pixel + 3];
        for channel in 0..3 {
            sums[channel] += widened(color[channel]);
        }
    }
    sums.map(|sum| sum / runs.len() as f32)
}

fn mean_depth(runs: &[FrameRun<'_>], pixel: usize, low: i32, high: i32) -> f32 {
    if low == high {
        return f32::from_bits(low as u32);
    }
    let sum: f64 = runs.iter().map(|run| f64::from(run.inverse_depth[pixel])).sum();
    (sum / runs.len() as f64) as f32
}

fn mean_normal(runs: &[FrameRun<'_>], pixel: usize) -> Vec3 {
    let mut sums = [0.0; 3];
    for run in runs {
        let normal = &run.normal[3 * pixel..3 * pixel + 3];
        (0..3).for_each(|axis| sums[axis] += summand(normal[axis]));
    }
    direction(sums)
}

/// Frames that are looked at together, at most: a power of two, so that a batch is a span of the tree.
pub const BATCH: usize = 16;

/// Frames that follow one another, and what becomes of their spans.
pub(crate) struct Batch<'a> {
    pub(crate) frames: &'a [Arc<Frame>],
    pub(crate) span: Span,
    pub(crate) test: &'a StaticTest,
    pub(crate) carry: &'a [[Span; 2]],
    pub(crate) is_last: bool,
}
