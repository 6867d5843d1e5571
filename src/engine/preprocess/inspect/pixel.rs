//! The explanation of one pixel: what every camera shows of its surface point, in the numbers that the rules compare.
//!
//! Purpose: a verdict names a rule and a witness; this explains why that rule applies. For each camera: where the point falls,
//! the depth expected and found there, how far apart the two surfaces are in footprints, the angle of incidence, both
//! forms of the sampling rate, and how far colors and normals differ.
//!
//! Source: the verdict comes from the rules of [`crate::preprocess::pruning`] (`decision.rs`) and the single-precision outcomes of
//! [`crate::preprocess::registration`]. What differs: the numbers beside them are for display, in double precision.

use glam::{DVec2, DVec3};

use super::FrameInspection;
use super::explained_sample::ExplainedSample;
use crate::capture::overlap::OverlapGraph;
use crate::preprocess::agreement::VoteTest;
use crate::preprocess::layers::CameraLayer;
use crate::preprocess::pruning::{Candidate, Rule, Verdict, decide};
use crate::preprocess::registration::{Outcome, SameSurface};
use crate::preprocess::temporal::PixelClass;
use crate::samples::{SampleSet, Span, TILE, Vote, VoteCounts};

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
    let tile = (y / TILE, x / TILE);
    samples
        .images
        .iter()
        .filter(|image| image.camera as usize == camera)
        .filter(|image| {
            let found =
                image.tiles.binary_search_by_key(&tile, |t| (usize::from(t.tile_y), usize::from(t.tile_x)));
            found.is_ok_and(|index| image.tiles[index].rows[y % TILE] >> (x % TILE) & 1 == 1)
        })
        .map(|image| image.span)
        .collect()
}

/// What one camera shows of a surface point. Lengths are in the capture's unit; what is not known is NaN.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraEvidence {
    /// Index of the camera.
    pub camera: usize,
    /// Whether it sees the point; `None` for the camera whose own pixel is explained.
    pub outcome: Option<Outcome>,
    /// Its vote on the sample; `None` for the camera whose own pixel is explained.
    pub vote: Option<Vote>,
    /// Where the point falls in its picture, pixels; `None` behind the camera. It may be outside the picture.
    pub position: Option<DVec2>,
    /// The pixel there, `y * width + x`; `None` outside the picture.
    pub pixel: Option<u32>,
    /// Planar z that the point has for this camera; infinite at infinity.
    pub depth_expected: f64,
    /// Planar z that the camera recorded there; infinite at infinity.
    pub depth_found: f64,
    /// Side of the larger of the two pixels on the surface: the footprint that distances are measured in.
    pub footprint: f64,
    /// Distance from the point to the tangent plane found there, in footprints.
    pub plane_distance_footprints: f64,
    /// Angle between the line of sight and the normal found there.
    pub incidence_degrees: f64,
    /// Angle between the point's normal and the one found there.
    pub normal_angle_degrees: f64,
    /// Largest difference of a color channel, 8-bit sRGB steps.
    pub color_difference_steps: f64,
    /// The paper's `r` of the pixel against this camera's: below 1 where the pixel is sampled more densely.
    pub paper_r: f64,
    /// The ratio by footprints, which know focal length and resolution: their longest sides where these decide, else their areas.
    pub footprint_r: f64,
    /// Whether the sample found there is a mixed pixel, so that it yields to clean ones, however dense.
    pub is_mixed: bool,
    /// Whether the normal found there is not known: the sample yields to samples whose normal is.
    pub is_unsure: bool,
    /// What became of the pixel found there; `None` outside the picture.
    pub verdict: Option<Verdict>,
}

impl CameraEvidence {
    /// The row of a camera in which nothing was looked up.
    pub(super) fn not_found(camera: usize) -> Self {
        Self {
            camera,
            outcome: None,
            vote: None,
            position: None,
            pixel: None,
            depth_expected: f64::NAN,
            depth_found: f64::NAN,
            footprint: f64::NAN,
            plane_distance_footprints: f64::NAN,
            incidence_degrees: f64::NAN,
            normal_angle_degrees: f64::NAN,
            color_difference_steps: f64::NAN,
            paper_r: f64::NAN,
            footprint_r: f64::NAN,
            is_mixed: false,
            is_unsure: false,
            verdict: None,
        }
    }
}

/// One step from a sample to its witness.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChainLink {
    /// Index of the camera.
    pub camera: usize,
    /// Its pixel, `y * width + x`.
    pub pixel: u32,
    /// What became of it.
    pub verdict: Verdict,
}

/// Why one pixel was kept or dropped at one frame.
#[derive(Clone, Debug, PartialEq)]
pub struct PixelExplanation {
    /// Index of the camera.
    pub camera: usize,
    /// Column.
    pub x: usize,
    /// Row.
    pub y: usize,
    /// Index of the frame.
    pub frame: usize,
    /// The surface point; `None` at infinity and where there is no depth.
    pub point_in_world: Option<DVec3>,
    /// What the pixel is over time.
    pub class: PixelClass,
    /// The verdict, worked out from what the other cameras show and what was decided there.
    pub verdict: Verdict,
    /// How many other cameras confirm the sample and how many look past it, whether or not the settings let them vote.
    pub votes: VoteCounts,
    /// Whether it is a flying pixel, in the air between foreground and background: then its own camera looks past it, too.
    pub is_flying: bool,
    /// Whether it is kept as a doubtful sample, which is shown where there is nothing else.
    pub is_doubtful: bool,
    /// Index of the camera whose kept sample shows the point; `None` where nothing does.
    pub winner: Option<usize>,
    /// One per camera, in the capture's order; empty where the pixel has no depth.
    pub evidence: Vec<CameraEvidence>,
    /// From the pixel to the sample that represents it. Where the coverage rule kept it, the chain passes the better
    /// sample, which was dropped, to the sample that this one was dropped for.
    pub chain: Vec<ChainLink>,
}

/// What the same-surface test compares for one sample and one other camera that has depth there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairQuantities {
    /// The outcome of the test.
    pub outcome: Outcome,
    /// See [`CameraEvidence::plane_distance_footprints`].
    pub plane_distance_footprints: f32,
    /// See [`CameraEvidence::normal_angle_degrees`]; NaN where either normal is unknown.
    pub normal_angle_degrees: f32,
    /// See [`CameraEvidence::color_difference_steps`].
    pub color_difference_steps: f32,
}
