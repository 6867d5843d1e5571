//! Temporal redundancy, generalized (the paper, §3.2): every pixel lives in the longest spans over which it is static.
//!
//! Purpose: one pass over the frames of a camera finds, for every pixel, the longest spans of the [`SpanTree`] over which it is
//! static; at every frame exactly one of them holds. Images in memory: a batch of frames, and one per level of the tree.
//!
//! Source: Interactive Dynamic Environments Using Image-Based Modeling and Rendering, §3.2, which knows two spans, all frames
//! (background) and one (foreground). What differs: the lengths between, and the mean over the span as the sample's value.
//!
//! ```text
//! frames ─▶ batch of 16 ─▶ static over the batch? ── no ─▶ down into halves until static: samples of short spans
//!                                  │ yes                                    (all longer spans are ruled out)
//!                                  ▼
//!                 range and sum, one image per level, merged as a binary counter carries:
//!                 both halves static, and their union too? ── no ─▶ the static halves become samples
//! ```
//!
//! A sample is given out when the span twice as long fails, not before; what is still static at the end is the background.

use std::sync::Arc;

use glam::Vec3;
use half::f16;
use rayon::prelude::*;

use super::Span;
use super::range_shares::RangeShares;
use super::span_samples::SpanSamples;
use super::span_sums::{FrameRun, SpanSums, widened};
use super::span_tree::{SpanTree, halves};
use super::static_test::StaticTest;
use crate::capture::Frame;
use crate::settings::SpanLevels;

/// Frames that are looked at together, at most: a power of two, so that a batch is a span of the tree.
pub const BATCH: usize = 16;

/// Pixels whose sums are worked on together: they fit into the innermost cache.
const CHUNK: usize = 512;

/// Pixels that one task works on.
const BAND: usize = 16 * CHUNK;

/// The split of one camera while its frames come in.
pub struct Split {
    tree: SpanTree,
    test: StaticTest,
    added: u32,
    bands: Vec<Band>,
    /// Spans that wait for the one beside them; each band holds the sums of each.
    open: Vec<Span>,
}

struct Band {
    first: usize,
    pixels: usize,
    /// `[chunk][open span]`
    chunks: Vec<Vec<SpanSums>>,
    invalid: u64,
    shares: RangeShares,
    /// Room for samples that was used before.
    spare: Vec<SpanSamples>,
}

/// Samples of some spans, in no order of spans.
pub type Given = Vec<(Span, SpanSamples)>;

impl Split {
    /// A split of `pixels` pixels over `frames` frames.
    #[must_use]
    pub fn new(pixels: usize, frames: usize, test: StaticTest) -> Self {
        let bands = (0..pixels).step_by(BAND).map(|first| {
            let count = BAND.min(pixels - first);
            Band {
                first,
                pixels: count,
                chunks: vec![Vec::new(); count.div_ceil(CHUNK)],
                invalid: 0,
                shares: RangeShares::default(),
                spare: Vec::new(),
            }
        });
        Self {
            tree: SpanTree::new(frames, SpanLevels::Tree),
            test,
            added: 0,
            bands: bands.collect(),
            open: Vec::new(),
        }
    }

    /// Adds the frames that follow: [`BATCH`] of them, or a smaller power of two each time; at the end, what is left. Gives
    /// the samples of the spans that are settled now.
    pub fn add(&mut self, frames: &[Arc<Frame>]) -> Given {
        let span = Span { start: self.added, end: self.added + frames.len() as u32 };
        self.added = span.end;
        let carry = self.carry(span);
        let batch = Batch {
            frames,
            span,
            test: &self.test,
            carry: &carry,
            is_last: span.end == self.tree.root().end,
        };
        let given: Vec<Given> = self.bands.par_iter_mut().map(|band| band.add(&batch)).collect();
        let joined = join(&given);
        for (band, given) in self.bands.iter_mut().zip(given) {
            band.spare.extend(given.into_iter().map(|(_, mut samples)| {
                samples.clear();
                samples
            }));
        }
        joined
    }

    /// Frames added.
    #[must_use]
    pub fn frames(&self) -> usize {
        self.added as usize
    }

    /// Pixels without depth, over all frames added.
    #[must_use]
    pub fn invalid(&self) -> u64 {
        self.bands.iter().map(|band| band.invalid).sum()
    }

    /// How far the ranges of all pixels reach, once all frames are added.
    #[must_use]
    pub fn shares(&self) -> RangeShares {
        let mut all = RangeShares::default();
        self.bands.iter().for_each(|band| all.join(&band.shares));
        all
    }

    /// Pairs of spans that become one once `span` is complete, in order.
    fn carry(&mut self, span: Span) -> Vec<[Span; 2]> {
        let mut carry = Vec::new();
        let mut right = span;
        while let Some(&left) = self.open.last() {
            let union = Span { start: left.start, end: right.end };
            if self.tree.parent(right) != Some(union) {
                break;
            }
            self.open.pop();
            carry.push([left, right]);
            right = union;
        }
        self.open.push(right);
        carry
    }
}

/// The samples of all bands, those of a span together.
fn join(bands: &[Given]) -> Given {
    let mut counts: Vec<(Span, usize)> = Vec::new();
    for (span, samples) in bands.iter().flatten().filter(|(_, samples)| !samples.is_empty()) {
        match counts.iter_mut().find(|(other, _)| other == span) {
            Some((_, count)) => *count += samples.len(),
            None => counts.push((*span, samples.len())),
        }
    }
    let joined = counts.into_par_iter().map(|(span, count)| {
        let mut all = SpanSamples::with_capacity(count);
        let of_span = bands.iter().flatten().filter(|(other, _)| *other == span);
        of_span.for_each(|(_, samples)| all.extend(samples));
        (span, all)
    });
    joined.collect()
}

