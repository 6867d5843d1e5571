//! Painting: each kernel over each set and size of picture, everything anew; and over a cached background while the vantage
//! is still (the paper, §3.3).

use std::sync::Arc;

use super::Bench;
use super::backend::Backend;
use super::measure::{Times, repeat};
use super::report::{Bound, Measured, Painting};
use super::scene::{FRAMES, Scene};
use crate::error::Result;
use crate::preprocess::SampleSet;
use crate::render::Vantage;
use crate::settings::{Kernel, RenderSettings};

/// What is painted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum What {
    /// Every sample of the unpruned set, anew each time.
    Unpruned,
    /// Every sample of the pruned set, anew each time.
    Pruned,
    /// The split set at one frame after the other, from a place that moves and from one that does not.
    Frames,
}

/// One way to paint one set.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PaintCase {
    pub(super) backend: Backend,
    pub(super) kernel: Kernel,
    pub(super) what: What,
    /// Columns and rows of the picture.
    pub(super) size: (u32, u32),
}

/// Every backend with every kernel over the two sets at both sizes, and over the split set at the second.
pub(super) fn cases(sizes: [(u32, u32); 2]) -> Vec<PaintCase> {
    let mut cases = Vec::new();
    for backend in Backend::ALL {
        for &kernel in Kernel::ALL {
            for what in [What::Unpruned, What::Pruned] {
                cases.extend(sizes.map(|size| PaintCase { backend, kernel, what, size }));
            }
            cases.push(PaintCase { backend, kernel, what: What::Frames, size: sizes[1] });
        }
    }
    cases
}

/// What was seen of the last picture of a stage.
#[derive(Clone, Copy, Default)]
struct Seen {
    holes: u64,
    background_reused: bool,
}

impl PaintCase {
    /// The stages that come of it.
    pub(super) fn names(&self) -> Vec<String> {
        let whats: &[&str] = match self.what {
            What::Unpruned => &["unpruned"],
            What::Pruned => &["pruned"],
            What::Frames => &["moving-vantage", "still-vantage"],
        };
        let (width, height) = self.size;
        // The CPU goes without saying.
        let backend = match self.backend {
            Backend::Cpu => String::new(),
        };
        whats.iter().map(|what| format!("render/{backend}{}/{what}/{width}x{height}", self.kernel)).collect()
    }

    /// Measures with the threads of the current pool.
    ///
    /// # Errors
    /// `Cancelled`, and what painting gives.
    pub(super) fn measure(&self, bench: &Bench<'_>) -> Result<Vec<Measured>> {
        let scene = bench.scene;
        let set = match self.what {
            What::Unpruned => &scene.unpruned,
            What::Pruned => &scene.pruned,
            What::Frames => &scene.split,
        };
        let moving = self.moving_vantages(scene);
        let (times, seen) = self.paint(bench, set, &moving)?;
        let everything = samples_at(set, 0, |_| true);
        let mut full = self.measured(set, everything, times, seen);
        let mut names = self.names().into_iter();
        full.name = names.next().unwrap_or_default();
        let Some(still_name) = names.next() else { return Ok(vec![full]) };
        let still: Vec<Vantage> =
            (0..FRAMES).map(|frame| scene.vantages(self.size, frame)[0].clone()).collect();
        let (times, seen) = self.paint(bench, set, &still)?;
        let speedup = full.times.median_ms() / times.median_ms();
        let changing = samples_at(set, 0, |frames| frames == 1);
        let mut still = self.measured(set, changing, times, seen);
        still.name = still_name;
        if let Bound::Scatter(painting) = &mut still.bound {
            painting.speedup_over_full_repaint = Some(speedup);
        }
        Ok(vec![full, still])
    }

    /// Vantages of which no two in a row are the same: what was cached for one serves no other.
    fn moving_vantages(&self, scene: &Scene) -> Vec<Vantage> {
        let frames = if self.what == What::Frames { FRAMES } else { 1 };
        (0..frames).flat_map(|frame| scene.vantages(self.size, frame)).collect()
    }

    /// Times of painting one vantage after the other, over and over.
    fn paint(&self, bench: &Bench<'_>, set: &Arc<SampleSet>, vantages: &[Vantage]) -> Result<(Times, Seen)> {
        let settings = RenderSettings { kernel: self.kernel, ..RenderSettings::default() };
        let mut painter = self.backend.start()?;
        let mut turns = vantages.iter().cycle();
        let mut seen = Seen::default();
        let times = repeat(bench.budget, bench.job, || {
            let Some(vantage) = turns.next() else { return Ok(None) };
            let painted = painter.paint(set, vantage, &settings, bench.job)?;
            seen = Seen { holes: painted.holes, background_reused: painted.background_reused };
            Ok(Some(painted))
        })?;
        Ok((times, seen))
    }

    /// The stage, without its name, of painting `samples` of the set.
    fn measured(&self, set: &SampleSet, samples: u64, times: Times, seen: Seen) -> Measured {
        let (width, height) = self.size;
        let pixels = f64::from(width) * f64::from(height);
        Measured {
            name: String::new(),
            backend: self.backend,
            threads: rayon::current_num_threads(),
            samples,
            times,
            bound: Bound::Scatter(Painting {
                kernel: self.kernel,
                width,
                height,
                coverage: 1.0 - seen.holes as f64 / pixels,
                bytes_per_sample: set.bytes() as f64 / set.sample_count().max(1) as f64,
                background_reused: seen.background_reused,
                fraction_of_same_size_limit: 0.0,
                speedup_over_full_repaint: None,
            }),
        }
    }
}

/// Samples of the images at `frame` whose span has a length that is `wanted`.
fn samples_at(set: &SampleSet, frame: usize, wanted: impl Fn(usize) -> bool) -> u64 {
    let images = set.images_at(frame).filter(|image| wanted(image.span.len()));
    images.map(|image| image.len() as u64).sum()
}
