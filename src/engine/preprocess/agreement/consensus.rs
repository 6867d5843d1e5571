//! Consensus: where the cameras that confirm a sample put its surface, and which color they give it, on average.
//!
//! Purpose: surfaces of different cameras coincide although each is noisy, and dropped samples still improve the kept ones.
//! Colors of noisy cameras are averaged as well: where depth or pose are off, so is the color that one camera puts on a surface.
//!
//! A sample is *doubtful* if no other camera confirms it although several had a free view of its place: it may be a stray sample, but
//! too few cameras look past it to contradict it. Renderers show it where there is nothing else. A camera has a free view if its pixels
//! are fine enough and it recorded nothing nearer there. A sample that only one camera could have seen is not doubtful; neither is a
//! thing one pixel wide, which slips between pixels.
//!
//! Source: the inverse-variance mean, as of any independent measurements; the surface that another camera saw is interpolated
//! between its pixels, each smoothed over its neighbors ([`super::smooth_depth`]). Colors weigh as densely as they were sampled, and
//! are averaged as they are seen, in sRGB. What differs: it is robust. Cameras take part within three standard deviations of the
//! sample. The mean is taken again over those within three standard deviations of the first mean, so that an outlier does not pull
//! it. Colors are averaged however far apart they are: leaving out those beyond the tolerances of color costs 0.2 to 0.5 dB on
//! recordings, where poses are off by a pixel or two.

use std::sync::Arc;

use half::f16;

use super::smooth_depth::SmoothDepths;
use super::votes::{RESOLVES, VoteTest};
use crate::capture::overlap::{OverlapGraph, Registration};
use crate::color::{linear_from_srgb, steps_from_linear};
use crate::preprocess::layers::CameraLayer;
use crate::preprocess::registration::{IN_VIEW, PixelRun, ReprojectedRun};
use crate::preprocess::temporal::SpanLevel;
use crate::settings::{AgreementRule, PruningMethod, Settings};
use crate::simd::{self, VectorLoop, root_of_squares};

/// A surface is interpolated between pixels up to this many times as far off as the limit, since it may be slanted.
const ACROSS: f32 = 2.0;

/// Samples farther off than this many standard deviations take no part.
const SIGMAS: f32 = 3.0;

/// Colors of pixels this many times as large as the sample's would blur it.
const COARSEST: f32 = 2.0;

/// Colors count where depth differs by at most this many standard deviations: a pixel farther off may be beside the surface.
const COLOR_SIGMAS: f32 = 2.0;

/// Colors around a sample count only if at least this share of the pixels shows its surface.
const MOST: f32 = 0.5;

/// Depths that differ by less than this many footprints are of one surface, however small the noise is.
const LEAST_FOOTPRINTS: f32 = 2.0;

/// A sample that no camera confirms is doubtful if at least this many had a free view of it. One alone may have missed it.
const MISSED_BY: u32 = 2;

/// Refines depths and colors of samples of noisy cameras.
pub struct Consensus<'a> {
    pairs: &'a OverlapGraph<'a>,
    layers: &'a [CameraLayer],
    level: SpanLevel,
    smooth: Arc<SmoothDepths>,
    votes: VoteTest,
}

/// A sample as the cameras that confirm it put it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AgreedSample {
    /// Linear Rec.709.
    pub(crate) color: [f16; 3],
    /// 1 / planar z.
    pub(crate) inverse_depth: f32,
    /// No other camera confirms it, although some had a free view of it.
    pub(crate) is_doubtful: bool,
}

impl AgreedSample {
    /// A sample as it was recorded.
    pub(crate) fn recorded(layer: &CameraLayer, pixel: usize) -> Self {
        Self { color: layer.color[pixel], inverse_depth: layer.inverse_depth[pixel], is_doubtful: false }
    }
}

/// The surface that another camera saw along a sample's ray.
#[derive(Clone, Copy)]
struct Sighting {
    /// How much farther than the sample, relative to its depth.
    farther: f32,
    variance: f32,
}

