//! Pruning over all spans of a run of frames, in memory that does not grow with the number of cameras.
//!
//! ```text
//! what each camera saw ─▶ noise between cameras
//!     ─▶ all frames, then ever shorter spans, parents before children; for each:
//!            put its samples ─▶ for each group of cameras, within the memory setting: best candidates
//!                            ─▶ coverage (until nothing waits) ─▶ pack
//! ```
//!
//! Purpose: all cameras are compared with each other, and as layers a hundred pictures take gigabytes. Where all fit, there is one group
//! of all cameras. Where not, layers are put together when they are needed, from the samples of each span, and given up where they take
//! too much memory; samples and verdicts wait in temporary files. Where a camera walked, a group is neighbors and all that may see
//! their samples; where all cameras see the same, layers are held part by part ([`groups`]). One byte a pixel of every
//! camera is held throughout: whether its sample is kept.
//!
//! What is decided does not depend on the groups, nor on what is held: "better" is a total order of all samples ([`super::pruning`]).

mod groups;
mod settle;
mod steps;
mod verdict_store;
mod window;

use std::sync::Arc;

use rayon::prelude::*;

use super::agreement::{NoiseLattice, where_most_are_noisy};
use super::diagnostics::{DepthReading, LatticeRuns, Misfits, Residuals, RunCounts, Tally};
use super::noise::NoiseBetween;
use super::normals::NormalErrors;
use super::prepared_scan::PreparedScan;
use super::pruning::mark_undecided;
use super::temporal::{ROOT, SpanLevel, SpanTree, all_frames};
use crate::capture::overlap::{DepthBounds, OverlapGraph};
use crate::error::Result;
use crate::job::Job;
use crate::samples::Span;
use crate::settings::{AgreementRule, Settings};
use groups::{CameraGroup, Recording};
pub(crate) use steps::KeptSamples;
use steps::{Pruner, PutSpan};
use window::LayerWindow;

/// The largest share of its depth by which averaging noisy cameras moves a sample. Other views take part within 3 √2 standard
/// deviations of the sample; smoothing moves it by at most 3 of them, and at most by half its depth (see [`super::agreement`]).
fn moved_at_most(noise: f32) -> f32 {
    let smoothed = (3.0 * noise).min(0.5);
    (3.0 * std::f32::consts::SQRT_2 * noise).max(smoothed / (1.0 - smoothed))
}

/// Prunes a run of frames, and adds what is kept to `kept`. A span that reaches over several runs is decided in each of them, and
/// kept and counted in the one that it begins in.
///
/// # Errors
/// Whatever the capture gives (naming file and frame), `Io` where a temporary file cannot be used, and `Cancelled`.
pub(crate) fn prune_run(
    kept: KeptSamples,
    scan: &PreparedScan,
    settings: &Settings,
    run: Span,
    job: &Job,
) -> Result<(KeptSamples, RunCounts)> {
    let errors = scan.normal_errors(&settings.normals, job)?;
    prune_recording(kept, Recording::new(scan.capture(), scan, settings), &errors, run, job)
}

