//! The explanation of one pixel: what every camera shows of its surface point, in the numbers that the rules compare.
//!
//! Purpose: a verdict names a rule and a witness; this explains why that rule applies. For each camera: where the point falls,
//! the depth expected and found there, how far apart the two surfaces are in footprints, the angle of incidence, both
//! forms of the sampling rate, and how far colors and normals differ.
//!
//! Source: the verdict comes from the rules of [`crate::preprocess::pruning`] (`decision.rs`) and the single-precision outcomes of
//! [`crate::preprocess::registration`]. What differs: the numbers beside them are for display, in double precision.

use super::explained_sample::ExplainedSample;
use super::frame::FrameInspection;
use super::pixel_report::{ChainLink, PairQuantities, PixelExplanation};
use crate::capture::overlap::OverlapGraph;
use crate::preprocess::agreement::VoteTest;
use crate::preprocess::layers::CameraLayer;
use crate::preprocess::pruning::{Candidate, Rule, Verdict, decide};
use crate::preprocess::registration::{Outcome, SameSurface};
use crate::samples::{SampleSet, Span, VoteCounts};

/// The explanation of pixel `(x, y)` of camera `camera`; `None` where there is no such pixel.
#[must_use]
pub fn explain_pixel(
    inspection: &FrameInspection,
    camera: usize,
    x: usize,
    y: usize,
) -> Option<PixelExplanation> {
    let layer = inspection.layers.get(camera)?;
    if x >= layer.width || y >= layer.height() {
        return None;
    }
    let pixel = (y * layer.width + x) as u32;
    let pairs = OverlapGraph::complete(&inspection.samples.cameras);
    let shown = samples_of_point(inspection, &pairs, camera, pixel);
    let is_kept = |other: &Candidate| verdict_of(inspection, other.camera.into(), other.pixel).is_kept();
    let others: Vec<(Candidate, bool)> = shown.iter().map(|other| (*other, is_kept(other))).collect();
    let votes = VoteTest::new(&inspection.settings, layer.level[pixel as usize]);
    let is_contradicted = votes.contradicts(&pairs, &inspection.layers, camera, pixel);
    let own = Candidate::new(layer, camera, pixel);
    let verdict = decide(&own, &others, is_contradicted, &inspection.settings.pruning);
    let mut explanation = PixelExplanation {
        camera,
        x,
        y,
        frame: inspection.frame,
        point_in_world: None,
        class: inspection.cameras[camera].class[(x, y)],
        verdict,
        winner: None,
        votes: VoteCounts::default(),
        is_flying: layer.packed_colors[pixel as usize].is_flying(),
        is_doubtful: is_doubtful(inspection, camera, x, y),
        evidence: Vec::new(),
        chain: Vec::new(),
    };
    if layer.inverse_depth[pixel as usize] < 0.0 {
        return Some(explanation);
    }
    let sample = ExplainedSample::new(inspection, camera, x, y);
    explanation.point_in_world = sample.point_in_world();
    explanation.votes = votes.counts(&pairs, &inspection.layers, camera, pixel);
    let limits = limits_of(inspection, layer, pixel as usize);
    explanation.evidence =
        (0..inspection.layers.len()).map(|other| sample.evidence(&pairs, &limits, other)).collect();
    explanation.winner = if verdict.is_kept() {
        Some(camera)
    } else {
        (verdict.witness_camera != Verdict::NO_CAMERA).then_some(verdict.witness_camera as usize)
    };
    explanation.chain = chain(inspection, &pairs, camera, pixel);
    Some(explanation)
}

/// The same-surface test of a sample, with others of its level and of longer spans.
fn limits_of(inspection: &FrameInspection, layer: &CameraLayer, pixel: usize) -> SameSurface {
    SameSurface::new(&inspection.settings).at_level(layer.level[pixel])
}

/// Whether the sample of a camera at a pixel was kept as a doubtful one.
fn is_doubtful(inspection: &FrameInspection, camera: usize, x: usize, y: usize) -> bool {
    let mut images = inspection.samples.images.iter().filter(|image| image.camera as usize == camera);
    images.any(|image| image.is_doubtful(x, y))
}

fn verdict_of(inspection: &FrameInspection, camera: usize, pixel: u32) -> Verdict {
    inspection.cameras[camera].verdict.as_slice()[pixel as usize]
}

