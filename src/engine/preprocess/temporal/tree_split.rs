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

use half::f16;
use rayon::prelude::*;

use super::batch_split::{Batch, ShortSpans};
use super::pixel_stats::{
    FrameRun, SpanSums, color_ranges_steps, depth_ranges_relative, granted_color_steps, mean_color,
    mean_inverse_depth, mean_normal, write_means,
};
use super::prefilter::list_uncertain;
use super::range_histogram::RangeHistogram;
use super::span_store::SpanSamples;
use super::span_tree::SpanTree;
use super::staticness::StaticTest;
use crate::capture::Frame;
use crate::samples::Span;
use crate::settings::SpanLevels;

/// Pixels whose sums are worked on together: they stay in the cache of one core.
const CHUNK: usize = 2048;

/// Pixels that one task works on.
const BAND: usize = 4 * CHUNK;

/// Bands that are worked on one after the other, at most.
const JOB_BANDS: usize = 8;

/// Samples that a span has room for at first.
const ROOM: usize = 256;

/// The split of one camera while its frames come in.
pub struct Split {
    tree: SpanTree,
    test: StaticTest,
    added: u32,
    bands: Vec<SplitBand>,
    /// Spans that wait for the one beside them; each band holds the sums of each.
    open: Vec<Span>,
    /// Whether other runs of frames follow, or come before.
    is_run: bool,
}

/// Range and sum of all pixels over one span, a chunk of pixels after the other.
pub(crate) type OpenSums = Vec<SpanSums>;

struct SplitBand {
    first: usize,
    pixels: usize,
    /// `[chunk][open span]`
    chunks: Vec<Vec<SpanSums>>,
    invalid: u64,
    shares: RangeHistogram,
}

/// Samples of some spans, in no order of spans.
pub type FinishedSpans = Vec<(Span, SpanSamples)>;

impl Split {
    /// A split of `pixels` pixels over `frames` frames.
    #[must_use]
    pub fn new(pixels: usize, frames: usize, test: StaticTest) -> Self {
        let bands = (0..pixels).step_by(BAND).map(|first| {
            let count = BAND.min(pixels - first);
            SplitBand {
                first,
                pixels: count,
                chunks: vec![Vec::new(); count.div_ceil(CHUNK)],
                invalid: 0,
                shares: RangeHistogram::default(),
            }
        });
        Self {
            tree: SpanTree::new(frames, SpanLevels::Tree),
            test,
            added: 0,
            bands: bands.collect(),
            open: Vec::new(),
            is_run: false,
        }
    }

    /// A split of a run of frames alone, which begins at `start` and at a span of the tree.
    pub(crate) fn of_run(pixels: usize, frames: usize, start: u32, test: StaticTest) -> Self {
        Self { added: start, is_run: true, ..Self::new(pixels, frames, test) }
    }

    /// The spans that wait for the span beside them, in order, with the sums of their pixels.
    pub(crate) fn into_open(self) -> Vec<(Span, OpenSums)> {
        let mut chunks: Vec<_> =
            self.bands.into_iter().flat_map(|band| band.chunks).map(Vec::into_iter).collect();
        let sums_of_next = |span| (span, chunks.iter_mut().filter_map(Iterator::next).collect());
        self.open.into_iter().map(sums_of_next).collect()
    }

    /// Adds the following span, given by its open sums alone. Gives the samples of the spans that are finished now.
    pub(crate) fn add_sums(&mut self, span: Span, sums: OpenSums) -> FinishedSpans {
        self.added = span.end;
        let carry = self.carry(span);
        let is_last = span.end == self.tree.root().end;
        let batch = Batch { frames: &[], span, test: &self.test, carry: &carry, is_last };
        let mut sums = sums.into_iter();
        let bands = self.bands.iter_mut().map(|band| {
            let of_band: Vec<SpanSums> = sums.by_ref().take(band.chunks.len()).collect();
            (band, of_band)
        });
        let bands: Vec<_> = bands.collect();
        let found = bands.into_par_iter().with_max_len(JOB_BANDS).fold(
            || SplitSamples::new(&batch),
            |mut found, (band, sums)| {
                for (index, sums) in sums.into_iter().enumerate() {
                    band.put(index, sums, &batch, &mut found);
                }
                found
            },
        );
        join(found.collect(), &batch, self.tree.root())
    }