struct Batch<'a> {
    frames: &'a [Arc<Frame>],
    span: Span,
    test: &'a StaticTest,
    carry: &'a [[Span; 2]],
    is_last: bool,
}

impl Band {
    fn add(&mut self, batch: &Batch<'_>) -> Given {
        let mut room = || self.spare.pop().unwrap_or_default();
        let mut long: Vec<[SpanSamples; 2]> = batch.carry.iter().map(|_| [room(), room()]).collect();
        let mut short = ShortSpans::new(batch, room);
        let mut root = SpanSamples::with_capacity(if batch.is_last { self.pixels } else { 0 });
        for (index, open) in self.chunks.iter_mut().enumerate() {
            let first = self.first + index * CHUNK;
            let pixels = CHUNK.min(self.first + self.pixels - first);
            let runs: Vec<FrameRun<'_>> = batch.frames.iter().map(|frame| run_of(frame, first)).collect();
            let count_invalid =
                |run: &FrameRun<'_>| run.inverse_depth[..pixels].iter().filter(|w| **w < 0.0).count();
            let mut sums = SpanSums::of(&runs, pixels);
            for pixel in 0..pixels {
                if !sums.is_static(pixel, batch.test) {
                    short.descend(batch, &runs, first, pixel);
                    sums.close(pixel);
                }
            }
            if sums.lacks_depth() {
                self.invalid += runs.iter().map(|run| count_invalid(run) as u64).sum::<u64>();
            }
            for given in &mut long {
                let Some(left) = open.pop() else { break };
                sums = union(left, &sums, batch.test, first, given);
            }
            if batch.is_last {
                let means = sums.mean_colors();
                for pixel in 0..pixels {
                    self.shares.add(&sums, &means, pixel, batch.test);
                    if sums.is_open(pixel) {
                        give(&mut root, first, pixel, &sums, means[pixel]);
                    }
                }
            } else {
                open.push(sums);
            }
        }
        let long = batch.carry.iter().zip(long).flat_map(|(spans, given)| spans.iter().copied().zip(given));
        let whole = Span { start: 0, end: batch.span.end };
        short.given.into_iter().chain(long).chain(std::iter::once((whole, root))).collect()
    }
}

fn run_of(frame: &Frame, first: usize) -> FrameRun<'_> {
    let color: &[i16] = bytemuck::cast_slice(&frame.color.as_slice()[first..]);
    let normal = frame.normal_in_world.as_ref();
    FrameRun {
        color,
        inverse_depth: &frame.inverse_depth.as_slice()[first..],
        normal: normal.map_or(&[], |n| bytemuck::cast_slice(&n.as_slice()[first..])),
    }
}

/// The sums over two spans together. Where they are not static, the static ones of the two become samples.
fn union(
    mut left: SpanSums,
    right: &SpanSums,
    test: &StaticTest,
    first: usize,
    given: &mut [SpanSamples; 2],
) -> SpanSums {
    for pixel in 0..left.pixels() {
        if left.is_static_with(right, pixel, test) {
            continue;
        }
        for (sums, given) in [&left, right].into_iter().zip(&mut *given) {
            if sums.is_open(pixel) {
                give(given, first, pixel, sums, sums.mean_color(pixel));
            }
        }
        left.close(pixel);
    }
    left.merge(right);
    left
}

fn give(samples: &mut SpanSamples, first: usize, pixel: usize, sums: &SpanSums, mean_color: [f16; 3]) {
    samples.pixels.push((first + pixel) as u32);
    samples.color.push(mean_color);
    samples.inverse_depth.push(sums.mean_inverse_depth(pixel));
    if let Some(normal) = sums.mean_normal(pixel) {
        samples.normal.push(normal);
    }
}

/// The spans within a batch.
struct ShortSpans {
    /// Halves of halves, each before its own halves.
    given: Vec<(Span, SpanSamples)>,
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

    /// Whether the color stays within the tolerance over some frames; `mean` is asked for where a look at the range is not
    /// enough.
    #[inline(always)]
    fn is_color_static(&self, test: &StaticTest, mean: impl FnOnce() -> [f32; 3]) -> bool {
        let is_clear =
            |channel: usize| test.is_clearly_static(self.low[channel] as i16, self.high[channel] as i16);
        if is_clear(0) & is_clear(1) & is_clear(2) {
            return true;
        }
        let bits = |of: &[i32; 4]| [of[0] as i16, of[1] as i16, of[2] as i16];
        test.is_color_static(bits(&self.low), bits(&self.high), mean)
    }

    #[inline(always)]
    fn depth_relative(&self) -> f32 {
        let (farthest, nearest) = (self.farthest(), f32::from_bits(self.high[3] as u32));
        if nearest > farthest { (nearest - farthest) / nearest } else { 0.0 }
    }
}

impl ShortSpans {
    fn new(batch: &Batch<'_>, mut room: impl FnMut() -> SpanSamples) -> Self {
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
    fn descend(&mut self, batch: &Batch<'_>, runs: &[FrameRun<'_>], first: usize, pixel: usize) {
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
