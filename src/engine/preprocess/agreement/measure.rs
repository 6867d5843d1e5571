//! Noise between cameras, from how far apart they put what both see.
//!
//! Purpose: tolerances that fit the capture. Samples on a lattice are carried into the other cameras; their distances from the
//! tangent planes found there are as wide as the noise of both. What is hidden, or misread, is far off, and counts for nothing:
//! the standard deviation is that of the distances within three of it.
//!
//! Source: the median absolute deviation (Hampel 1974), of distances that are cut at three standard deviations until they stay.
//! What differs: a camera counts as noisy only if the nearest quarter of its samples speaks for noise beyond a footprint. Exact
//! depth has most distances next to zero, however many silhouettes there are, so that nothing is measured there. And a few cameras
//! that fit none of the others are not noisy but wrong.

use std::sync::Arc;

use rayon::prelude::*;

use crate::capture::overlap::{OverlapGraph, Registration};
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::layers::{COLOR_STEPS, CameraLayer};
use crate::preprocess::noise::{BRIGHTNESS_BINS, DEPTH_CLASSES, NoiseBetween, brightness_bin, depth_class};
use crate::preprocess::registration::{
    HAS_DEPTH, IN_VIEW, PixelRun, RequiredTolerances, SameSurface, SourceRun, TargetRun,
};
use crate::preprocess::temporal::{NO_SAMPLE, ROOT};
use crate::simd::LANES;

/// About this many samples of each camera are looked for in each other one; with many cameras fewer.
const SAMPLES: usize = 8192;
const FEWEST_SAMPLES: usize = 512;
/// The number of samples falls with more cameras than this.
const FEW_CAMERAS: usize = 9;

/// Samples are looked for in no more cameras than this, spread over those that may see them: what is measured of one camera does not
/// grow with the number of the others.
const MOST_OTHERS: usize = 32;

/// Two cameras that disagree are not enough to tell noise from a wrong camera.
const MIN_CAMERAS: usize = 3;

/// A class of depth, or of brightness, with fewer differences takes its value from the next that has as many.
const MIN_DIFFERENCES: usize = 256;

/// Surfaces that are farther apart than this, relative to their depth, are different ones.
const FARTHEST_RELATIVE: f32 = 0.2;

/// Distances beyond this many standard deviations belong to other surfaces.
const SIGMAS: f32 = 3.0;

/// Φ⁻¹(0.75) and Φ⁻¹(0.625): the median and the lower quartile of the magnitude of a normal draw.
const MEDIAN_PER_SIGMA: f32 = 0.6745;
const QUARTILE_PER_SIGMA: f32 = 0.3186;

/// The noise of each camera as the others see it; `None` where it is too small to matter.
pub(crate) fn measure_noise_between(
    pairs: &OverlapGraph<'_>,
    layers: &[CameraLayer],
    job: &Job,
) -> Result<Vec<Option<Arc<NoiseBetween>>>> {
    let all: Vec<usize> = (0..layers.len()).collect();
    let of_camera = |camera: usize| {
        job.check()?;
        let mut lattice = NoiseLattice::of(&layers[camera], layers.len());
        lattice.compare(pairs, camera, layers, &all);
        Ok(lattice.noise())
    };
    let noise: Vec<_> = (0..layers.len()).into_par_iter().map(of_camera).collect::<Result<_>>()?;
    Ok(where_most_are_noisy(noise))
}

/// The noise of all cameras, if most of them are noisy: a few are not noisy but wrong.
pub(crate) fn where_most_are_noisy(noise: Vec<Option<Arc<NoiseBetween>>>) -> Vec<Option<Arc<NoiseBetween>>> {
    let is_noisy = 2 * noise.iter().flatten().count() > noise.len();
    if is_noisy { noise } else { vec![None; noise.len()] }
}

/// By how much one sample differs from what another camera shows there.
#[derive(Clone, Copy)]
struct SampleDifference {
    class: usize,
    /// Distance relative to the sample's depth, beyond what rounding explains.
    relative: f32,
    /// The same in footprints.
    footprints: f32,
    /// 8-bit sRGB steps.
    brightness: f32,
    color_steps: f32,
}

/// Some samples of one camera, and how they differ from what the others show.
pub(crate) struct NoiseLattice {
    runs: Vec<PixelRun>,
    differences: Vec<SampleDifference>,
}

impl NoiseLattice {
    /// Samples of all frames, spread evenly over the picture of one of so many `cameras`; none where these are too few to measure noise.
    pub(crate) fn of(layer: &CameraLayer, cameras: usize) -> Self {
        let mut runs = Vec::new();
        if cameras >= MIN_CAMERAS {
            let samples = (SAMPLES * FEW_CAMERAS / cameras).clamp(FEWEST_SAMPLES, SAMPLES);
            let step = (layer.width * layer.height() / samples).isqrt().max(1);
            for row in (step / 2..layer.height()).step_by(step) {
                // Neighboring rows begin elsewhere, so that no column of the picture is left out.
                for column in (row / step % step * LANES..layer.width).step_by(step * LANES) {
                    let end = (column + LANES).min(layer.width);
                    let levels = &layer.level[row * layer.width..][column..end];
                    let lanes =
                        levels.iter().enumerate().map(|(lane, level)| u32::from(*level == ROOT) << lane);
                    let lanes = lanes.fold(0, |all, lane| all | lane);
                    if lanes != 0 {
                        runs.push(PixelRun::new(layer, column, row, lanes));
                    }
                }
            }
        }
        Self { runs, differences: Vec::new() }
    }

