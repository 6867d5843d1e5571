//! Pruning (the paper, §3.2): of all samples of one surface point the best-sampled one stays.
//!
//! Source: Interactive Dynamic Environments Using Image-Based Modeling and Rendering, §3.2, "keeping those pixels that have
//! the highest sampling rate". What differs: **coverage is guaranteed**. A sample is dropped only if a sample that is
//! *kept* stands for it. Pairwise comparison alone does not give that: A may be dropped for B, and B for C, where C does
//! not see A's point. Here every sample waits until all better samples of its point are decided; it is dropped if one of
//! them was kept, and kept otherwise. "Better" is a total order (rank, then camera index), so the waiting has no cycles
//! and the answer is the same whatever order or thread it is worked out in.
//!
//! ```text
//! candidates of p = samples of other cameras that show p's point and are better than p
//! p is dropped  ⇔  some candidate is kept
//! ```

use std::sync::atomic::{AtomicU8, Ordering};

use rayon::prelude::*;

use super::layer::{Layer, Level, MIXED};
use super::registration::{Outcome, Registration, SameSurface};
use super::{Rule, Verdict};
use crate::capture::Camera;
use crate::error::Result;
use crate::job::Job;
use crate::settings::{MixedPixels, PruningMethod, Settings};

/// No sample at the pixel that could stand for another.
pub const ABSENT: u8 = 0;
/// Waiting for better samples to be decided.
const UNDECIDED: u8 = 1;
/// Stays.
pub const KEPT: u8 = 2;
/// Was dropped.
pub const DROPPED: u8 = 3;

/// Rows that one task works on.
const BAND_ROWS: usize = 16;

/// All cameras and every way between two of them.
pub struct Rig<'a> {
    cameras: &'a [Camera],
    /// `[source * cameras + target]`.
    registrations: Vec<Registration>,
}

impl<'a> Rig<'a> {
    /// All pairs of `cameras`.
    #[must_use]
    pub fn new(cameras: &'a [Camera]) -> Self {
        let registrations = cameras
            .iter()
            .flat_map(|source| cameras.iter().map(move |target| Registration::new(source, target)))
            .collect();
        Self { cameras, registrations }
    }

    /// From camera `source` to camera `target`.
    #[must_use]
    pub fn registration(&self, source: usize, target: usize) -> &Registration {
        &self.registrations[source * self.cameras.len() + target]
    }

    /// The cameras.
    #[must_use]
    pub fn cameras(&self) -> &'a [Camera] {
        self.cameras
    }
}

/// The verdicts on one camera's samples of one level.
#[derive(Clone, Debug, Default)]
pub struct Decided {
    /// Pixels that were decided, `y * width + x`, ascending.
    pub pixels: Vec<u32>,
    /// One verdict per pixel.
    pub verdicts: Vec<Verdict>,
}

/// Whether each pixel of each camera holds a kept sample: [`ABSENT`], [`KEPT`] or [`DROPPED`].
pub type Statuses = Vec<Vec<AtomicU8>>;

/// Statuses in which nothing is decided yet.
#[must_use]
pub fn no_statuses(layers: &[Layer]) -> Statuses {
    layers.iter().map(|layer| layer.level.iter().map(|_| AtomicU8::new(ABSENT)).collect()).collect()
}

/// Decides every sample of level `decide`; samples of other levels take part as `statuses` says and stay as they are.
///
/// Levels are decided in ascending order, from the span of all frames down to the frame.
///
/// # Errors
/// `Cancelled`.
pub fn prune(
    rig: &Rig<'_>,
    layers: &[Layer],
    statuses: &Statuses,
    decide: Level,
    settings: &Settings,
    job: &Job,
) -> Result<Vec<Decided>> {
    let pass = Pass { rig, layers, statuses, decide, settings, limits: SameSurface::new(settings) };
    layers.par_iter().zip(statuses).for_each(|(layer, statuses)| {
        for (level, status) in layer.level.iter().zip(statuses) {
            if *level == decide {
                status.store(UNDECIDED, Ordering::Relaxed);
            }
        }
    });
    if settings.pruning.mixed_pixels == MixedPixels::Drop {
        pass.drop_mixed();
    }
    let bands: Vec<(usize, usize)> = layers
        .iter()
        .enumerate()
        .flat_map(|(camera, layer)| (0..layer.height()).step_by(BAND_ROWS).map(move |row| (camera, row)))
        .collect();
    let mut bands: Vec<Band> = bands
        .into_par_iter()
        .map(|(camera, first_row)| {
            job.check()?;
            Ok(pass.find_candidates(camera, first_row))
        })
        .collect::<Result<_>>()?;
    loop {
        job.check()?;
        let waiting: usize = bands.par_iter_mut().map(|band| pass.settle(band)).sum();
        if waiting == 0 {
            break;
        }
    }
    let verdicts: Vec<Vec<Verdict>> = bands.par_iter().map(|band| pass.verdicts(band)).collect();
    let mut decided: Vec<Decided> = layers.iter().map(|_| Decided::default()).collect();
    for (band, verdicts) in bands.into_iter().zip(verdicts) {
        decided[band.camera].pixels.extend(band.pixels);
        decided[band.camera].verdicts.extend(verdicts);
    }
    Ok(decided)
}

struct Pass<'a> {
    rig: &'a Rig<'a>,
    layers: &'a [Layer],
    statuses: &'a Statuses,
    decide: Level,
    settings: &'a Settings,
    limits: SameSurface,
}

/// Some rows of one camera: the samples to decide and who could stand for each.
struct Band {
    camera: usize,
    pixels: Vec<u32>,
    /// `candidates[starts[i]..starts[i + 1]]` belong to `pixels[i]`.
    starts: Vec<u32>,
    candidates: Vec<Candidate>,
    /// Whether any other camera shows the point at all.
    seen_elsewhere: Vec<bool>,
    /// Indices into `pixels` that still wait.
    waiting: Vec<u32>,
}