/// A sum of colors in 8-bit sRGB steps, by weight.
#[derive(Clone, Copy, Default)]
struct ColorSum {
    steps: [f32; 3],
    weight: f32,
}

impl ColorSum {
    #[inline(always)]
    fn add(&mut self, weight: f32, steps: [f32; 3]) {
        (0..3).for_each(|channel| self.steps[channel] += weight * steps[channel]);
        self.weight += weight;
    }

    #[inline(always)]
    fn mean(self) -> [f32; 3] {
        self.steps.map(|sum| sum / self.weight)
    }
}

impl<'a> Consensus<'a> {
    /// `None` where nothing is to be refined.
    pub(crate) fn new(
        pairs: &'a OverlapGraph<'a>,
        layers: &'a [CameraLayer],
        level: SpanLevel,
        settings: &Settings,
    ) -> Option<Self> {
        let is_noisy = layers.iter().any(|layer| layer.noise_between.is_some());
        Self::is_on(settings, is_noisy).then(|| {
            let smooth = Arc::new(SmoothDepths::new(pairs, level));
            Self::smoothed(pairs, layers, &smooth, settings)
        })
    }

    /// Whether anything is to be refined where cameras are noisy, or are not.
    pub(crate) fn is_on(settings: &Settings, is_noisy: bool) -> bool {
        let pruning = &settings.pruning;
        pruning.agreement != AgreementRule::Off
            && pruning.method != PruningMethod::Off
            && settings.spans.noise > 0.0
            && is_noisy
    }

    /// With depths that other consensuses of the same layers have smoothed so far.
    pub(crate) fn smoothed(
        pairs: &'a OverlapGraph<'a>,
        layers: &'a [CameraLayer],
        smooth: &Arc<SmoothDepths>,
        settings: &Settings,
    ) -> Self {
        let level = smooth.level();
        Self { pairs, layers, level, smooth: smooth.clone(), votes: VoteTest::new(settings, level) }
    }

    /// The samples of `camera` at some pixels, refined by all cameras that confirm them.
    pub(crate) fn samples(&self, camera: usize, pixels: &[u32]) -> Vec<AgreedSample> {
        simd::run(AgreeOn { consensus: self, camera, pixels })
    }

    /// The sample of `camera` at `pixel`, refined; as recorded where it is at infinity or its noise is below a footprint. `sightings`
    /// is scratch.
    #[inline(always)]
    fn sample(&self, camera: usize, pixel: usize, sightings: &mut Vec<Sighting>) -> AgreedSample {
        let layer = &self.layers[camera];
        let recorded = layer.inverse_depth[pixel];
        let noise = layer.depth_noise_between(pixel);
        let own = self.pairs.registration(camera, camera);
        let own_side = own.relative_source_side(recorded);
        if recorded <= 0.0 || noise <= own_side {
            return AgreedSample::recorded(layer, pixel);
        }
        let mut block = PixelRun::<1>::new(layer, pixel % layer.width, pixel / layer.width, 1);
        sightings.clear();
        let smooth = self.smooth.at(self.layers, camera, [pixel % layer.width, pixel / layer.width]);
        sightings.push(Sighting { farther: recorded / smooth - 1.0, variance: noise * noise });
        let mut missed = 0;
        for (other, registration) in self.others(camera) {
            if let Some(there) = self.corners(registration, &block, other) {
                let found = self.sighting(&there, other, [noise, self.noise_of(other, there.expected)]);
                missed += u32::from(found.is_none() && self.has_free_view(&there, other, noise));
                sightings.extend(found);
            }
        }
        let mut is_confirmed = sightings.len() > 1;
        let refined = recorded / (1.0 + robust_mean(sightings));
        block.inverse_depth[0] = refined;
        let mut color = ColorSum::default();
        color.add(1.0, layer.color[pixel].map(steps_from_linear));
        for (other, registration) in self.others(camera) {
            if let Some(there) = self.corners(registration, &block, other)
                && there.coarseness <= COARSEST
                && let Some(its) = self.color_seen(&there, other, noise)
            {
                is_confirmed = true;
                color.add(there.coarseness.powi(-2), its);
            }
        }
        AgreedSample {
            color: color.mean().map(|steps| f16::from_f32(linear_from_srgb(steps / 255.0))),
            inverse_depth: refined,
            is_doubtful: missed >= MISSED_BY && !is_confirmed && !self.votes.is_thin(layer, pixel, own),
        }
    }