    /// Adds the differences of the samples of `camera` from what some other cameras show: those that are asked and whose layers are
    /// there.
    pub(crate) fn compare(
        &mut self,
        pairs: &OverlapGraph<'_>,
        camera: usize,
        layers: &[CameraLayer],
        targets: &[usize],
    ) {
        let mut others: Vec<usize> = pairs.few_others(camera, MOST_OTHERS).collect();
        others.retain(|other| targets.contains(other) && !layers[*other].geometry.is_empty());
        for run in &self.runs {
            for (other, registration) in pairs.others_among(camera, &others) {
                let source = SourceRun::of_layer(&layers[camera], run);
                add_differences(&mut self.differences, registration, source, &layers[other]);
            }
        }
    }

    /// The noise of the camera as the others see it; `None` where it is too small to matter.
    pub(crate) fn noise(self) -> Option<Arc<NoiseBetween>> {
        CameraDifferences(self.differences).noise().map(Arc::new)
    }
}

/// Differences of one camera's samples from what the others show.
struct CameraDifferences(Vec<SampleDifference>);

impl CameraDifferences {
    fn noise(mut self) -> Option<NoiseBetween> {
        if self.0.len() < MIN_DIFFERENCES {
            return None;
        }
        let mut footprints: Vec<f32> = self.0.iter().map(|difference| difference.footprints).collect();
        let spread = spread(&mut footprints);
        let within = footprints.partition_point(|distance| *distance <= SIGMAS * spread);
        if SIGMAS * footprints[within / 4] / QUARTILE_PER_SIGMA <= 1.0 {
            return None;
        }
        let of_class = |differences: &[SampleDifference], class: usize| {
            let of_class = differences.iter().filter(|difference| difference.class == class);
            let mut relative: Vec<f32> = of_class.map(|difference| difference.relative).collect();
            (relative.len() >= MIN_DIFFERENCES).then(|| spread_of_one(&mut relative))
        };
        let depths = (0..DEPTH_CLASSES).map(|class| of_class(&self.0, class)).collect::<Vec<_>>();
        let depth_relative = filled(&depths).unwrap_or_else(|| {
            let mut relative: Vec<f32> = self.0.iter().map(|difference| difference.relative).collect();
            vec![spread_of_one(&mut relative); DEPTH_CLASSES]
        });
        let depth_relative: [f32; DEPTH_CLASSES] = std::array::from_fn(|class| depth_relative[class]);
        self.0.retain(|difference| {
            difference.relative <= SIGMAS * std::f32::consts::SQRT_2 * depth_relative[difference.class]
        });
        let of_bin = |bin: usize| {
            let of_bin = self.0.iter().filter(|difference| brightness_bin(difference.brightness) == bin);
            let mut steps: Vec<f32> = of_bin.map(|difference| difference.color_steps).collect();
            (steps.len() >= MIN_DIFFERENCES).then(|| spread_of_one(&mut steps))
        };
        let colors = filled(&(0..BRIGHTNESS_BINS).map(of_bin).collect::<Vec<_>>());
        let color_steps =
            colors.map_or([0.0; BRIGHTNESS_BINS], |steps| std::array::from_fn(|bin| steps[bin]));
        Some(NoiseBetween { depth_relative, color_steps })
    }
}

/// The standard deviation of the magnitudes, estimated from those within three of it. Sorts them; there is at least one.
fn spread(magnitudes: &mut [f32]) -> f32 {
    magnitudes.sort_unstable_by(f32::total_cmp);
    let mut within = magnitudes.len();
    loop {
        let sigma = magnitudes[within / 2] / MEDIAN_PER_SIGMA;
        let closer = magnitudes.partition_point(|distance| *distance <= SIGMAS * sigma);
        if closer >= within {
            return sigma;
        }
        within = closer.max(1);
    }
}

/// The standard deviation of either side of these differences.
fn spread_of_one(magnitudes: &mut [f32]) -> f32 {
    spread(magnitudes) * std::f32::consts::FRAC_1_SQRT_2
}

/// Fills missing values from their nearest neighbors; `None` if all are missing.
fn filled(values: &[Option<f32>]) -> Option<Vec<f32>> {
    let known: Vec<(usize, f32)> =
        values.iter().enumerate().filter_map(|(at, value)| Some((at, (*value)?))).collect();
    let nearest =
        |at: usize| known.iter().min_by_key(|(other, _)| other.abs_diff(at)).map(|(_, value)| *value);
    (0..values.len()).map(nearest).collect()
}

fn add_differences(
    differences: &mut Vec<SampleDifference>,
    registration: &Registration,
    source: SourceRun<'_>,
    target: &CameraLayer,
) {
    let block = source.run;
    let reprojected = registration.reproject(block, target.width);
    let relevant = reprojected.bits.map(|bits| u32::from(bits & IN_VIEW != 0));
    let mut required = RequiredTolerances::new(0.0);
    let limits = SameSurface::geometry_within(1.0);
    let target_run = TargetRun { layer: target, reprojected: &reprojected };
    let matches =
        limits.compare_measuring::<LANES, true>(registration, source, target_run, relevant, &mut required);
    for lane in 0..LANES {
        let w = block.inverse_depth[lane];
        let found = matches.pixel[lane] as usize;
        if relevant[lane] == 0 || matches.bits[lane] & HAS_DEPTH == 0 || w <= 0.0 {
            continue;
        }
        let there = target.inverse_depth[found];
        if there <= 0.0 || target.level[found] == NO_SAMPLE {
            continue;
        }
        let footprint = registration.larger_footprint(w, there);
        let relative = required.depth[lane] * footprint / there;
        if relative > FARTHEST_RELATIVE {
            continue;
        }
        differences.push(SampleDifference {
            class: depth_class(w),
            relative,
            footprints: required.depth[lane],
            brightness: block.color[1][lane] as f32 / COLOR_STEPS,
            color_steps: required.color[lane],
        });
    }
}
