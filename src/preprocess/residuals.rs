//! Do two cameras agree? How far apart they put surfaces that both should see.
//!
//! Purpose: a camera whose pose is wrong disagrees with all others about what never moves; one whose clock is wrong, only
//! about what moves. Both show here, pair by pair, before they show as ghosts in a picture.
//!
//! Source: the paper takes calibrated and synchronized cameras for granted. Distances are those of
//! [`super::same_surface`], in footprints: from a sample to the tangent plane of what the other camera saw in its place. What
//! differs: there is no tolerance. Where the other camera sees something much nearer, the sample is hidden and says nothing;
//! where it sees something farther, it looks through the surface, and the distance counts however large it is. Samples lie on a
//! lattice, and what most of them do not exceed is blind to silhouettes and to single wrong pixels.

use std::ops::RangeInclusive;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::contest::lanes_at;
use super::facet::MIXED;
use super::layer::{Layer, Level, NO_SAMPLE, ROOT};
use super::pruning::Rig;
use super::registration::{Block, LANES, Outcome, Registration, SameSurface};
use super::same_surface::{IN_VIEW, Needs};
use super::spread::Spread;
use crate::error::Result;
use crate::job::Job;
use crate::simd::{self, Work};

/// What is nearer than a sample by more than this, in footprints, hides it. Much more, and what is hidden by something close by
/// passes for disagreement.
const HIDING_FOOTPRINTS: f32 = 2.0;

/// The share of the samples that a residual speaks for. Only part of what moves is off where clocks differ, so that the median
/// may not show it; on the silhouettes of correct captures up to one sample in ten is.
const MOST: f64 = 0.85;

/// Fewer samples of a pair say nothing.
const MIN_SAMPLES: u64 = 48;

/// Samples of each camera that another one is asked about, about: with many cameras fewer, so that all together are no more.
const LATTICE_SAMPLES: usize = 8192;
const FEWEST_LATTICE_SAMPLES: usize = 1024;
/// Cameras up to which nothing is spared.
const FEW_CAMERAS: usize = 9;

/// Frames at which moving samples are looked at, at most: spread over all.
const FRAMES: usize = 8;

/// How far the samples of one camera that nothing hides from another are off.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Residual {
    /// Samples that were compared.
    pub samples: u64,
    /// Distance to the tangent plane of what the other camera saw there, in footprints of the coarser of the two, median.
    pub median_footprints: f32,
    /// The distance that 85 % of the samples do not exceed.
    pub most_footprints: f32,
    /// Difference of color where both see the surface, the widest channel, 8-bit sRGB steps, median. Noise is not taken out.
    pub median_color_steps: f32,
}

/// How one camera's samples fit what another saw.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PairResiduals {
    /// Of samples that are the same over all frames: large where a pose is wrong. `None` where too few are seen by both.
    pub lasting: Option<Residual>,
    /// Of all others: large while `lasting` is small where clocks differ. `None` where too few are seen by both.
    pub moving: Option<Residual>,
}

/// A camera that fits no other as well as the others fit each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Doubt {
    /// The camera, by its index.
    pub camera: usize,
    /// Whether it is in doubt over what moves alone: its frames may be early or late. Else its pose may be wrong. (A pose that is
    /// off along a plane that fills the picture shows only in what stands out of it, which may be what moves.)
    pub over_time: bool,
    /// How far the camera that fits it best is off, in footprints.
    pub footprints: f32,
    /// How far the other cameras are off that fit each other best.
    pub usual_footprints: f32,
}

impl Doubt {
    /// In words, for a camera of this name.
    #[must_use]
    pub fn sentence(&self, name: &str) -> String {
        let (own, usual) = (self.footprints, self.usual_footprints);
        let compared = format!("{own:.1} footprints where it fits best, others {usual:.2}");
        if self.over_time {
            format!(
                "camera '{name}' agrees with no other about what moves ({compared}); its frames may be early or late, or its pose off where little stands out"
            )
        } else {
            format!(
                "camera '{name}' agrees with no other about where things are ({compared}); check its pose and lens"
            )
        }
    }
}

/// Less is no reason to doubt a camera, in footprints. Correct captures stay below a tenth in all but one or two pairs; a camera
/// that is turned by half a pixel reaches a third in all.
const DOUBTFUL_FOOTPRINTS: f32 = 0.25;

/// Nor is less than so many times what others are off.
const DOUBTFUL_RATIO: f32 = 8.0;

/// Distances and colors while they are gathered.
#[derive(Default)]
struct Readings {
    footprints: Spread,
    color_steps: Spread,
}

impl Readings {
    fn add(&mut self, other: &Self) {
        self.footprints.add(&other.footprints);
        self.color_steps.add(&other.color_steps);
    }