    /// Whether a camera would have seen a sample with so much noise: its pixels are fine enough, and none of those around it shows
    /// anything nearer.
    #[inline(always)]
    fn has_free_view(&self, there: &Corners, other: usize, noise: f32) -> bool {
        let limit = (SIGMAS * root_of_squares(noise, self.noise_of(other, there.expected)))
            .max(LEAST_FOOTPRINTS * there.side);
        there.coarseness <= RESOLVES
            && there.pixels.iter().all(|(at, _)| {
                at.is_some_and(|at| {
                    self.inverse_depth_at(other, at)
                        .is_none_or(|inverse_depth| there.farther(inverse_depth) >= -limit)
                })
            })
    }

    /// The other cameras that have samples.
    #[inline(always)]
    fn others(&self, camera: usize) -> impl Iterator<Item = (usize, &Registration)> {
        self.pairs.others(camera).filter(|(other, _)| !self.layers[*other].geometry.is_empty())
    }

    /// Where a sample of a camera is in another one; `None` outside its picture.
    #[inline(always)]
    fn corners(&self, registration: &Registration, block: &PixelRun<1>, other: usize) -> Option<Corners> {
        let reprojected = registration.reproject(block, self.layers[other].width);
        let is_in_view = reprojected.bits[0] & IN_VIEW != 0;
        is_in_view.then(|| Corners::new(registration, &reprojected, block.inverse_depth[0]))
    }

    /// What camera `other` saw of the sample's surface; `None` where it does not confirm it. `noise` is that of the sample and that of
    /// the camera.
    #[inline(always)]
    fn sighting(&self, there: &Corners, other: usize, noise: [f32; 2]) -> Option<Sighting> {
        let [own, its] = noise;
        // A camera without measured noise counts as noisy as the sample.
        let variance = if its > 0.0 { its * its } else { own * own };
        let limit = SIGMAS * (own * own + variance).sqrt();
        // Inverse depth is linear over a plane, so that interpolating it is exact, however slanted the plane is.
        let mut interpolated = 0.0;
        for (at, weight) in there.pixels {
            let inverse_depth = self.smooth_at(other, at?)?;
            if there.farther(inverse_depth).abs() > ACROSS * limit {
                return None;
            }
            interpolated += weight * inverse_depth;
        }
        let farther = there.farther(interpolated);
        (farther.abs() <= limit).then_some(Sighting { farther, variance })
    }

    /// The color that camera `other` gives to the surface of a sample with this noise, 8-bit sRGB steps; `None` where most of the
    /// pixels around it show something else.
    #[inline(always)]
    fn color_seen(&self, there: &Corners, other: usize, noise: f32) -> Option<[f32; 3]> {
        let its_noise = self.noise_of(other, there.expected);
        // A camera without measured noise counts as noisy as the sample.
        let its_noise = if its_noise > 0.0 { its_noise } else { noise };
        let limit = (COLOR_SIGMAS * root_of_squares(noise, its_noise)).max(LEAST_FOOTPRINTS * there.side);
        let mut color = ColorSum::default();
        for (at, weight) in there.pixels {
            if let Some(at) = at
                && let Some(inverse_depth) = self.smooth_at(other, at)
                && there.farther(inverse_depth).abs() <= limit
            {
                let target = &self.layers[other];
                color.add(weight, target.color[at[1] * target.width + at[0]].map(steps_from_linear));
            }
        }
        (color.weight >= MOST).then(|| color.mean())
    }

