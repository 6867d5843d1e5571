//! The explanation of one pixel: what every camera shows of its surface point, in the numbers that the rules compare.
//!
//! Purpose: a verdict names a rule and a witness; this says why that rule applies. For each camera: where the point falls,
//! the depth expected and found there, how far apart the two surfaces lie in footprints, the angle of incidence, both
//! forms of the sampling rate, and how far colors and normals differ.
//!
//! Source: the verdict comes from the rules of [`crate::preprocess::pruning`] (`decision.rs`) and the single-precision outcomes of
//! [`crate::preprocess::registration`]. What differs: the numbers beside them are for display, in double precision.

use glam::{DVec2, DVec3, Vec3};

use super::frame::FrameInspection;
use super::pixel_report::{CameraEvidence, ChainLink, PairQuantities, PixelExplanation};
use crate::capture::Camera;
use crate::color::steps_from_linear;
use crate::preprocess::agreement::{VoteCounts, VoteTest};
use crate::preprocess::layers::{CameraLayer, Rate, ViewingRays, footprint, has_unknown_normal, is_mixed};
use crate::preprocess::pruning::{Candidate, Rule, Verdict, decide};
use crate::preprocess::registration::{CameraPairs, Outcome, SameSurface};
use crate::samples::{SampleSet, Span, TILE};

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
    let pairs = CameraPairs::new(&inspection.samples.cameras);
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
        is_doubtful: is_doubtful(inspection, camera, (x, y)),
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
fn is_doubtful(inspection: &FrameInspection, camera: usize, (x, y): (usize, usize)) -> bool {
    let mut images = inspection.samples.images.iter().filter(|image| image.camera as usize == camera);
    images.any(|image| image.is_doubtful(x, y))
}

fn verdict_of(inspection: &FrameInspection, camera: usize, pixel: u32) -> Verdict {
    inspection.cameras[camera].verdict.as_slice()[pixel as usize]
}

fn chain(inspection: &FrameInspection, pairs: &CameraPairs<'_>, camera: usize, pixel: u32) -> Vec<ChainLink> {
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
    pairs: &CameraPairs<'_>,
    camera: usize,
    pixel: u32,
) -> Vec<Candidate> {
    let layer = &inspection.layers[camera];
    let limits = limits_of(inspection, layer, pixel as usize);
    let (x, y) = (pixel as usize % layer.width, pixel as usize / layer.width);
    let shown_by = |other: usize| {
        let target = &inspection.layers[other];
        match limits.test(pairs.registration(camera, other), (layer, x, y), target) {
            Outcome::Same(found) => Some(Candidate::new(target, other, found)),
            _ => None,
        }
    };
    (0..inspection.layers.len()).filter(|&other| other != camera).filter_map(shown_by).collect()
}