fn prune_recording(
    mut kept: KeptSamples,
    recording: Recording<'_>,
    normal_errors: &[Vec<NormalErrors>],
    run: Span,
    job: &Job,
) -> Result<(KeptSamples, RunCounts)> {
    let Recording { capture, scan, settings, .. } = recording;
    let count = capture.cameras.len();
    let what = if recording.is_of_one_moment() { "Pruning views" } else { "Pruning the background" };
    job.start(what, 2 * count);
    // Cameras that move see other things at other moments.
    let bounds = recording.is_of_one_moment().then(|| recording.depth_bounds(job)).transpose()?;
    let pairs = match &bounds {
        Some(bounds) => OverlapGraph::of_depths(&capture.cameras, bounds),
        None => OverlapGraph::complete(&capture.cameras),
    };
    let mut window = LayerWindow::new(recording, &pairs);
    if !window.holds_all {
        // What the frames hold is in the scan, and memory is short.
        capture.forget_frames();
    }
    let statuses = recording.no_statuses();
    let is_known = settings.pruning.agreement == AgreementRule::Off || capture.is_noise_free();
    let measured = if is_known { 0 } else { count };
    let root = all_frames(scan.frames);
    let looked = window.enter(
        root,
        ROOT,
        |camera, layer, samples| {
            mark_undecided(samples, &statuses[camera], settings.pruning.mixed_pixels);
            (NoiseLattice::of(layer, measured), LatticeRuns::lasting(layer, count))
        },
        job,
    )?;
    let (looked, counts): (Vec<_>, Vec<_>) = looked.into_iter().unzip();
    let (noise, lattice): (Vec<_>, Vec<_>) = looked.into_iter().unzip();
    let mut tally = Tally::new(capture, scan, normal_errors, settings);
    let mut pruner = Pruner { recording, pairs: &pairs, window, statuses, job };
    if measured > 0 {
        let groups = pruner.groups(&vec![0; count]);
        let noise = noise_between(&pairs, &mut pruner.window, &groups, noise, job)?;
        pruner.window.set_noise(noise);
    }
    let noise = pruner.window.most_noise();
    // Samples that are moved may be seen by other cameras than before.
    let moved = 1.01 * moved_at_most(noise);
    let of_moved = (noise > 0.0).then(|| match &bounds {
        Some(bounds) if moved < 1.0 => {
            let blurred: Vec<DepthBounds> = bounds.iter().map(|bounds| bounds.blurred(moved)).collect();
            OverlapGraph::of_depths(&capture.cameras, &blurred)
        }
        _ => OverlapGraph::complete(&capture.cameras),
    });
    let pairs = of_moved.as_ref().unwrap_or(&pairs);
    pruner.pairs = pairs;
    let is_root_counted = run.contains(0) || scan.frames == 0;
    if noise > 0.0 && is_root_counted {
        tally.add_reading(better_reading(pairs, &mut pruner.window, job)?);
    }
    let mut residuals = Residuals::new(pairs, scan.frames);
    let mut put = PutSpan { span: root, level: ROOT, counts, lattice: None };
    if is_root_counted {
        residuals.note_asked(&lattice);
        put.lattice = Some(lattice);
    }
    pruner.prune(&put, &mut residuals, is_root_counted.then_some((&mut tally, &mut kept)))?;
    pruner.window.forget_samples();
    let tree = scan.tree(&settings.spans);
    let mut traversal = SpanTraversal { run, tree, pruner, tally, residuals, kept };
    if !recording.is_of_one_moment() {
        if let Some(frame) = Residuals::frame_before(scan.frames, run) {
            traversal.note_frame(frame)?;
        }
        job.start("Pruning frames", run.len());
        traversal.below(root, ROOT)?;
    }
    let SpanTraversal { tally, residuals, mut kept, .. } = traversal;
    kept.sort();
    Ok((kept, RunCounts { report: tally.into_report(), readings: residuals.into_readings() }))
}

/// Visits all spans of a run of frames, parents before children, and decides the samples of each.
struct SpanTraversal<'a> {
    run: Span,
    tree: SpanTree,
    pruner: Pruner<'a>,
    tally: Tally,
    residuals: Residuals<'a>,
    kept: KeptSamples,
}

impl SpanTraversal<'_> {
    /// Notes the depths of a frame. Its samples are put and taken away again without a decision.
    fn note_frame(&mut self, frame: usize) -> Result<()> {
        let path = self.tree.path(frame);
        let Pruner { window, statuses, job, .. } = &mut self.pruner;
        let residuals = &self.residuals;
        let mut looked = Vec::new();
        for (&span, level) in path.iter().zip(0..).skip(1) {
            let look = |camera: usize, layer: &_, _: &_| residuals.moving(camera, layer);
            looked = window.enter(span, level, look, job)?;
        }
        self.residuals.note(looked.into_iter().map(|(looked, _)| looked).collect());
        path.iter().skip(1).try_for_each(|_| window.leave(statuses))
    }

    /// Everything that lives in shorter spans within `span`, which is at `level`.
    fn below(&mut self, span: Span, level: SpanLevel) -> Result<()> {
        for child in self.tree.children(span) {
            if child.end <= self.run.start || self.run.end <= child.start {
                continue;
            }
            let put = self.put(child, level + 1)?;
            let is_kept = self.run.contains(child.start as usize);
            let kept = is_kept.then_some((&mut self.tally, &mut self.kept));
            self.pruner.prune(&put, &mut self.residuals, kept)?;
            // With a single frame the paper's two levels are equally long.
            if child.len() < span.len() {
                self.below(child, level + 1)?;
            }
            let Pruner { window, statuses, job, .. } = &mut self.pruner;
            if child.len() == 1 {
                job.advance(1);
            }
            window.leave(statuses)?;
        }
        Ok(())
    }

    /// Puts the samples of a span, which is at `level` below the one that was entered last.
    fn put(&mut self, span: Span, level: SpanLevel) -> Result<PutSpan> {
        let Pruner { window, statuses, recording, job, .. } = &mut self.pruner;
        let (statuses, residuals) = (&*statuses, &self.residuals);
        let mixed_pixels = recording.settings.pruning.mixed_pixels;
        let is_looked_at = span.len() == 1 && residuals.looks_at(span.start as usize);
        let looked = window.enter(
            span,
            level,
            |camera, layer, samples| {
                mark_undecided(samples, &statuses[camera], mixed_pixels);
                is_looked_at.then(|| residuals.moving(camera, layer))
            },
            job,
        )?;
        let (looked, counts): (Vec<_>, Vec<_>) = looked.into_iter().unzip();
        let looked: Option<Vec<_>> = looked.into_iter().collect();
        let lattice = looked.filter(|_| is_looked_at).map(|looked| self.residuals.note(looked));
        Ok(PutSpan { span, level, counts, lattice })
    }
}

