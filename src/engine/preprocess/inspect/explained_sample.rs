//! What one camera shows of the explained sample, in numbers.

use glam::{DVec2, DVec3, Vec3};

use super::frame::FrameInspection;
use super::pixel_report::{CameraEvidence, PairQuantities};
use crate::capture::Camera;
use crate::capture::overlap::OverlapGraph;
use crate::color::steps_from_linear;
use crate::preprocess::agreement::VoteTest;
use crate::preprocess::layers::{CameraLayer, Rate, ViewingRays, footprint, has_unknown_normal, is_mixed};
use crate::preprocess::registration::{Outcome, SameSurface};
use crate::samples::Vote;

/// A pixel of a layer.
#[derive(Clone, Copy)]
struct Pixel {
    x: usize,
    y: usize,
    /// `y * width + x`.
    index: usize,
}

impl Pixel {
    fn of_index(index: usize, layer: &CameraLayer) -> Self {
        Self { x: index % layer.width, y: index / layer.width, index }
    }
}

/// The pixel at a position; `None` outside the picture.
fn pixel_at(position: DVec2, layer: &CameraLayer) -> Option<Pixel> {
    let inside = position.x >= 0.0
        && position.y >= 0.0
        && position.x < layer.width as f64
        && position.y < layer.height() as f64;
    inside.then(|| {
        let (x, y) = (position.x as usize, position.y as usize);
        Pixel { x, y, index: y * layer.width + x }
    })
}

/// The sample that is explained.
pub(super) struct ExplainedSample<'a> {
    inspection: &'a FrameInspection,
    camera: usize,
    pixel: Pixel,
    source: &'a Camera,
    layer: &'a CameraLayer,
    inverse_depth: f64,
    normal: Vec3,
}

/// What a camera has where the point falls.
struct CandidatePixel {
    position: DVec2,
    pixel: Option<Pixel>,
    depth_expected: f64,
}

impl<'a> ExplainedSample<'a> {
    pub(super) fn new(inspection: &'a FrameInspection, camera: usize, x: usize, y: usize) -> Self {
        let layer = &inspection.layers[camera];
        let pixel = Pixel { x, y, index: y * layer.width + x };
        Self {
            inspection,
            camera,
            pixel,
            source: &inspection.samples.cameras[camera],
            layer,
            inverse_depth: f64::from(layer.inverse_depth[pixel.index]),
            normal: layer.normal[pixel.index],
        }
    }

    fn center(&self) -> DVec2 {
        DVec2::new(self.pixel.x as f64 + 0.5, self.pixel.y as f64 + 0.5)
    }

    pub(super) fn point_in_world(&self) -> Option<DVec3> {
        (self.inverse_depth > 0.0).then(|| self.source.unproject(self.center(), 1.0 / self.inverse_depth))
    }

    /// Where the point falls in `target`; points at infinity are carried by rotation alone.
    fn find(&self, target: &Camera, layer: &CameraLayer) -> Option<CandidatePixel> {
        let (position, depth_expected) = if let Some(point) = self.point_in_world() {
            target.project(point)?
        } else if target.intrinsics.is_orthographic() {
            // It sees one direction at infinity, wherever a pixel lies.
            return None;
        } else {
            let direction =
                self.source.world_from_camera.matrix3 * self.source.intrinsics.ray_in_camera(self.center());
            let ray = target.camera_from_world().matrix3 * direction;
            (target.intrinsics.project(ray)?, f64::INFINITY)
        };
        Some(CandidatePixel { position, pixel: pixel_at(position, layer), depth_expected })
    }

    pub(super) fn quantities(
        &self,
        pairs: &OverlapGraph<'_>,
        limits: &SameSurface,
        other: usize,
    ) -> Option<PairQuantities> {
        let target = &self.inspection.samples.cameras[other];
        let layer = &self.inspection.layers[other];
        let found = self.find(target, layer)?;
        let pixel = found.pixel?;
        if layer.inverse_depth[pixel.index] <= 0.0 {
            return None;
        }
        self.plane_distance(target, layer, found.depth_expected, pixel)?;
        let registration = pairs.registration(self.camera, other);
        let (x, y) = (self.pixel.x, self.pixel.y);
        let needed = limits.depth_tolerance_needed(registration, self.layer, x, y, layer);
        Some(PairQuantities {
            outcome: self.outcome(pairs, limits, other),
            depth_tolerance_needed: needed,
            normal_angle_degrees: angle_degrees(self.normal, layer.normal[pixel.index]) as f32,
            color_difference_steps: self.color_difference(layer, pixel.index) as f32,
        })
    }

    fn outcome(&self, pairs: &OverlapGraph<'_>, limits: &SameSurface, other: usize) -> Outcome {
        let registration = pairs.registration(self.camera, other);
        limits.explain(registration, self.layer, self.pixel.x, self.pixel.y, &self.inspection.layers[other])
    }

    fn vote(&self, pairs: &OverlapGraph<'_>, other: usize) -> Vote {
        let votes = VoteTest::new(&self.inspection.settings, self.layer.level[self.pixel.index]);
        let (camera, pixel) = (self.camera, self.pixel.index as u32);
        votes.vote(pairs.registration(camera, other), &self.inspection.layers, camera, pixel, other)
    }