    fn residual(&self) -> Option<Residual> {
        let samples = self.footprints.total();
        (samples >= MIN_SAMPLES).then(|| Residual {
            samples,
            median_footprints: self.footprints.within(0.5),
            most_footprints: self.footprints.within(MOST),
            median_color_steps: self.color_steps.within(0.5),
        })
    }
}

/// Gathers residuals while preprocessing runs.
pub(super) struct Residuals<'a> {
    rig: &'a Rig<'a>,
    frames: usize,
    /// `[source * cameras + target]`: of samples of all frames, and of others.
    readings: Vec<[Readings; 2]>,
}

impl<'a> Residuals<'a> {
    pub(super) fn new(rig: &'a Rig<'a>, frames: usize) -> Self {
        let pairs = rig.cameras().len().pow(2);
        Self { rig, frames, readings: (0..pairs).map(|_| <[Readings; 2]>::default()).collect() }
    }

    /// Compares what is the same over all frames.
    ///
    /// # Errors
    /// `Cancelled`.
    pub(super) fn add_lasting(&mut self, layers: &[Layer], job: &Job) -> Result<()> {
        self.add(layers, (0, ROOT..=ROOT, 1), job)
    }

    /// Compares everything else at `frame`, where this is one of the frames to look at and `layers` hold all its samples.
    ///
    /// # Errors
    /// `Cancelled`.
    pub(super) fn add_moving(&mut self, frame: usize, layers: &[Layer], job: &Job) -> Result<()> {
        if !frame.is_multiple_of(self.frames.div_ceil(FRAMES).max(1)) {
            return Ok(());
        }
        self.add(layers, (1, ROOT + 1..=NO_SAMPLE - 1, 2), job)
    }

    fn add(
        &mut self,
        layers: &[Layer],
        (kind, levels, density): (usize, RangeInclusive<Level>, usize),
        job: &Job,
    ) -> Result<()> {
        let rig = self.rig;
        let asked =
            (LATTICE_SAMPLES * FEW_CAMERAS / layers.len()).clamp(FEWEST_LATTICE_SAMPLES, LATTICE_SAMPLES);
        self.readings.par_iter_mut().enumerate().try_for_each(|(pair, readings)| {
            job.check()?;
            let [source, target] = [pair / layers.len(), pair % layers.len()];
            if source != target {
                let compare = Compare {
                    registration: rig.registration(source, target),
                    source: &layers[source],
                    target: &layers[target],
                    levels: levels.clone(),
                    samples: asked * density * density,
                };
                readings[kind].add(&simd::run(compare));
            }
            Ok(())
        })
    }

    /// `[source][target]`.
    pub(super) fn finish(self) -> Vec<Vec<PairResiduals>> {
        let cameras = self.rig.cameras().len();
        let of_pair = |[lasting, moving]: [Readings; 2]| PairResiduals {
            lasting: lasting.residual(),
            moving: moving.residual(),
        };
        let mut pairs = self.readings.into_iter().map(of_pair);
        (0..cameras).map(|_| pairs.by_ref().take(cameras).collect()).collect()
    }
}

/// The samples of some levels of one camera against what another saw.
struct Compare<'a> {
    registration: &'a Registration,
    source: &'a Layer,
    target: &'a Layer,
    levels: RangeInclusive<Level>,
    /// Samples to compare, about, were all pixels of these levels.
    samples: usize,
}

impl Work for Compare<'_> {
    type Output = Readings;

    #[inline(always)]
    fn run(self) -> Readings {
        let Self { registration, source, target, levels, samples } = self;
        let mut readings = Readings::default();
        if target.facets.is_empty() {
            return readings;
        }
        let limits = SameSurface::geometry_within(HIDING_FOOTPRINTS);
        let (width, height) = (source.width, source.height());
        let step = (width * height / samples).isqrt().max(1);
        for row in (0..height).step_by(step) {
            // Neighboring rows begin elsewhere, so that no column of the picture is left out.
            let first = row / step % step * LANES;
            for column in (first..width).step_by(step * LANES) {
                let lanes = lanes_at(source, (column, row), |level| levels.contains(&level));
                if lanes == 0 {
                    continue;
                }
                let block = Block::<LANES>::new(source, column, row, lanes);
                let carried = registration.carry(&block, target.width);
                let mut wanted = [0; LANES];
                for lane in 0..LANES {
                    let counts = (block.rank[lane] & MIXED == 0) & (block.inverse_depth[lane] > 0.0);
                    wanted[lane] = u32::from(counts & (carried.bits[lane] & IN_VIEW != 0));
                }
                let mut needs = Needs::new(0.0);
                let answers = registration.compare_telling::<LANES, true>(
                    source, target, &block, &carried, &limits, wanted, &mut needs,
                );
                for lane in (0..LANES).filter(|lane| wanted[*lane] != 0) {
                    match answers.outcome(lane) {
                        Outcome::Occluded | Outcome::NoDepth | Outcome::OutsideView | Outcome::Behind => {}
                        Outcome::SeesPast | Outcome::NormalDiffers => {
                            readings.footprints.count(needs.depth[lane]);
                        }
                        Outcome::ColorDiffers | Outcome::Seam | Outcome::Same(_) => {
                            readings.footprints.count(needs.depth[lane]);
                            readings.color_steps.count(needs.color[lane]);
                        }
                    }
                }
            }
        }
        readings
    }
}