/// The best sample of another camera that shows the same point and is better, dropped or not.
fn best_other(
    inspection: &FrameInspection,
    pairs: &CameraPairs<'_>,
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
/// Pairs of which one side has no depth, or lies at infinity, are left out.
#[must_use]
pub fn pair_quantities(inspection: &FrameInspection, at_most: usize) -> Vec<PairQuantities> {
    let cameras = inspection.layers.len();
    let pairs: usize =
        inspection.layers.iter().map(|layer| layer.inverse_depth.len()).sum::<usize>() * cameras;
    let stride = (pairs.div_ceil(at_most.max(1)) as f64).sqrt().ceil().max(1.0) as usize;
    let pairs = CameraPairs::new(&inspection.samples.cameras);
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

/// Column, row and index of the pixel at a position.
fn pixel_of(position: DVec2, layer: &CameraLayer) -> Option<(usize, usize, usize)> {
    let inside = position.x >= 0.0
        && position.y >= 0.0
        && position.x < layer.width as f64
        && position.y < layer.height() as f64;
    inside.then(|| {
        let (x, y) = (position.x as usize, position.y as usize);
        (x, y, y * layer.width + x)
    })
}

/// The sample that is explained.
struct ExplainedSample<'a> {
    inspection: &'a FrameInspection,
    camera: usize,
    x: usize,
    y: usize,
    pixel: usize,
    source: &'a Camera,
    layer: &'a CameraLayer,
    inverse_depth: f64,
    normal: Vec3,
}

/// What a camera has where the point falls.
struct CandidatePixel {
    position: DVec2,
    pixel: Option<(usize, usize, usize)>,
    depth_expected: f64,
}

impl<'a> ExplainedSample<'a> {
    fn new(inspection: &'a FrameInspection, camera: usize, x: usize, y: usize) -> Self {
        let layer = &inspection.layers[camera];
        let pixel = y * layer.width + x;
        Self {
            inspection,
            camera,
            x,
            y,
            pixel,
            source: &inspection.samples.cameras[camera],
            layer,
            inverse_depth: f64::from(layer.inverse_depth[pixel]),
            normal: layer.normal[pixel],
        }
    }

    fn center(&self) -> DVec2 {
        DVec2::new(self.x as f64 + 0.5, self.y as f64 + 0.5)
    }

    fn point_in_world(&self) -> Option<DVec3> {
        (self.inverse_depth > 0.0).then(|| self.source.unproject(self.center(), 1.0 / self.inverse_depth))
    }

    /// Where the point falls in `target`; points at infinity are carried by rotation alone.
    fn find(&self, target: &Camera, layer: &CameraLayer) -> Option<CandidatePixel> {
        let (position, depth_expected) = if let Some(point) = self.point_in_world() {
            target.project(point)?
        } else {
            let direction =
                self.source.world_from_camera.matrix3 * self.source.intrinsics.ray_in_camera(self.center());
            let ray = target.camera_from_world().matrix3 * direction;
            (target.intrinsics.project(ray)?, f64::INFINITY)
        };
        Some(CandidatePixel { position, pixel: pixel_of(position, layer), depth_expected })
    }

    fn quantities(
        &self,
        pairs: &CameraPairs<'_>,
        limits: &SameSurface,
        other: usize,
    ) -> Option<PairQuantities> {
        let target = &self.inspection.samples.cameras[other];
        let layer = &self.inspection.layers[other];
        let found = self.find(target, layer)?;
        let (x, y, pixel) = found.pixel?;
        if layer.inverse_depth[pixel] <= 0.0 {
            return None;
        }
        let (distance, _) = self.plane_distance(target, layer, &found, (x, y, pixel))?;
        Some(PairQuantities {
            outcome: limits.explain(
                pairs.registration(self.camera, other),
                (self.layer, self.x, self.y),
                layer,
            ),
            plane_distance_footprints: distance as f32,
            normal_angle_degrees: angle_degrees(self.normal, layer.normal[pixel]) as f32,
            color_difference_steps: self.color_difference(layer, pixel) as f32,
        })
    }

    fn evidence(&self, pairs: &CameraPairs<'_>, limits: &SameSurface, other: usize) -> CameraEvidence {
        let target = &self.inspection.samples.cameras[other];
        let layer = &self.inspection.layers[other];
        let own = other == self.camera;
        let outcome = (!own).then(|| {
            limits.explain(pairs.registration(self.camera, other), (self.layer, self.x, self.y), layer)
        });
        let mut evidence = CameraEvidence {
            camera: other,
            outcome,
            vote: (!own).then(|| {
                let votes = VoteTest::new(&self.inspection.settings, self.layer.level[self.pixel]);
                votes.vote(pairs, &self.inspection.layers, (self.camera, self.pixel as u32), other)
            }),
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
        };
        let Some(found) = self.find(target, layer) else { return evidence };
        evidence.position = Some(found.position);
        evidence.depth_expected = found.depth_expected;
        // A test in single precision may fall into the pixel beside: what it named counts.
        let pixel = match outcome {
            Some(Outcome::Same(same)) => {
                let same = same as usize;
                Some((same % layer.width, same / layer.width, same))
            }
            _ if own => Some((self.x, self.y, self.pixel)),
            _ => found.pixel,
        };
        let Some((x, y, pixel)) = pixel else { return evidence };
        evidence.pixel = Some(pixel as u32);
        evidence.verdict = Some(self.inspection.cameras[other].verdict[(x, y)]);
        let inverse_depth = layer.inverse_depth[pixel];
        if inverse_depth < 0.0 {
            return evidence;
        }
        evidence.depth_found = 1.0 / f64::from(inverse_depth);
        let rank = layer.ranks[pixel].rank;
        (evidence.is_mixed, evidence.is_unsure) = (is_mixed(rank), has_unknown_normal(rank));
        if let Some((distance, footprint)) = self.plane_distance(target, layer, &found, (x, y, pixel)) {
            evidence.plane_distance_footprints = distance;
            evidence.footprint = footprint;
        }
        evidence.normal_angle_degrees = angle_degrees(self.normal, layer.normal[pixel]);
        evidence.color_difference_steps = self.color_difference(layer, pixel);
        let ray = ViewingRays::new(target).at(x, y);
        evidence.incidence_degrees = angle_degrees(-ray, layer.normal[pixel]);
        let pruning = &self.inspection.settings.pruning;
        let deciding = Rate::resolve(pruning.rate, &self.inspection.samples.cameras);
        [evidence.paper_r, evidence.footprint_r] = [Rate::Paper, deciding.with_focal_length()]
            .map(|rate| self.ratio(rate, target, layer, (x, y, pixel)));
        evidence
    }

    /// Distance to the tangent plane at the pixel found, in footprints, and the footprint; `None` at infinity.
    fn plane_distance(
        &self,
        target: &Camera,
        layer: &CameraLayer,
        found: &CandidatePixel,
        (x, y, pixel): (usize, usize, usize),
    ) -> Option<(f64, f64)> {
        let point = self.point_in_world()?;
        let inverse_depth = f64::from(layer.inverse_depth[pixel]);
        if inverse_depth <= 0.0 {
            return None;
        }
        let depth = 1.0 / inverse_depth;
        let surface = target.unproject(DVec2::new(x as f64 + 0.5, y as f64 + 0.5), depth);
        let normal = layer.normal[pixel].as_dvec3();
        let distance = if normal == DVec3::ZERO {
            (found.depth_expected - depth).abs()
        } else {
            normal.dot(point - surface).abs()
        };
        let side = |camera: &Camera| (camera.intrinsics.fx * camera.intrinsics.fy).sqrt().recip();
        let footprint = (side(self.source) / self.inverse_depth).max(side(target) * depth);
        Some((distance / footprint, footprint))
    }

    fn color_difference(&self, layer: &CameraLayer, pixel: usize) -> f64 {
        let (a, b) = (self.layer.color[self.pixel], layer.color[pixel]);
        (0..3)
            .map(|c| f64::from((steps_from_linear(a[c]) - steps_from_linear(b[c])).abs()))
            .fold(0.0, f64::max)
    }

    fn ratio(
        &self,
        rate: Rate,
        target: &Camera,
        layer: &CameraLayer,
        (x, y, pixel): (usize, usize, usize),
    ) -> f64 {
        let pruning = &self.inspection.settings.pruning;
        let of = |camera: &Camera, layer: &CameraLayer, (x, y, pixel): (usize, usize, usize)| {
            let rays = ViewingRays::new(camera);
            let (inverse_depth, normal) = (layer.inverse_depth[pixel], layer.normal[pixel]);
            f64::from(footprint(rate, &rays, rays.at(x, y), inverse_depth, normal, pruning))
        };
        of(self.source, self.layer, (self.x, self.y, self.pixel)) / of(target, layer, (x, y, pixel))
    }
}

/// The angle between two directions; NaN where either is zero.
fn angle_degrees(a: Vec3, b: Vec3) -> f64 {
    if a == Vec3::ZERO || b == Vec3::ZERO {
        return f64::NAN;
    }
    f64::from(a.angle_between(b)).to_degrees()
}