#[derive(Clone, Copy)]
struct Candidate {
    camera: u16,
    pixel: u32,
}

impl Pass<'_> {
    fn status(&self, camera: usize, pixel: u32) -> u8 {
        self.statuses[camera][pixel as usize].load(Ordering::Relaxed)
    }

    fn drop_mixed(&self) {
        for (layer, statuses) in self.layers.iter().zip(self.statuses) {
            for ((level, rank), status) in layer.level.iter().zip(&layer.rank).zip(statuses) {
                if *level == self.decide && *rank != u32::MAX && rank & MIXED != 0 {
                    status.store(DROPPED, Ordering::Relaxed);
                }
            }
        }
    }

    fn find_candidates(&self, camera: usize, first_row: usize) -> Band {
        let layer = &self.layers[camera];
        let rows = first_row..(first_row + BAND_ROWS).min(layer.height());
        let mut band = Band {
            camera,
            pixels: Vec::new(),
            starts: vec![0],
            candidates: Vec::new(),
            seen_elsewhere: Vec::new(),
            waiting: Vec::new(),
        };
        let pruning = self.settings.pruning.method != PruningMethod::Off;
        for y in rows {
            for x in 0..layer.width {
                let pixel = y * layer.width + x;
                if layer.level[pixel] != self.decide {
                    continue;
                }
                let undecided = self.status(camera, pixel as u32) == UNDECIDED;
                let seen = undecided && pruning && self.ask_the_others(camera, x, y, &mut band.candidates);
                if undecided {
                    band.waiting.push(band.pixels.len() as u32);
                }
                band.pixels.push(pixel as u32);
                band.starts.push(band.candidates.len() as u32);
                band.seen_elsewhere.push(seen);
            }
        }
        band
    }

    /// Appends the better samples of the point; whether any other camera shows it at all.
    fn ask_the_others(&self, camera: usize, x: usize, y: usize, candidates: &mut Vec<Candidate>) -> bool {
        let layer = &self.layers[camera];
        let rank = layer.rank[y * layer.width + x];
        let mut seen = false;
        for other in 0..self.layers.len() {
            if other == camera {
                continue;
            }
            let target = &self.layers[other];
            let registration = self.rig.registration(camera, other);
            let Outcome::Same(found) = registration.test(layer, target, x, y, &self.limits) else { continue };
            let foreign = target.level[found as usize] != self.decide;
            if foreign && !self.settings.pruning.across_spans {
                continue;
            }
            if matches!(self.status(other, found), ABSENT | DROPPED) {
                continue;
            }
            seen = true;
            if (target.rank[found as usize], other) < (rank, camera) {
                candidates.push(Candidate { camera: other as u16, pixel: found });
            }
        }
        seen
    }

    /// Decides what can be decided; how many samples still wait.
    fn settle(&self, band: &mut Band) -> usize {
        let mut waiting = std::mem::take(&mut band.waiting);
        waiting.retain(|&index| {
            let mut verdict = KEPT;
            for candidate in band.candidates_of(index as usize) {
                match self.status(candidate.camera as usize, candidate.pixel) {
                    KEPT => {
                        verdict = DROPPED;
                        break;
                    }
                    UNDECIDED => verdict = UNDECIDED,
                    _ => {}
                }
            }
            let pixel = band.pixels[index as usize] as usize;
            self.statuses[band.camera][pixel].store(verdict, Ordering::Relaxed);
            verdict == UNDECIDED
        });
        band.waiting = waiting;
        band.waiting.len()
    }

    fn verdicts(&self, band: &Band) -> Vec<Verdict> {
        (0..band.pixels.len()).map(|index| self.verdict(band, index)).collect()
    }

    fn verdict(&self, band: &Band, index: usize) -> Verdict {
        let pixel = band.pixels[index];
        let rank = self.layers[band.camera].rank[pixel as usize];
        if self.status(band.camera, pixel) == KEPT {
            let rule = if self.settings.pruning.method == PruningMethod::Off {
                Rule::PruningOff
            } else if !band.candidates_of(index).is_empty() {
                Rule::Coverage
            } else if band.seen_elsewhere[index] {
                Rule::BestRate
            } else {
                Rule::OnlyWitness
            };
            return Verdict::without_witness(rule);
        }
        let witness = band
            .candidates_of(index)
            .iter()
            .filter(|candidate| self.status(candidate.camera as usize, candidate.pixel) == KEPT)
            .min_by_key(|candidate| (self.rank_of(**candidate), candidate.camera));
        let Some(witness) = witness else {
            return Verdict::without_witness(Rule::MixedDropped);
        };
        let witness_rank = self.rank_of(*witness);
        let rule = if self.settings.pruning.method == PruningMethod::FirstCamera {
            Rule::LaterCamera
        } else if rank & MIXED != 0 && witness_rank & MIXED == 0 {
            Rule::MixedYields
        } else if witness_rank == rank {
            Rule::Tie
        } else {
            Rule::LowerRate
        };
        Verdict {
            rule,
            witness_level: self.layers[witness.camera as usize].level[witness.pixel as usize],
            witness_camera: witness.camera,
            witness_pixel: witness.pixel,
        }
    }

    fn rank_of(&self, candidate: Candidate) -> u32 {
        self.layers[candidate.camera as usize].rank[candidate.pixel as usize]
    }
}

impl Band {
    fn candidates_of(&self, index: usize) -> &[Candidate] {
        &self.candidates[self.starts[index] as usize..self.starts[index + 1] as usize]
    }
}
