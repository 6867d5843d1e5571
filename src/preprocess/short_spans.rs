//! The spans within a batch of frames: a pixel that is not static over all of them goes down into halves until it is.

use glam::Vec3;
use half::f16;

use super::Span;
use super::span_samples::SpanSamples;
use super::span_sums::{FrameRun, relative_range, widened};
use super::span_tree::halves;
use super::split::{BATCH, Batch};
use super::static_test::StaticTest;

/// The spans within a batch.
pub(super) struct ShortSpans {
    /// Halves of halves, each before its own halves.
    pub(super) given: Vec<(Span, SpanSamples)>,
    /// `[index in given]`: frames of the batch, and where the halves stand in `given`.
    nodes: Vec<(usize, usize, [usize; 2])>,
    /// `[index in given]`: range of the pixel that is looked at.
    ranges: Vec<Range>,
}

const LEAF: usize = usize::MAX;

/// Smallest and largest color and inverse depth, as bits: of numbers that are not negative they are in the same order, and a
/// depth that is missing comes before all others.
#[derive(Clone, Copy)]
struct Range {
    low: [i32; 4],
    high: [i32; 4],
}

impl Range {
    const NOTHING: Self = Self { low: [i32::MAX; 4], high: [i32::MIN; 4] };

    #[inline(always)]
    fn with(&self, other: &Self) -> Self {
        let mut both = *self;
        for i in 0..4 {
            both.low[i] = both.low[i].min(other.low[i]);
            both.high[i] = both.high[i].max(other.high[i]);
        }
        both
    }

    #[inline(always)]
    fn farthest(&self) -> f32 {
        f32::from_bits(self.low[3] as u32)
    }

    #[inline(always)]
    fn has_depth(&self) -> bool {
        self.farthest() >= 0.0
    }

    /// Whether the color stays within the tolerance over some frames; see [`StaticTest::is_color_static`].
    #[inline(always)]
    fn is_color_static(&self, test: &StaticTest, mean: impl FnOnce() -> [f32; 3]) -> bool {
        let bits = |of: &[i32; 4]| [of[0] as i16, of[1] as i16, of[2] as i16];
        test.is_color_static(bits(&self.low), bits(&self.high), mean)
    }

    #[inline(always)]
    fn depth_relative(&self) -> f32 {
        relative_range(self.farthest(), f32::from_bits(self.high[3] as u32))
    }
}

impl ShortSpans {
    pub(super) fn new(batch: &Batch<'_>, mut room: impl FnMut() -> SpanSamples) -> Self {
        let mut spans = vec![batch.span];
        let mut nodes = Vec::new();
        let mut next = 0;
        while next < spans.len() {
            let span = spans[next];
            let local = |frame: u32| (frame - batch.span.start) as usize;
            let children = halves(span).map_or([LEAF; 2], |halves| {
                spans.extend(halves);
                [spans.len() - 2, spans.len() - 1]
            });
            nodes.push((local(span.start), local(span.end), children));
            next += 1;
        }
        let ranges = vec![Range::NOTHING; spans.len()];
        Self { given: spans.into_iter().map(|span| (span, room())).collect(), nodes, ranges }
    }

    /// Gives out the spans over which a pixel that is not static over the batch is.
    pub(super) fn descend(&mut self, batch: &Batch<'_>, runs: &[FrameRun<'_>], first: usize, pixel: usize) {
        // Halves stand behind what they are halves of: from the back, each range is that of two known ones.
        for (index, &(start, _, children)) in self.nodes.iter().enumerate().rev() {
            self.ranges[index] = if children[0] == LEAF {
                let run = &runs[start];
                let bits = |channel: usize| i32::from(run.color[3 * pixel + channel].max(0));
                // A depth of −0 is one of 0.
                let depth = (run.inverse_depth[pixel] + 0.0).to_bits() as i32;
                let value = [bits(0), bits(1), bits(2), depth];
                Range { low: value, high: value }
            } else {
                self.ranges[children[0]].with(&self.ranges[children[1]])
            };
        }
        // The batch itself is known not to be static.
        let mut waiting = [0_usize; 2 * BATCH];
        let mut count = 0;
        let children = self.nodes[0].2;
        if children[0] != LEAF {
            waiting[..2].copy_from_slice(&children);
            count = 2;
        }
        while count > 0 {
            count -= 1;
            let index = waiting[count];
            let (start, end, children) = self.nodes[index];
            let is_leaf = children[0] == LEAF;
            let range = &self.ranges[index];
            let is_static = range.has_depth()
                && (is_leaf
                    || range.depth_relative() <= batch.test.granted_depth()
                        && range.is_color_static(batch.test, || mean(&runs[start..end], pixel)));
            if is_static {
                let samples = &mut self.given[index].1;
                samples.pixels.push((first + pixel) as u32);
                if is_leaf {
                    let color = &runs[start].color[3 * pixel..3 * pixel + 3];
                    samples.color.push([0, 1, 2].map(|channel| f16::from_bits(color[channel] as u16)));
                    samples.inverse_depth.push(range.farthest());
                } else {
                    samples.color.push(mean(&runs[start..end], pixel).map(f16::from_f32));
                    samples.inverse_depth.push(mean_depth(&runs[start..end], pixel, range));
                }
                if !runs[start].normal.is_empty() {
                    samples.normal.push(mean_normal(&runs[start..end], pixel));
                }
            } else if !is_leaf {
                waiting[count..count + 2].copy_from_slice(&children);
                count += 2;
            }
        }
    }
}

fn mean(runs: &[FrameRun<'_>], pixel: usize) -> [f32; 3] {
    [0, 1, 2].map(|channel| {
        let sum: f32 = runs.iter().map(|run| widened(run.color[3 * pixel + channel])).sum();
        sum / runs.len() as f32
    })
}

fn mean_depth(runs: &[FrameRun<'_>], pixel: usize, range: &Range) -> f32 {
    if range.low[3] == range.high[3] {
        return range.farthest();
    }
    let sum: f64 = runs.iter().map(|run| f64::from(run.inverse_depth[pixel])).sum();
    (sum / runs.len() as f64) as f32
}

fn mean_normal(runs: &[FrameRun<'_>], pixel: usize) -> Vec3 {
    let normals = runs.iter().map(|run| Vec3::from_slice(&run.normal[3 * pixel..3 * pixel + 3]));
    normals.sum::<Vec3>().normalize_or_zero()
}