    /// Adds the frames that follow: [`BATCH`](crate::preprocess::temporal::batch_split::BATCH) of them, or a smaller power of two each time, and at the end the rest.
    /// Gives the samples of the spans that are finished now.
    pub fn add(&mut self, frames: &[Arc<Frame>]) -> FinishedSpans {
        let span = Span { start: self.added, end: self.added + frames.len() as u32 };
        self.added = span.end;
        let carry = self.carry(span);
        let batch = Batch {
            frames,
            span,
            test: &self.test,
            carry: &carry,
            is_last: !self.is_run && span.end == self.tree.root().end,
        };
        let bands = self.bands.par_iter_mut().with_max_len(JOB_BANDS);
        let found = bands.fold(
            || SplitSamples::new(&batch),
            |mut found, band| {
                band.add(&batch, &mut found);
                found
            },
        );
        join(found.collect(), &batch, self.tree.root())
    }

    /// Pixels without depth, over all frames added.
    #[must_use]
    pub fn invalid(&self) -> u64 {
        self.bands.iter().map(|band| band.invalid).sum()
    }

    /// How far the ranges of all pixels reach, once all frames are added.
    #[must_use]
    pub fn shares(&self) -> RangeHistogram {
        let mut all = RangeHistogram::default();
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

/// The samples that were found in bands that follow one another.
struct SplitSamples {
    short: ShortSpans,
    /// For each pair of spans in [`Batch::carry`].
    long: Vec<[SpanSamples; 2]>,
    /// Samples of the span of all frames, found with the last frames.
    root: SpanSamples,
    /// Pixels of a chunk that need a look of their own.
    uncertain: Vec<u16>,
}

impl SplitSamples {
    fn new(batch: &Batch<'_>) -> Self {
        let room = || SpanSamples::with_capacity(ROOM);
        Self {
            short: if batch.frames.is_empty() { ShortSpans::none() } else { ShortSpans::new(batch, ROOM) },
            long: batch.carry.iter().map(|_| [room(), room()]).collect(),
            root: SpanSamples::with_capacity(if batch.is_last { JOB_BANDS * BAND } else { 0 }),
            uncertain: Vec::with_capacity(CHUNK),
        }
    }

    fn into_spans(self, batch: &Batch<'_>, root: Span) -> FinishedSpans {
        let pairs = batch.carry.iter().zip(self.long);
        let long = pairs.flat_map(|(spans, samples)| spans.iter().copied().zip(samples));
        self.short.given.into_iter().chain(long).chain([(root, self.root)]).collect()
    }
}

/// The samples of all bands, those of a span together.
fn join(found: Vec<SplitSamples>, batch: &Batch<'_>, root: Span) -> FinishedSpans {
    let mut parts = found.into_iter().map(|found| found.into_spans(batch, root));
    let Some(mut joined) = parts.next() else { return FinishedSpans::new() };
    let later: Vec<FinishedSpans> = parts.collect();
    joined.par_iter_mut().enumerate().for_each(|(nth, (_, samples))| {
        let later = || later.iter().map(|given| &given[nth].1);
        samples.reserve(later().map(SpanSamples::len).sum());
        later().for_each(|later| samples.extend(later));
    });
    joined.retain(|(_, samples)| !samples.is_empty());
    joined
}

impl SplitBand {
    fn add(&mut self, batch: &Batch<'_>, found: &mut SplitSamples) {
        for index in 0..self.chunks.len() {
            let first = self.first + index * CHUNK;
            let pixels = CHUNK.min(self.first + self.pixels - first);
            let runs: Vec<FrameRun<'_>> = batch.frames.iter().map(|frame| run_of(frame, first)).collect();
            let count_invalid =
                |run: &FrameRun<'_>| run.inverse_depth[..pixels].iter().filter(|w| **w < 0.0).count();
            let mut sums = SpanSums::of(&runs, pixels);
            let SplitSamples { short, uncertain, .. } = found;
            list_uncertain([&sums, &sums], batch.test, uncertain);
            for &pixel in uncertain.iter() {
                let pixel = pixel as usize;
                if !sums.is_static(pixel, batch.test) {
                    short.push(batch, &runs, first, pixel);
                    sums.close(pixel);
                }
            }
            short.descend(batch, &runs, first);
            if sums.lacks_depth() {
                self.invalid += runs.iter().map(|run| count_invalid(run) as u64).sum::<u64>();
            }
            self.put(index, sums, batch, found);
        }
    }

    /// Puts what is known of a chunk over the batch beside what is known of earlier spans, as a binary counter carries.
    fn put(&mut self, index: usize, mut sums: SpanSums, batch: &Batch<'_>, found: &mut SplitSamples) {
        let SplitSamples { long, root, uncertain, .. } = found;
        let (open, first) = (&mut self.chunks[index], self.first + index * CHUNK);
        for given in &mut *long {
            let Some(left) = open.pop() else { break };
            list_uncertain([&left, &sums], batch.test, uncertain);
            sums = union(left, &sums, batch.test, first, uncertain, given);
        }
        if batch.is_last {
            let (color, depth) = (color_ranges_steps(&sums), depth_ranges_relative(&sums));
            let depth = batch.test.comparable(depth, &sums.max_inverse_depth);
            self.shares.count(&color, &depth, &granted_color_steps(&sums, batch.test), batch.test);
            take_open(root, first, &sums);
        } else {
            open.push(sums);
        }
    }
}

fn run_of(frame: &Frame, first: usize) -> FrameRun<'_> {
    let color: &[i16] = bytemuck::cast_slice(&frame.color.as_slice()[first..]);
    let normal = frame.normal_in_world.as_ref();
    FrameRun {
        color,
        inverse_depth: &frame.inverse_depth.as_slice()[first..],
        normal: normal.map_or(&[], |n| bytemuck::cast_slice(&n.as_slice()[first..])),
        values: &frame.values,
        first,
    }
}

/// The sums over two spans together. Where they are not static, which is tested for the `uncertain` pixels, the static ones of the two
/// become samples. `first` is the index of the first pixel.
fn union(
    mut left: SpanSums,
    right: &SpanSums,
    test: &StaticTest,
    first: usize,
    uncertain: &[u16],
    given: &mut [SpanSamples; 2],
) -> SpanSums {
    for pixel in uncertain.iter().map(|pixel| *pixel as usize) {
        if left.is_static_with(right, pixel, test) {
            continue;
        }
        for (sums, given) in [&left, right].into_iter().zip(&mut *given) {
            if sums.is_open(pixel) {
                give(given, first, pixel, sums);
            }
        }
        left.close(pixel);
    }
    left.merge(right);
    left
}

/// Adds the samples of all open pixels of `sums`, whose first pixel is `first`. In the span of all frames most pixels are open.
fn take_open(samples: &mut SpanSamples, first: usize, sums: &SpanSums) {
    let mut color = vec![[f16::ZERO; 3]; sums.pixels()];
    let mut inverse_depth = vec![0.0; sums.pixels()];
    write_means(sums, &mut color, &mut inverse_depth);
    for pixel in (0..sums.pixels()).filter(|pixel| sums.is_open(*pixel)) {
        samples.pixels.push((first + pixel) as u32);
        samples.color.push(color[pixel]);
        samples.inverse_depth.push(inverse_depth[pixel]);
        samples.normal.extend(mean_normal(sums, pixel));
        samples.values.push(sums.values.first.of(pixel));
    }
}

fn give(samples: &mut SpanSamples, first: usize, pixel: usize, sums: &SpanSums) {
    samples.pixels.push((first + pixel) as u32);
    samples.color.push(mean_color(sums, pixel));
    samples.inverse_depth.push(mean_inverse_depth(sums, pixel));
    samples.normal.extend(mean_normal(sums, pixel));
    samples.values.push(sums.values.first.of(pixel));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::{Demo, DemoSpec};
    use crate::preprocess::noise::measure_pairs;
    use crate::preprocess::temporal::batch_split::BATCH;
    use crate::settings::{CaptureSettings, SpanSettings};
    use crate::simd;

    #[test]
    fn every_instruction_set_finds_the_same_spans() {
        let spec = DemoSpec::new("nine-cameras").cameras(1).frames(40).size((75, 50));
        let capture = Demo::new(&spec).unwrap().capture(&CaptureSettings::default());
        let frames: Vec<_> = (0..40).map(|frame| capture.frame(0, frame).unwrap()).collect();
        let noise = measure_pairs(&[[&frames[0], &frames[1]]]);
        let test = StaticTest::new(&SpanSettings::default(), &noise, 0.0, frames.len());
        let found = simd::at_every_level(|| {
            let mut split = Split::new(75 * 50, frames.len(), test.clone());
            let given: Vec<FinishedSpans> = frames.chunks(BATCH).map(|frames| split.add(frames)).collect();
            (given, split.shares().facts(&test))
        });
        let short = found[0].0.iter().flatten().filter(|(span, _)| span.len() < 40);
        assert!(short.map(|(_, samples)| samples.len()).sum::<usize>() > 500);
        assert!(found.iter().all(|other| *other == found[0]));
    }
}
