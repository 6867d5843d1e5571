//! Consensus depth: where the cameras that confirm a sample put its surface, on average.
//!
//! Purpose: surfaces of different cameras lie on each other, although each is noisy.
//!
//! Source: the inverse-variance mean, as of any independent measurements; the surface that another camera saw is the tangent plane
//! of its sample, met along the ray of this one. What differs: it is robust. Cameras take part within three standard deviations of
//! the sample, and count once more within three of the first mean, so that one that is far off does not pull it.

use glam::Vec3;

use crate::preprocess::layers::{CameraLayer, ViewingRays};
use crate::preprocess::registration::{CameraPairs, HAS_DEPTH, IN_VIEW, PixelRun, SameSurface};
use crate::preprocess::temporal::SpanLevel;
use crate::settings::{AgreementRule, PruningMethod, Settings};

/// Where a ray meets a tangent plane at a smaller cosine than this is not known: the normal is noisy.
const MIN_COSINE: f32 = 0.2;

/// What a camera is off counts for no less than this share of its variance, however much more slanted it looks.
const MIN_STRETCH: f32 = 0.25;

/// What is farther off than so many standard deviations takes no part.
const SIGMAS: f32 = 3.0;

/// Refines the depths of samples of noisy cameras.
pub(crate) struct Consensus<'a> {
    pairs: &'a CameraPairs<'a>,
    layers: &'a [CameraLayer],
    limits: SameSurface,
}

/// The surface that another camera saw along a sample's ray.
#[derive(Clone, Copy)]
struct Sighting {
    /// How much farther than the sample, relative to its depth.
    farther: f32,
    variance: f32,
}

impl<'a> Consensus<'a> {
    /// `None` where no depth is to be refined.
    pub(crate) fn new(
        pairs: &'a CameraPairs<'a>,
        layers: &'a [CameraLayer],
        level: SpanLevel,
        settings: &Settings,
    ) -> Option<Self> {
        let pruning = &settings.pruning;
        let is_on = pruning.agreement != AgreementRule::Off
            && pruning.method != PruningMethod::Off
            && settings.spans.noise > 0.0
            && layers.iter().any(|layer| layer.noise_between.is_some());
        is_on.then(|| Self { pairs, layers, limits: SameSurface::geometry_of(settings).at_level(level) })
    }

    /// The inverse depth of the sample of `camera` at `pixel`, refined by all cameras that confirm it; as recorded where it is at
    /// infinity or its noise lies below what its pixel covers.
    pub(crate) fn inverse_depth(&self, camera: usize, pixel: usize) -> f32 {
        let layer = &self.layers[camera];
        let recorded = layer.inverse_depth[pixel];
        let noise = layer.depth_noise_between(pixel);
        if recorded <= 0.0 || noise <= self.slant(camera, pixel) {
            return recorded;
        }
        let block = PixelRun::<1>::new(layer, pixel % layer.width, pixel / layer.width, 1);
        let mut sightings = vec![Sighting { farther: 0.0, variance: noise * noise }];
        for (other, target) in self.layers.iter().enumerate() {
            if other != camera && !target.geometry.is_empty() {
                sightings.extend(self.sighting(camera, &block, other));
            }
        }
        recorded / (1.0 + robust_mean(&sightings))
    }

    /// How far the surface that a pixel covers reaches along its ray, relative to its depth.
    fn slant(&self, camera: usize, pixel: usize) -> f32 {
        let layer = &self.layers[camera];
        let ray = ViewingRays::new(&self.pairs.cameras()[camera]).at(pixel % layer.width, pixel / layer.width);
        let normal = layer.normal[pixel];
        let cosine = if normal == Vec3::ZERO { 1.0 } else { -normal.dot(ray) / ray.length() };
        self.pairs.registration(camera, camera).source_side / cosine.max(MIN_COSINE)
    }

    /// What camera `other` saw of the sample's surface; `None` where it does not confirm it.
    fn sighting(&self, camera: usize, block: &PixelRun<1>, other: usize) -> Option<Sighting> {
        let (source, target) = (&self.layers[camera], &self.layers[other]);
        let registration = self.pairs.registration(camera, other);
        let reprojected = registration.reproject(block, target.width);
        if reprojected.bits[0] & IN_VIEW == 0 {
            return None;
        }
        let limits = self.limits.between(source, target);
        let found = reprojected.pixel[0] as usize;
        let there = target.inverse_depth[found];
        let matches = limits.compare(registration, (source, block), (target, &reprojected), [1]);
        if matches.bits[0] & HAS_DEPTH == 0 || there <= 0.0 {
            return None;
        }
        let w = block.inverse_depth[0];
        let point = [0, 1, 2].map(|axis| reprojected.point[axis][0] / w);
        let lens = &registration.target;
        let surface = [
            (reprojected.cell[0][0] + 0.5 - lens.center[0]) / (lens.focal[0] * there),
            (reprojected.cell[1][0] + 0.5 - lens.center[1]) / (lens.focal[1] * there),
            there.recip(),
        ];
        let normal = target.geometry[found].normal_in_camera;
        let ray = registration.ray(block).map(|axis| axis / w);
        let along = |to: [f32; 3]| normal[0] * to[0] + normal[1] * to[1] + normal[2] * to[2];
        let off = along([0, 1, 2].map(|axis| surface[axis] - point[axis]));
        let length = |to: [f32; 3]| to.iter().map(|axis| axis * axis).sum::<f32>().sqrt();
        let cosine = along(ray) / length(ray);
        if cosine.abs() < MIN_COSINE {
            return None;
        }
        let farther = off / along(ray);
        // What the camera is off along its own ray is so much along the sample's.
        let stretch = (along(surface) / (length(surface) * cosine)).powi(2);
        let [own, its] = [source.noise_between.as_ref()?.depth_at(w), target.depth_noise_between(found)];
        // A camera that is not noisy itself is off by no more than the others know.
        let variance = stretch.max(MIN_STRETCH) * if its > 0.0 { its * its } else { own * own };
        let limit = SIGMAS * (own * own + variance).sqrt();
        (farther.abs() <= limit).then_some(Sighting { farther, variance })
    }
}

/// The inverse-variance mean, and once more of what lies close to it.
fn robust_mean(sightings: &[Sighting]) -> f32 {
    let first = mean(sightings.iter());
    let close = |sighting: &&Sighting| {
        (sighting.farther - first).powi(2) <= SIGMAS * SIGMAS * sighting.variance
    };
    mean(sightings.iter().filter(close))
}

/// The inverse-variance mean; 0 of nothing.
fn mean<'a>(sightings: impl Iterator<Item = &'a Sighting>) -> f32 {
    let (mut sum, mut weights) = (0.0, 0.0);
    for sighting in sightings {
        sum += sighting.farther / sighting.variance;
        weights += sighting.variance.recip();
    }
    if weights > 0.0 { sum / weights } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_is_weighed_by_inverse_variances_and_one_that_is_far_off_does_not_pull_it() {
        let sighting = |farther: f32, sigma: f32| Sighting { farther, variance: sigma * sigma };
        let two = [sighting(0.0, 0.01), sighting(0.01, 0.02)];
        assert!((robust_mean(&two) - 0.002).abs() < 1e-6);
        let mut many = vec![sighting(0.01, 0.01); 9];
        many.push(sighting(-0.025, 0.01));
        assert!((robust_mean(&many) - 0.01).abs() < 1e-6, "{}", robust_mean(&many));
        assert_eq!(robust_mean(&[]), 0.0);
    }
}