    pub(super) fn evidence(
        &self,
        pairs: &OverlapGraph<'_>,
        limits: &SameSurface,
        other: usize,
    ) -> CameraEvidence {
        let target = &self.inspection.samples.cameras[other];
        let layer = &self.inspection.layers[other];
        let is_own = other == self.camera;
        let mut evidence = CameraEvidence::not_found(other);
        if !is_own {
            evidence.outcome = Some(self.outcome(pairs, limits, other));
            evidence.vote = Some(self.vote(pairs, other));
        }
        let Some(found) = self.find(target, layer) else { return evidence };
        evidence.position = Some(found.position);
        evidence.depth_expected = found.depth_expected;
        // A test in single precision may fall into the pixel beside: what it named counts.
        let pixel = match evidence.outcome {
            Some(Outcome::Same(same)) => Some(Pixel::of_index(same as usize, layer)),
            _ if is_own => Some(self.pixel),
            _ => found.pixel,
        };
        let Some(pixel) = pixel else { return evidence };
        evidence.pixel = Some(pixel.index as u32);
        evidence.verdict = Some(self.inspection.cameras[other].verdict[(pixel.x, pixel.y)]);
        if layer.inverse_depth[pixel.index] < 0.0 {
            return evidence;
        }
        self.compare(&mut evidence, target, layer, pixel);
        evidence
    }

    /// Adds how the sample found at a pixel of `layer` compares.
    fn compare(&self, evidence: &mut CameraEvidence, target: &Camera, layer: &CameraLayer, pixel: Pixel) {
        evidence.depth_found = 1.0 / f64::from(layer.inverse_depth[pixel.index]);
        let rank = layer.ranks[pixel.index];
        (evidence.is_mixed, evidence.is_unsure) = (is_mixed(rank), has_unknown_normal(rank));
        let distance = self.plane_distance(target, layer, evidence.depth_expected, pixel);
        if let Some((distance, footprint)) = distance {
            evidence.plane_distance_footprints = distance;
            evidence.footprint = footprint;
        }
        evidence.normal_angle_degrees = angle_degrees(self.normal, layer.normal[pixel.index]);
        evidence.color_difference_steps = self.color_difference(layer, pixel.index);
        let ray = ViewingRays::new(target).at(pixel.x, pixel.y);
        evidence.incidence_degrees = angle_degrees(-ray, layer.normal[pixel.index]);
        let pruning = &self.inspection.settings.pruning;
        let deciding = Rate::resolve(pruning.rate, &self.inspection.samples.cameras);
        [evidence.paper_r, evidence.footprint_r] =
            [Rate::Paper, deciding.with_focal_length()].map(|rate| self.ratio(rate, target, layer, pixel));
    }

    /// Distance to the tangent plane at the pixel found, in footprints, and the footprint; `None` at infinity.
    fn plane_distance(
        &self,
        target: &Camera,
        layer: &CameraLayer,
        depth_expected: f64,
        pixel: Pixel,
    ) -> Option<(f64, f64)> {
        let point = self.point_in_world()?;
        let inverse_depth = f64::from(layer.inverse_depth[pixel.index]);
        if inverse_depth <= 0.0 {
            return None;
        }
        let depth = 1.0 / inverse_depth;
        let surface = target.unproject(DVec2::new(pixel.x as f64 + 0.5, pixel.y as f64 + 0.5), depth);
        let normal = layer.normal[pixel.index].as_dvec3();
        let distance = if normal == DVec3::ZERO {
            (depth_expected - depth).abs()
        } else {
            normal.dot(point - surface).abs()
        };
        let side = |camera: &Camera| (camera.intrinsics.fx * camera.intrinsics.fy).sqrt().recip();
        let own = if self.source.intrinsics.is_orthographic() { 1.0 } else { self.inverse_depth };
        let footprint = (side(self.source) / own).max(side(target) * target.intrinsics.spread_at(depth));
        Some((distance / footprint, footprint))
    }

    fn color_difference(&self, layer: &CameraLayer, pixel: usize) -> f64 {
        let (a, b) = (self.layer.color[self.pixel.index], layer.color[pixel]);
        (0..3)
            .map(|c| f64::from((steps_from_linear(a[c]) - steps_from_linear(b[c])).abs()))
            .fold(0.0, f64::max)
    }

    fn ratio(&self, rate: Rate, target: &Camera, layer: &CameraLayer, pixel: Pixel) -> f64 {
        let pruning = &self.inspection.settings.pruning;
        let of = |camera: &Camera, layer: &CameraLayer, pixel: Pixel| {
            let rays = ViewingRays::new(camera);
            let (inverse_depth, normal) = (layer.inverse_depth[pixel.index], layer.normal[pixel.index]);
            f64::from(footprint(rate, &rays, rays.at(pixel.x, pixel.y), inverse_depth, normal, pruning))
        };
        of(self.source, self.layer, self.pixel) / of(target, layer, pixel)
    }
}

/// The angle between two directions; NaN where either is zero.
fn angle_degrees(a: Vec3, b: Vec3) -> f64 {
    if a == Vec3::ZERO || b == Vec3::ZERO {
        return f64::NAN;
    }
    f64::from(a.angle_between(b)).to_degrees()
}
