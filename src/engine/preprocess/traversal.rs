//! Pruning over all spans of a run of frames.

use rayon::prelude::*;

use super::agreement::Consensus;
use super::diagnostics::{Residuals, RunCounts, Tally};
use super::layers::CameraLayer;
use super::prepared_scan::PreparedScan;
use super::pruning::{self, LevelVerdicts, Masks, PrunedBackground, SpanStack, StackStep};
use super::registration::CameraPairs;
use super::temporal::{ROOT, SpanLevel, SpanTree, all_frames};
use super::views::{Views, prune_views};
use crate::error::Result;
use crate::job::Job;
use crate::samples::{ImageBuffer, Span};
use crate::settings::Settings;

/// Prunes a run of frames, and adds what is kept to `images`. A span that reaches over several runs is decided in each of them, and
/// kept and counted in the one that it begins in.
///
/// # Errors
/// Whatever the capture gives (naming file and frame), `Io` where a temporary file cannot be used, and `Cancelled`.
pub(crate) fn prune_run(
    mut images: ImageBuffer,
    scan: &PreparedScan,
    settings: &Settings,
    run: Span,
    job: &Job,
) -> Result<(ImageBuffer, RunCounts)> {
    let capture = scan.capture();
    if scan.frames == 1 && scan.spans.is_some() && run.contains(0) {
        let errors = scan.normal_errors(&settings.normals, job)?;
        return prune_views(images, Views::new(capture, scan, settings), &errors, job);
    }
    job.start("Pruning the background", 1);
    let background = PrunedBackground::of(capture, scan, settings, job)?;
    let normal_errors = scan.normal_errors(&settings.normals, job)?;
    let mut tally = Tally::new(capture, scan, &normal_errors, settings);
    tally.add_noise_between(&capture.cameras, &background.layers);
    let pairs = CameraPairs::new(&capture.cameras);
    let packing = Packing { pairs: &pairs, settings };
    let mut residuals = Residuals::new(&pairs, scan.frames);
    let all = all_frames(scan.frames);
    if run.contains(0) || scan.frames == 0 {
        tally.add(all, &background.decided);
        packing.pack_all(all, ROOT, &background.layers, &background.decided, &mut images)?;
        residuals.add_lasting(&background.layers, job)?;
    } else {
        tally.pass_over_all_frames();
    }
    let mut stack = SpanStack::new(capture, Some(scan), &pairs, settings, background);
    if let Some(frame) = Residuals::frame_before(scan.frames, run) {
        note_frame(&mut stack, &mut residuals, frame, job)?;
    }
    job.start("Pruning frames", run.len());
    let tree = stack.tree();
    let mut traversal = SpanTraversal { run, tree, stack, tally, residuals, images, packing, job };
    traversal.below(all, ROOT)?;
    let SpanTraversal { tally, residuals, images, .. } = traversal;
    Ok((images, RunCounts { report: tally.into_report(), readings: residuals.into_readings() }))
}

/// Notes the depths of a frame. Its samples are added and removed again without a decision.
fn note_frame(
    stack: &mut SpanStack<'_>,
    residuals: &mut Residuals<'_>,
    frame: usize,
    job: &Job,
) -> Result<()> {
    let mut steps = Vec::new();
    for (span, level) in stack.tree().path(frame).into_iter().zip(0..).skip(1) {
        steps.push(StackStep { pixels: stack.put_span(span, level, job)?, decided: Vec::new() });
    }
    residuals.note(&stack.layers);
    steps.iter().rev().for_each(|step| stack.leave(step));
    Ok(())
}

/// Visits all spans of a run of frames, parents before children, and decides the samples of each.
struct SpanTraversal<'a> {
    run: Span,
    tree: SpanTree,
    stack: SpanStack<'a>,
    tally: Tally,
    residuals: Residuals<'a>,
    images: ImageBuffer,
    packing: Packing<'a>,
    job: &'a Job,
}

impl SpanTraversal<'_> {
    /// Everything that lives in shorter spans within `span`, which is at `level`.
    fn below(&mut self, span: Span, level: SpanLevel) -> Result<()> {
        for child in self.tree.children(span) {
            if child.end <= self.run.start || self.run.end <= child.start {
                continue;
            }
            let step = self.stack.enter(child, level + 1, self.job)?;
            if self.run.contains(child.start as usize) {
                self.tally.add(child, &step.decided);
                let layers = &self.stack.layers;
                self.packing.pack_all(child, level + 1, layers, &step.decided, &mut self.images)?;
            }
            // Of a single frame the paper's two levels are as long as each other.
            if child.len() < span.len() {
                self.below(child, level + 1)?;
            }
            if child.len() == 1 {
                self.residuals.add_moving(child.start as usize, &self.stack.layers, self.job)?;
                self.job.advance(1);
            }
            self.stack.leave(&step);
        }
        Ok(())
    }
}

/// Packs kept samples.
struct Packing<'a> {
    pairs: &'a CameraPairs<'a>,
    settings: &'a Settings,
}

impl Packing<'_> {
    /// Adds the kept samples of every camera over one span, which is at `level`.
    fn pack_all(
        &self,
        span: Span,
        level: SpanLevel,
        layers: &[CameraLayer],
        decided: &[LevelVerdicts],
        images: &mut ImageBuffer,
    ) -> Result<()> {
        let consensus = Consensus::new(self.pairs, layers, level, self.settings);
        let cameras = layers.par_iter().zip(decided).enumerate();
        let packed = cameras.filter_map(|(camera, (layer, decided))| {
            let masks = Masks::decided(layer, decided);
            pruning::pack(camera, span, layer, masks, consensus.as_ref(), self.settings.store.normals)
        });
        packed.collect::<Vec<_>>().into_iter().try_for_each(|image| images.push(image))
    }
}