/// The cameras that fit no other as well as the others fit each other; see [`PairResiduals`] for `pairs`. Of two cameras nobody
/// can tell which one is wrong: both are named.
#[must_use]
pub fn doubts(pairs: &[Vec<PairResiduals>]) -> Vec<Doubt> {
    let lasting = doubts_over(pairs, |pair| pair.lasting);
    let moving = doubts_over(pairs, |pair| pair.moving).into_iter().filter_map(|(camera, own, usual)| {
        let has_wrong_pose = lasting.iter().any(|(other, ..)| *other == camera);
        (!has_wrong_pose).then_some(Doubt {
            camera,
            over_time: true,
            footprints: own,
            usual_footprints: usual,
        })
    });
    let poses = lasting.iter().map(|&(camera, footprints, usual_footprints)| Doubt {
        camera,
        over_time: false,
        footprints,
        usual_footprints,
    });
    poses.chain(moving).collect()
}

/// Camera, how far it is off where it fits best, and how far others are that fit each other.
fn doubts_over(
    pairs: &[Vec<PairResiduals>],
    of: impl Fn(&PairResiduals) -> Option<Residual>,
) -> Vec<(usize, f32, f32)> {
    let cameras = pairs.len();
    let off = |a: usize, b: usize| {
        let both = [of(&pairs[a][b]), of(&pairs[b][a])];
        both.into_iter().flatten().map(|residual| residual.most_footprints).reduce(f32::max)
    };
    let best = |camera: usize, without: Option<usize>| {
        let others = (0..cameras).filter(|other| *other != camera && Some(*other) != without);
        others.filter_map(|other| off(camera, other)).reduce(f32::min)
    };
    let doubt = |camera: usize| {
        let own = best(camera, None)?;
        let others = (0..cameras).filter(|other| *other != camera);
        let mut usual: Vec<f32> = others.filter_map(|other| best(other, Some(camera))).collect();
        usual.sort_unstable_by(f32::total_cmp);
        let usual = usual.get(usual.len() / 2).copied().unwrap_or(0.0);
        (own > DOUBTFUL_FOOTPRINTS && own > DOUBTFUL_RATIO * usual).then_some((camera, own, usual))
    };
    (0..cameras).filter_map(doubt).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Residuals of cameras, each as far off as its entry says from all others.
    fn pairs(off: &[f32], moving: &[f32]) -> Vec<Vec<PairResiduals>> {
        let residual = |off: f32| Residual {
            samples: 1000,
            median_footprints: off / 2.0,
            most_footprints: off,
            median_color_steps: 1.0,
        };
        let pair = |a: usize, b: usize| PairResiduals {
            lasting: (a != b).then(|| residual(off[a].max(off[b]))),
            moving: (a != b).then(|| residual(moving[a].max(moving[b]))),
        };
        (0..off.len()).map(|a| (0..off.len()).map(|b| pair(a, b)).collect()).collect()
    }

    #[test]
    fn the_camera_that_fits_no_other_is_doubted_and_those_it_does_not_fit_are_not() {
        let found = doubts(&pairs(&[0.01, 0.9, 0.02, 0.01], &[0.1, 1.2, 0.1, 0.1]));
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].camera, found[0].over_time, found[0].footprints), (1, false, 0.9));
        let found = doubts(&pairs(&[0.01; 4], &[0.02, 0.01, 0.02, 0.6]));
        assert_eq!(found.iter().map(|d| (d.camera, d.over_time)).collect::<Vec<_>>(), [(3, true)]);
    }

    #[test]
    fn where_all_are_off_alike_nobody_is_doubted_and_of_two_cameras_both_are() {
        assert!(doubts(&pairs(&[0.8, 0.9, 1.1], &[0.8, 0.9, 1.1])).is_empty());
        let found = doubts(&pairs(&[0.9, 0.9], &[0.1, 0.1]));
        assert_eq!(found.iter().map(|doubt| doubt.camera).collect::<Vec<_>>(), [0, 1]);
    }
}
