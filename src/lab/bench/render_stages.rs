//! Rendering: each kernel over each set and picture size, everything anew; and over a cached background from a still vantage (the
//! paper, §3.3). Holes are not filled.

use std::sync::Arc;

use super::case::{Bench, Case};
use super::measure::repeat;
use super::report::{MeasuredStage, PaintingStage};
use super::scene::{BenchScene, FRAMES, without_filling};
use overlook_engine::error::{Error, Result};
use overlook_engine::render::{Renderer, Vantage};
use overlook_engine::samples::SampleSet;
use overlook_engine::settings::{Antialias, Backend, Kernel, RenderSettings};

/// What is painted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PaintedSet {
    /// Every sample of the unpruned set, anew each time.
    Unpruned,
    /// Every sample of the pruned set, anew each time.
    Pruned,
    /// The split set frame by frame, from a moving and from a still vantage.
    Frames,
}

/// One way to paint one set.
#[derive(Clone, Debug, PartialEq)]
struct PaintCase {
    backend: Backend,
    kernel: Kernel,
    what: PaintedSet,
    /// Columns and rows of the picture.
    size: (u32, u32),
}

/// Every backend with every kernel over the two sets at both sizes, and over the split set at the second.
pub(crate) fn cases(backends: &[Backend], sizes: [(u32, u32); 2]) -> Vec<Case> {
    let mut cases = Vec::new();
    for &backend in backends {
        for &kernel in Kernel::ALL {
            for what in [PaintedSet::Unpruned, PaintedSet::Pruned] {
                cases.extend(sizes.map(|size| PaintCase { backend, kernel, what, size }));
            }
            cases.push(PaintCase { backend, kernel, what: PaintedSet::Frames, size: sizes[1] });
        }
    }
    let case =
        |case: PaintCase| Case { names: case.names(), measure: Box::new(move |bench| case.measure(bench)) };
    cases.into_iter().map(case).collect()
}

/// What one stage paints over and over.
struct Round<'a> {
    name: String,
    set: &'a Arc<SampleSet>,
    vantages: Vec<Vantage>,
    /// Samples that have to be painted each time.
    samples: u64,
}

impl PaintCase {
    /// The stages that come of it.
    fn names(&self) -> Vec<String> {
        let whats: &[&str] = match self.what {
            PaintedSet::Unpruned => &["unpruned"],
            PaintedSet::Pruned => &["pruned"],
            PaintedSet::Frames => &["moving-vantage", "still-vantage"],
        };
        let (width, height) = self.size;
        // The CPU goes without saying.
        let backend = match self.backend {
            Backend::Cpu => String::new(),
            other => format!("{other}/"),
        };
        whats.iter().map(|what| format!("render/{backend}{}/{what}/{width}x{height}", self.kernel)).collect()
    }

    /// Measures with the threads of the current pool.
    fn measure(&self, bench: &Bench<'_>) -> Result<Vec<MeasuredStage>> {
        let rounds = self.rounds(bench.scene);
        let mut stages = rounds.map(|round| self.paint(bench, &round)).collect::<Result<Vec<_>>>()?;
        if let [full, still] = stages.as_mut_slice()
            && let Some(painting) = &mut still.painting
        {
            painting.speedup_over_full_repaint = Some(full.times.median_ms() / still.times.median_ms());
        }
        Ok(stages)
    }

    /// First everything anew: consecutive vantages differ, so that no cache serves the next. Then, for the split set, one vantage
    /// through the frames.
    fn rounds<'a>(&self, scene: &'a BenchScene) -> impl Iterator<Item = Round<'a>> + use<'a> {
        let (set, frames) = match self.what {
            PaintedSet::Unpruned => (&scene.unpruned, 1),
            PaintedSet::Pruned => (&scene.pruned, 1),
            PaintedSet::Frames => (&scene.split, FRAMES),
        };
        let size = self.size;
        let moving = (0..frames).flat_map(|frame| scene.vantages(size, frame)).collect();
        let still = (0..frames).map(|frame| scene.vantages(size, frame)[0].clone()).collect();
        let rounds =
            [(moving, samples_at(set, 0, |_| true)), (still, samples_at(set, 0, |frames| frames == 1))];
        self.names().into_iter().zip(rounds).map(move |(name, (vantages, samples))| Round {
            name,
            set,
            vantages,
            samples,
        })
    }

    /// Paints one vantage after the other.
    fn paint(&self, bench: &Bench<'_>, round: &Round<'_>) -> Result<MeasuredStage> {
        // A stage is what it takes at its own size.
        let defaults = RenderSettings { antialias: Antialias::Off, ..without_filling() };
        let settings = RenderSettings { kernel: self.kernel, backend: self.backend, ..defaults };
        let mut renderer = Renderer::strict(self.backend)?;
        let mut turns = round.vantages.iter().cycle();
        let (mut holes, mut background_reused) = (0, false);
        let times = repeat(bench.budget, bench.job, || {
            let Some(vantage) = turns.next() else { return Ok(None) };
            let (picture, stats) = renderer.render(round.set, vantage, &settings, bench.job)?;
            if let Some(what) = renderer.notice() {
                return Err(Error::Gpu { what: what.to_owned() });
            }
            (holes, background_reused) = (stats.holes, stats.background_reused);
            // Giving its memory back is not measured.
            Ok(Some(picture))
        })?;
        let (width, height) = self.size;
        let pixels = f64::from(width) * f64::from(height);
        Ok(MeasuredStage {
            name: round.name.clone(),
            backend: self.backend,
            samples: round.samples,
            times,
            cpu_ms: None,
            bytes: None,
            painting: Some(PaintingStage {
                kernel: self.kernel,
                width,
                height,
                coverage: 1.0 - holes as f64 / pixels,
                bytes_per_sample: round.set.bytes() as f64 / round.set.sample_count().max(1) as f64,
                background_reused,
                speedup_over_full_repaint: None,
                stages: None,
            }),
        })
    }
}

/// Samples of the images at `frame` whose span has a length that is `wanted`.
fn samples_at(set: &SampleSet, frame: usize, wanted: impl Fn(usize) -> bool) -> u64 {
    let images = set.images_at(frame).filter(|image| wanted(image.span.len()));
    images.map(|image| image.len() as u64).sum()
}
