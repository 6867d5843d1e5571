//! What one camera says about the sample that is explained, in numbers.

use glam::{DVec2, DVec3, Vec3};

use super::frame::FrameInspection;
use super::pixel_report::{CameraEvidence, PairQuantities};
use crate::capture::Camera;
use crate::color::steps_from_linear;
use crate::preprocess::agreement::VoteTest;
use crate::preprocess::layers::{CameraLayer, Rate, ViewingRays, footprint, has_unknown_normal, is_mixed};
use crate::preprocess::registration::{CameraPairs, Outcome, SameSurface};

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
pub(super) struct ExplainedSample<'a> {
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
    pub(super) fn new(inspection: &'a FrameInspection, camera: usize, x: usize, y: usize) -> Self {
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

    pub(super) fn point_in_world(&self) -> Option<DVec3> {
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

    pub(super) fn quantities(
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

    pub(super) fn evidence(
        &self,
        pairs: &CameraPairs<'_>,
        limits: &SameSurface,
        other: usize,
    ) -> CameraEvidence {
        let target = &self.inspection.samples.cameras[other];
        let layer = &self.inspection.layers[other];
        let own = other == self.camera;
        let way = pairs.registration(self.camera, other);
        let outcome = (!own).then(|| limits.explain(way, (self.layer, self.x, self.y), layer));
        let mut evidence = CameraEvidence {
            camera: other,
            outcome,
            vote: (!own).then(|| {
                let votes = VoteTest::new(&self.inspection.settings, self.layer.level[self.pixel]);
                votes.vote(way, &self.inspection.layers, (self.camera, self.pixel as u32), other)
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
        let rank = layer.ranks[pixel];
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
