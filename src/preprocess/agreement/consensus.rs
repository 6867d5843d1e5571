//! Consensus: where the cameras that confirm a sample put its surface, and which color they give it, on average.
//!
//! Purpose: surfaces of different cameras lie on each other, although each is noisy, and what is dropped has not been recorded in
//! vain. Colors of noisy cameras are averaged as well: where depth or pose are off, so is the color that one camera puts on a
//! surface.
//!
//! Source: the inverse-variance mean, as of any independent measurements; the surface that another camera saw is interpolated
//! between its pixels. Colors weigh as densely as they were sampled. What differs: it is robust. Cameras take part within three
//! standard deviations of the sample, and count once more within three of the first mean, so that one that is far off does not
//! pull it.

use half::f16;

use crate::preprocess::layers::CameraLayer;
use crate::preprocess::registration::{CameraPairs, IN_VIEW, PixelRun};
use crate::preprocess::temporal::SpanLevel;
use crate::settings::{AgreementRule, PruningMethod, Settings};

/// Pixels between which a surface is interpolated may be so many times as far off, since it may be slanted.
const ACROSS: f32 = 2.0;

/// What is farther off than so many standard deviations takes no part.
const SIGMAS: f32 = 3.0;

/// Refines depths and colors of samples of noisy cameras.
pub(crate) struct Consensus<'a> {
    pairs: &'a CameraPairs<'a>,
    layers: &'a [CameraLayer],
    level: SpanLevel,
}

/// The surface that another camera saw along a sample's ray.
#[derive(Clone, Copy)]
struct Sighting {
    /// How much farther than the sample, relative to its depth.
    farther: f32,
    variance: f32,
    /// Linear.
    color: [f32; 3],
    /// How densely it was sampled there, squared, relative to the sample: no more than 1.
    density: f32,
}

impl<'a> Consensus<'a> {
    /// `None` where nothing is to be refined.
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
        is_on.then_some(Self { pairs, layers, level })
    }

    /// Color and inverse depth of the sample of `camera` at `pixel`, refined by all cameras that confirm it; as recorded where it is
    /// at infinity or its noise lies below a footprint.
    pub(crate) fn sample(&self, camera: usize, pixel: usize) -> ([f16; 3], f32) {
        let layer = &self.layers[camera];
        let recorded = layer.inverse_depth[pixel];
        let noise = layer.depth_noise_between(pixel);
        if recorded <= 0.0 || noise <= self.pairs.registration(camera, camera).source_side {
            return (layer.color[pixel], recorded);
        }
        let color = layer.color[pixel].map(f16::to_f32);
        let block = PixelRun::<1>::new(layer, pixel % layer.width, pixel / layer.width, 1);
        let mut sightings = vec![Sighting { farther: 0.0, variance: noise * noise, color, density: 1.0 }];
        for (other, target) in self.layers.iter().enumerate() {
            if other != camera && !target.geometry.is_empty() {
                sightings.extend(self.sighting(camera, &block, other));
            }
        }
        let (farther, color) = robust_mean(&sightings);
        (color.map(f16::from_f32), recorded / (1.0 + farther))
    }

    /// What camera `other` saw of the sample's surface; `None` where it does not confirm it.
    fn sighting(&self, camera: usize, block: &PixelRun<1>, other: usize) -> Option<Sighting> {
        let (source, target) = (&self.layers[camera], &self.layers[other]);
        let registration = self.pairs.registration(camera, other);
        let reprojected = registration.reproject(block, target.width);
        if reprojected.bits[0] & IN_VIEW == 0 {
            return None;
        }
        let w = block.inverse_depth[0];
        let expected = reprojected.point[2][0] / w;
        let [own, its] =
            [source.depth_noise_between(pixel_of(block, source)), self.noise_of(other, expected)];
        // A camera that is not noisy itself is off by no more than the others know.
        let variance = if its > 0.0 { its * its } else { own * own };
        let limit = SIGMAS * (own * own + variance).sqrt();
        let farther = |inverse_depth: f32| 1.0 / (inverse_depth * expected) - 1.0;
        // Inverse depth is linear over a plane, so that interpolating it is exact, however slanted the plane is.
        let (mut interpolated, mut color) = (0.0, [0.0; 3]);
        for corner in 0..4 {
            let toward = [corner & 1, corner >> 1];
            let mut weight = 1.0;
            let mut at = [0; 2];
            for axis in 0..2 {
                let off = reprojected.off_center[axis][0];
                let cell = reprojected.cell[axis][0] + if toward[axis] == 1 { off.signum() } else { 0.0 };
                if cell < 0.0 || cell >= registration.target.size[axis] {
                    return None;
                }
                at[axis] = cell as usize;
                weight *= if toward[axis] == 1 { off.abs() } else { 1.0 - off.abs() };
            }
            let pixel = at[1] * target.width + at[0];
            let there = target.inverse_depth[pixel];
            let is_seen = there > 0.0 && target.level[pixel] <= self.level;
            if !is_seen || farther(there).abs() > ACROSS * limit {
                return None;
            }
            interpolated += weight * there;
            let its = target.color[pixel];
            (0..3).for_each(|channel| color[channel] += weight * its[channel].to_f32());
        }
        let farther = farther(interpolated);
        let ratio = registration.source_side / (registration.target.side * expected * w);
        let density = (ratio * ratio).min(1.0);
        (farther.abs() <= limit).then_some(Sighting { farther, variance, color, density })
    }

    /// Relative standard deviation of what a camera sees at a depth.
    fn noise_of(&self, camera: usize, depth: f32) -> f32 {
        self.layers[camera].noise_between.as_ref().map_or(0.0, |noise| noise.depth_at(depth.recip()))
    }
}