    /// The inverse depth of a pixel of a camera, if it holds a finite sample.
    #[inline(always)]
    fn inverse_depth_at(&self, camera: usize, [x, y]: [usize; 2]) -> Option<f32> {
        let layer = &self.layers[camera];
        let pixel = y * layer.width + x;
        let inverse_depth = layer.inverse_depth[pixel];
        (inverse_depth > 0.0 && layer.level[pixel] <= self.level).then_some(inverse_depth)
    }

    /// That inverse depth, smoothed.
    #[inline(always)]
    fn smooth_at(&self, camera: usize, at: [usize; 2]) -> Option<f32> {
        self.inverse_depth_at(camera, at).map(|_| self.smooth.at(self.layers, camera, at))
    }

    /// Relative standard deviation of what a camera sees at a depth.
    #[inline(always)]
    fn noise_of(&self, camera: usize, depth: f32) -> f32 {
        self.layers[camera].noise_between.as_ref().map_or(0.0, |noise| noise.depth_at(depth.recip()))
    }
}

/// Some samples of one camera.
struct AgreeOn<'a, 'b> {
    consensus: &'a Consensus<'b>,
    camera: usize,
    pixels: &'a [u32],
}

impl VectorLoop for AgreeOn<'_, '_> {
    type Output = Vec<AgreedSample>;

    #[inline(always)]
    fn run(self) -> Vec<AgreedSample> {
        let mut sightings = Vec::new();
        let mut samples = Vec::with_capacity(self.pixels.len());
        for &pixel in self.pixels {
            samples.push(self.consensus.sample(self.camera, pixel as usize, &mut sightings));
        }
        samples
    }
}

/// Where a sample is among the pixels of another camera.
struct Corners {
    /// Column and row of the 2×2 pixels around it, `None` beside the picture, and their bilinear weights.
    pixels: [(Option<[usize; 2]>, f32); 4],
    /// Its depth there.
    expected: f32,
    /// The size of the camera's pixels on it, relative to its own.
    coarseness: f32,
    /// The side of the camera's pixels there, relative to that depth.
    side: f32,
}

impl Corners {
    #[inline(always)]
    fn new(registration: &Registration, reprojected: &ReprojectedRun<1>, inverse_depth: f32) -> Self {
        let expected = reprojected.point[2][0] / inverse_depth;
        let corner = |corner: usize| {
            let toward = [corner & 1, corner >> 1];
            let (mut at, mut weight) = (Some([0; 2]), 1.0);
            for axis in 0..2 {
                let off = reprojected.off_center[axis][0];
                let cell = reprojected.cell[axis][0] + if toward[axis] == 1 { off.signum() } else { 0.0 };
                let inside = cell >= 0.0 && cell < registration.target.size[axis];
                at = at.filter(|_| inside).map(|mut at| {
                    at[axis] = cell as usize;
                    at
                });
                weight *= if toward[axis] == 1 { off.abs() } else { 1.0 - off.abs() };
            }
            (at, weight)
        };
        let coarseness = if registration.has_orthographic() {
            registration.coarseness(inverse_depth, reprojected.point[2][0])
        } else {
            registration.target.side * expected * inverse_depth / registration.source_side
        };
        let side = registration.target.relative_side(expected.recip());
        Self { pixels: [0, 1, 2, 3].map(corner), expected, coarseness, side }
    }

    /// How much farther than the sample another surface lies, relative to its depth.
    #[inline(always)]
    fn farther(&self, inverse_depth: f32) -> f32 {
        1.0 / (inverse_depth * self.expected) - 1.0
    }
}

/// The inverse-variance mean, and once more of what is close to it.
#[inline(always)]
fn robust_mean(sightings: &[Sighting]) -> f32 {
    let first = mean(sightings.iter());
    let close =
        |sighting: &&Sighting| (sighting.farther - first).powi(2) <= SIGMAS * SIGMAS * sighting.variance;
    mean(sightings.iter().filter(close))
}

/// The inverse-variance mean; 0 of nothing.
#[inline(always)]
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