fn chain(
    inspection: &FrameInspection,
    pairs: &OverlapGraph<'_>,
    camera: usize,
    pixel: u32,
) -> Vec<ChainLink> {
    let mut chain: Vec<ChainLink> = Vec::new();
    let mut next = Some((camera, pixel));
    while let Some((camera, pixel)) = next {
        let verdict = verdict_of(inspection, camera, pixel);
        chain.push(ChainLink { camera, pixel, verdict });
        next = if verdict.rule == Rule::Coverage {
            best_other(inspection, pairs, camera, pixel)
        } else {
            (!verdict.is_kept() && verdict.witness_camera != Verdict::NO_CAMERA)
                .then_some((verdict.witness_camera as usize, verdict.witness_pixel))
        };
        // Ranks fall along the chain, so that it ends; the bound is for verdicts that something else made.
        next = next.filter(|_| chain.len() <= inspection.layers.len());
    }
    chain
}

/// The samples of other cameras that show the same surface point as one of `camera`, as far as its level sees them.
fn samples_of_point(
    inspection: &FrameInspection,
    pairs: &OverlapGraph<'_>,
    camera: usize,
    pixel: u32,
) -> Vec<Candidate> {
    let layer = &inspection.layers[camera];
    let limits = limits_of(inspection, layer, pixel as usize);
    let (x, y) = (pixel as usize % layer.width, pixel as usize / layer.width);
    let shown_by = |other: usize| {
        let target = &inspection.layers[other];
        match limits.test(pairs.registration(camera, other), layer, x, y, target) {
            Outcome::Same(found) => Some(Candidate::new(target, other, found)),
            _ => None,
        }
    };
    (0..inspection.layers.len()).filter(|&other| other != camera).filter_map(shown_by).collect()
}

/// The best sample of another camera that shows the same point and is better, dropped or not.
fn best_other(
    inspection: &FrameInspection,
    pairs: &OverlapGraph<'_>,
    camera: usize,
    pixel: u32,
) -> Option<(usize, u32)> {
    let own = Candidate::new(&inspection.layers[camera], camera, pixel);
    let across_spans = inspection.settings.pruning.across_spans;
    let counts = |other: &Candidate| other.is_better_than(&own) && (across_spans || other.level == own.level);
    let best = samples_of_point(inspection, pairs, camera, pixel).into_iter().filter(counts).min();
    best.map(|best| (usize::from(best.camera), best.pixel))
}

/// What the same-surface test compares, for at most `at_most` pairs spread evenly over all pixels of all cameras.
/// Pairs are left out if either side has no depth or is at infinity.
#[must_use]
pub fn pair_quantities(inspection: &FrameInspection, at_most: usize) -> Vec<PairQuantities> {
    let cameras = inspection.layers.len();
    let pairs: usize =
        inspection.layers.iter().map(|layer| layer.inverse_depth.len()).sum::<usize>() * cameras;
    let stride = (pairs.div_ceil(at_most.max(1)) as f64).sqrt().ceil().max(1.0) as usize;
    let pairs = OverlapGraph::complete(&inspection.samples.cameras);
    let mut quantities = Vec::new();
    for (camera, layer) in inspection.layers.iter().enumerate() {
        for y in (stride / 2..layer.height()).step_by(stride) {
            for x in (stride / 2..layer.width).step_by(stride) {
                if layer.inverse_depth[y * layer.width + x] <= 0.0 {
                    continue;
                }
                let limits = limits_of(inspection, layer, y * layer.width + x);
                let sample = ExplainedSample::new(inspection, camera, x, y);
                quantities.extend(
                    (0..cameras)
                        .filter(|&other| other != camera)
                        .filter_map(|other| sample.quantities(&pairs, &limits, other)),
                );
            }
        }
    }
    quantities
}

/// The spans in which pixel `(x, y)` of camera `camera` is stored, longest first.
#[must_use]
pub fn spans_of_pixel(samples: &SampleSet, camera: usize, x: usize, y: usize) -> Vec<Span> {
    samples
        .images
        .iter()
        .filter(|image| image.camera as usize == camera && image.sample_at(x, y).is_some())
        .map(|image| image.span)
        .collect()
}