/// At most this many cameras are compared to find out whether depth was misread, spread over all.
const LOOKED_AT: usize = 32;
/// Each is compared with at most this many that see it.
const LOOKED_AT_BESIDE: usize = 16;

/// The noise of every camera as the others see it, from some samples of each.
fn noise_between(
    pairs: &OverlapGraph<'_>,
    window: &mut LayerWindow<'_>,
    groups: &[CameraGroup],
    mut lattices: Vec<NoiseLattice>,
    job: &Job,
) -> Result<Vec<Option<Arc<NoiseBetween>>>> {
    for group in groups {
        let mut is_worked_on = vec![false; lattices.len()];
        group.cameras.iter().for_each(|camera| is_worked_on[*camera] = true);
        for part in &group.parts {
            window.hold(part, job)?;
            let layers = &window.layers;
            let lattices = lattices.par_iter_mut().enumerate().filter(|(camera, _)| is_worked_on[*camera]);
            lattices.for_each(|(camera, lattice)| lattice.compare(pairs, camera, layers, part));
        }
    }
    Ok(where_most_are_noisy(lattices.into_par_iter().map(NoiseLattice::noise).collect()))
}

/// Whether depth would fit better if it were read otherwise.
fn better_reading(
    pairs: &OverlapGraph<'_>,
    window: &mut LayerWindow<'_>,
    job: &Job,
) -> Result<Option<DepthReading>> {
    let cameras = pairs.cameras();
    let mut misfits = Misfits::new();
    for nth in 0..cameras.len().min(LOOKED_AT) {
        let source = nth * cameras.len() / cameras.len().min(LOOKED_AT);
        let targets: Vec<usize> = if cameras.len() <= LOOKED_AT {
            (0..cameras.len()).filter(|target| *target != source).collect()
        } else {
            let others = pairs.others(source);
            let step = others.len().div_ceil(LOOKED_AT_BESIDE).max(1);
            others.map(|(target, _)| target).step_by(step).collect()
        };
        let held: Vec<usize> = targets.iter().copied().chain([source]).collect();
        window.hold(&held, job)?;
        misfits.add(cameras, &window.layers, source, &targets);
    }
    Ok(misfits.better())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::{Capture, CaptureParts, Frame, FrameSource};
    use crate::demo::{Demo, DemoSpec};
    use crate::preprocess::{PreparedScan, inspect_frame};
    use crate::samples::SampleImage;
    use crate::settings::{AlignSettings, CaptureSettings, MixedPixels, SpanLevels};

    /// Views of each place where a demo stands.
    const AT_ONE_PLACE: usize = 6;

    /// A demo that stands at several places. Its depth is off by some share of it, at each pixel by another.
    struct Noisy(Demo, f32);

    impl FrameSource for Noisy {
        fn load(&self, camera: usize, frame: usize) -> Result<Frame> {
            let mut loaded = self.0.load(camera % AT_ONE_PLACE, frame)?;
            for (pixel, inverse_depth) in loaded.inverse_depth.as_mut_slice().iter_mut().enumerate() {
                let draw = crate::random::mix((camera * 1_000_003 + pixel) as u64) >> 40;
                *inverse_depth *= 1.0 + self.1 * (draw as f32 / (1 << 23) as f32 - 1.0);
            }
            Ok(loaded)
        }

        fn place(&self, camera: usize, frame: usize) -> String {
            self.0.place(camera % AT_ONE_PLACE, frame)
        }
    }

    fn capture(scene: &str, noise: f32) -> Capture {
        let demo = Demo::new(&DemoSpec::new(scene).cameras(AT_ONE_PLACE).frames(1).size((80, 60))).unwrap();
        let capture = demo.capture(&CaptureSettings::default());
        // The first two places are near enough for some views of one to look at the other.
        let places =
            [0.0, 12.0, 1000.0].map(|meters| glam::DAffine3::from_translation(glam::DVec3::X * meters));
        let at = |place: &glam::DAffine3, camera: &crate::capture::Camera| crate::capture::Camera {
            world_from_camera: *place * camera.world_from_camera,
            ..camera.clone()
        };
        let cameras =
            places.iter().flat_map(|place| capture.cameras.iter().map(move |camera| at(place, camera)));
        let cameras = cameras.collect();
        let parts = CaptureParts { cameras, source: Arc::new(Noisy(demo, noise)), ..(*capture).clone() };
        Capture::new(parts, 1 << 20)
    }

    #[test]
    fn views_are_pruned_alike_however_few_are_held_at_a_time_and_as_all_at_once() {
        let job = Job::new();
        let mut settings = Settings { align: AlignSettings::OFF, ..Settings::default() };
        for (scene, noise, mixed) in [
            ("orrery", 0.0, MixedPixels::Drop),
            ("nine-cameras", 0.0, MixedPixels::Yield),
            ("nine-cameras", 0.03, MixedPixels::Yield),
        ] {
            settings.pruning.mixed_pixels = mixed;
            let capture = capture(scene, noise);
            let scan: Arc<PreparedScan> = crate::preprocess::scan(&capture, &settings, &job).unwrap();
            let (layer, count) = (80 * 60 * 43, capture.cameras.len());
            let bounds = Recording::new(&capture, &scan, &settings).depth_bounds(&job).unwrap();
            let others: Vec<usize> = OverlapGraph::of_depths(&capture.cameras, &bounds)
                .others(0)
                .map(|(other, _)| other)
                .collect();
            let of_place =
                |place: usize| others.iter().filter(|other| **other / AT_ONE_PLACE == place).count();
            assert!(
                of_place(1) > 0 && others.len() < count - 1,
                "some views of two places overlap: {others:?}"
            );
            let of_bound = |bound: usize| {
                let recording = Recording { bound, ..Recording::new(&capture, &scan, &settings) };
                let (images, run) = (KeptSamples::in_memory(), all_frames(1));
                let errors = vec![Vec::new(); count];
                let (images, counts) = prune_recording(images, recording, &errors, run, &job).unwrap();
                let report = counts.finish(count, images.images.facts());
                (images.images.into_images().unwrap(), report)
            };
            let (images, report) = of_bound(usize::MAX);
            assert_eq!(report.is_noisy(), noise > 0.0, "{scene}");
            for layers in [0, 2, 5, 13] {
                let (few, of_few) = of_bound(layers * layer);
                assert!(few == images && of_few == report, "{scene}, {layers} layers");
            }
            let inspection = inspect_frame(&capture, Some(&scan), &settings, 0, &job).unwrap();
            let all_at_once: Vec<&SampleImage> =
                inspection.samples.images.iter().map(|image| &**image).collect();
            assert_eq!(images.iter().map(|image| &**image).collect::<Vec<_>>(), all_at_once, "{scene}");
        }
    }

    #[test]
    fn a_moving_scene_is_pruned_alike_however_few_layers_are_held_at_a_time() {
        let job = Job::new();
        let plain = Settings { align: AlignSettings::OFF, ..Settings::default() };
        let mut drops = plain.clone();
        drops.pruning.mixed_pixels = MixedPixels::Drop;
        drops.pruning.across_spans = false;
        drops.store.normals = true;
        let mut paper = plain.clone();
        paper.spans.levels = SpanLevels::Paper;
        let cases = [
            ("orrery", 0.0, &plain),
            ("orrery", 0.0, &drops),
            ("nine-cameras", 0.0, &paper),
            ("nine-cameras", 0.03, &plain),
            ("nine-cameras", 0.03, &drops),
        ];
        for (scene, noise, settings) in cases {
            let spec = DemoSpec::new(scene).cameras(AT_ONE_PLACE).frames(3).size((64, 48));
            let demo = Demo::new(&spec).unwrap();
            let source = demo.capture(&CaptureSettings::default());
            let parts = CaptureParts { source: Arc::new(Noisy(demo, noise)), ..(*source).clone() };
            let capture = Capture::new(parts, 1 << 20);
            let scan: Arc<PreparedScan> = crate::preprocess::scan(&capture, settings, &job).unwrap();
            let errors = vec![Vec::new(); AT_ONE_PLACE];
            let of = |bound: usize, run: Span| {
                let recording = Recording { bound, ..Recording::new(&capture, &scan, settings) };
                let images = KeptSamples::in_memory();
                let (images, counts) = prune_recording(images, recording, &errors, run, &job).unwrap();
                (images.images.into_images().unwrap(), counts)
            };
            for run in [all_frames(3), Span { start: 1, end: 3 }] {
                let (images, counts) = of(usize::MAX, run);
                assert!(!images.is_empty(), "{scene}");
                for bound in [0, 4 * 64 * 48 * 43] {
                    let (few, of_few) = of(bound, run);
                    assert!(
                        few == images && of_few == counts,
                        "{scene}, noise {noise}, {bound} bytes, {run:?}"
                    );
                }
            }
        }
    }
}