fn pixel_of(block: &PixelRun<1>, layer: &CameraLayer) -> usize {
    block.row * layer.width + block.column
}

/// Means as of [`mean`], and once more of what lies close to the first.
fn robust_mean(sightings: &[Sighting]) -> (f32, [f32; 3]) {
    let (first, _) = mean(sightings.iter());
    let close =
        |sighting: &&Sighting| (sighting.farther - first).powi(2) <= SIGMAS * SIGMAS * sighting.variance;
    mean(sightings.iter().filter(close))
}

/// The inverse-variance mean of how much farther, and the mean color by density; 0 of nothing.
fn mean<'a>(sightings: impl Iterator<Item = &'a Sighting>) -> (f32, [f32; 3]) {
    let (mut sum, mut weights) = (0.0, 0.0);
    let (mut color, mut densities) = ([0.0; 3], 0.0);
    for sighting in sightings {
        sum += sighting.farther / sighting.variance;
        weights += sighting.variance.recip();
        (0..3).for_each(|channel| color[channel] += sighting.density * sighting.color[channel]);
        densities += sighting.density;
    }
    let over = |sum: f32, weights: f32| if weights > 0.0 { sum / weights } else { 0.0 };
    (over(sum, weights), color.map(|sum| over(sum, densities)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_is_weighed_by_inverse_variances_and_one_that_is_far_off_does_not_pull_it() {
        let sighting = |farther: f32, sigma: f32| Sighting {
            farther,
            variance: sigma * sigma,
            color: [farther, 0.5, 0.0],
            density: 1.0,
        };
        let robust_mean = |sightings: &[Sighting]| {
            let (farther, color) = robust_mean(sightings);
            assert!(sightings.is_empty() || color[1] == 0.5, "{color:?}");
            farther
        };
        let two = [sighting(0.0, 0.01), sighting(0.01, 0.02)];
        assert!((robust_mean(&two) - 0.002).abs() < 1e-6);
        let mut many = vec![sighting(0.01, 0.01); 9];
        many.push(sighting(-0.025, 0.01));
        assert!((robust_mean(&many) - 0.01).abs() < 1e-6, "{}", robust_mean(&many));
        assert_eq!(robust_mean(&[]), 0.0);
    }
}
