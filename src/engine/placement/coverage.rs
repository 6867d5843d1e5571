//! How finely the cameras chosen so far show each surfel.

use glam::DVec3;
use rayon::prelude::*;

use super::depth_map::seen_from;
use super::stands::{poses, targets, turned};
use super::surfels::{FINEST, Moment, Surfel};
use crate::capture::{Camera, CoveredSet, Intrinsics};
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::ViewingRays;
use crate::settings::PruningSettings;

/// A place may be this much nearer to a surface than any coarse camera is.
const NEARER: f64 = 0.5;

/// Angles by which chosen cameras are turned, degrees, one after the other.
const TURNS: [f64; 3] = [8.0, 3.0, 1.0];

/// How often all chosen cameras are exchanged and turned, each beside the others, at most.
const ROUNDS: usize = 2;

/// Candidates that are looked at together.
const AT_ONCE: usize = 128;

/// A camera that was placed.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedCamera {
    /// Its pose and lens. The principal point is in the middle.
    pub camera: Camera,
    /// The share of all surface that it adds to the cameras before it, 0 to 1; a surface counts in proportion to the rate asked for.
    pub adds: f64,
    /// The share that is seen with it and those before it.
    pub seen: f64,
}

/// A place, and what is seen from it in all directions.
struct Place {
    eye: DVec3,
    /// For each moment the indices of surfels, ascending.
    seen: Vec<Vec<u32>>,
    /// Distance to the nearest surfel, world units.
    clearance: f64,
}

/// A camera at one of the places.
#[derive(Clone)]
struct Candidate {
    place: usize,
    camera: Camera,
}

/// All cameras that may be chosen, and what the chosen ones show.
pub(super) struct Coverage<'a> {
    moments: &'a [Moment],
    /// Every how many surfels one is counted.
    every: usize,
    lens: Intrinsics,
    up_in_world: DVec3,
    places: Vec<Place>,
    candidates: Vec<Candidate>,
    /// What each candidate adds to nothing: it never adds more.
    alone: Vec<u64>,
    is_empty: bool,
    /// Moment by moment, the best value of each surfel: 0 unseen, to [`FINEST`].
    best: Vec<Vec<u8>>,
    /// What all surfels together count for.
    total: f64,
}

impl<'a> Coverage<'a> {
    /// For moments that hold a surfel; one of `every` surfels is counted, at least 1.
    pub(super) fn new(moments: &'a [Moment], every: usize, lens: Intrinsics, up_in_world: DVec3) -> Self {
        let mut coverage = Self {
            moments,
            every,
            lens,
            up_in_world,
            places: Vec::new(),
            candidates: Vec::new(),
            alone: Vec::new(),
            is_empty: true,
            best: Vec::new(),
            total: 0.0,
        };
        coverage.forget();
        let weights = coverage.valued().map(|(surfel, _)| u64::from(surfel.weight));
        coverage.total = weights.sum::<u64>() as f64 * f64::from(FINEST);
        coverage
    }

    /// From now on nothing is shown.
    fn forget(&mut self) {
        self.best = self.moments.iter().map(|moment| vec![0; moment.surfels.len()]).collect();
        self.is_empty = true;
    }

    /// Finds what is seen from further places.
    ///
    /// # Errors
    /// `Cancelled`.
    pub(super) fn look_from(&mut self, eyes: Vec<DVec3>, job: &Job) -> Result<()> {
        let look = |eye: DVec3| {
            job.check()?;
            let seen =
                self.moments.iter().map(|moment| seen_from(&moment.surfels, self.every, eye)).collect();
            let surfels = self.moments.iter().flat_map(|moment| &moment.surfels);
            let nearest = surfels.map(|surfel| surfel.point_in_world.distance_squared(eye));
            let clearance = nearest.fold(f64::INFINITY, f64::min).sqrt();
            job.advance(1);
            Ok(Place { eye, seen, clearance })
        };
        let found = eyes.into_par_iter().map(look).collect::<Result<Vec<Place>>>()?;
        self.places.extend(found);
        Ok(())
    }

    /// Leaves out places that are much nearer to a surface than the first `own`, which cameras stood at.
    pub(super) fn leave_out_places_too_near(&mut self, own: usize) {
        let nearest = self.places[..own].iter().map(|place| place.clearance).fold(f64::INFINITY, f64::min);
        let mut nth = 0;
        self.places.retain(|place| {
            nth += 1;
            nth <= own || place.clearance >= NEARER * nearest
        });
    }

    /// Makes cameras at all places the candidates, and gives their number. `cameras` stand at the first places: where they `may_stay`
    /// they come first, else these places are left out.
    pub(super) fn point_everywhere(&mut self, cameras: &[Camera], may_stay: bool, middle: DVec3) -> usize {
        let targets = targets(cameras, middle);
        let staying = if may_stay { cameras } else { &[] };
        let others = cameras.len() - staying.len();
        let own = staying.iter().enumerate().map(|(place, camera)| Candidate {
            place,
            camera: Camera { intrinsics: self.lens, ..camera.clone() },
        });
        let posed = self.places.iter().enumerate().skip(others).flat_map(|(place, at)| {
            let poses = poses(at.eye, &targets, self.lens, self.up_in_world);
            poses.into_iter().map(move |camera| Candidate { place, camera })
        });
        self.candidates = own.chain(posed).collect();
        self.alone = self.candidates.par_iter().map(|candidate| self.gain(candidate)).collect();
        self.candidates.len()
    }

    /// Calls `with` for each surfel that a candidate shows: its moment, its index and its value.
    fn each_shown(&self, candidate: &Candidate, mut with: impl FnMut(usize, usize, u8)) {
        let Candidate { place, camera } = candidate;
        let settings = PruningSettings::default();
        let rays = ViewingRays::new(camera);
        let camera_from_world = camera.camera_from_world();
        let (width, height) = (f64::from(camera.intrinsics.width), f64::from(camera.intrinsics.height));
        for (moment, seen) in self.places[*place].seen.iter().enumerate() {
            for &index in seen {
                let surfel = &self.moments[moment].surfels[index as usize];
                let in_camera = camera_from_world.transform_point3(surfel.point_in_world);
                let Some(at) = camera.intrinsics.project(in_camera) else { continue };
                if at.x >= 0.0 && at.y >= 0.0 && at.x < width && at.y < height {
                    let value = surfel.fineness(&rays, camera, in_camera.z, &settings);
                    with(moment, index as usize, value);
                }
            }
        }
    }

    /// What a candidate adds.
    fn gain(&self, candidate: &Candidate) -> u64 {
        let mut gain = 0;
        self.each_shown(candidate, |moment, index, value| {
            let more = value.saturating_sub(self.best[moment][index]);
            gain += u64::from(more) * u64::from(self.moments[moment].surfels[index].weight);
        });
        gain
    }

    fn add(&mut self, candidate: &Candidate) {
        let mut best = std::mem::take(&mut self.best);
        self.each_shown(candidate, |moment, index, value| {
            best[moment][index] = best[moment][index].max(value);
        });
        self.best = best;
        self.is_empty = false;
    }

    /// The surfels with the best value of each.
    fn valued(&self) -> impl Iterator<Item = (&Surfel, u8)> {
        let values = self.moments.iter().zip(&self.best);
        values.flat_map(|(moment, best)| moment.surfels.iter().zip(best.iter().copied()).step_by(self.every))
    }

    /// The share that is shown.
    fn shown(&self) -> f64 {
        let shown = self.valued().map(|(surfel, value)| u64::from(surfel.weight) * u64::from(value));
        shown.sum::<u64>() as f64 / self.total
    }

    /// Exchanges each of the chosen candidates for the one that adds most beside the others, and turns it, as long as that helps.
    pub(super) fn improved(&mut self, chosen: &[usize]) -> Vec<Camera> {
        let mut cameras: Vec<Candidate> =
            chosen.iter().map(|index| self.candidates[*index].clone()).collect();
        let mut most_first: Vec<usize> = (0..self.candidates.len()).collect();
        most_first.sort_by_key(|index| std::cmp::Reverse(self.alone[*index]));
        for _ in 0..ROUNDS {
            let mut is_better = false;
            for nth in 0..cameras.len() {
                self.forget();
                for (_, other) in cameras.iter().enumerate().filter(|(other, _)| *other != nth) {
                    self.add(other);
                }
                let exchanged = self.best_exchange(&cameras[nth], &most_first);
                let turned = self.best_turned(&exchanged);
                is_better |= turned.camera != cameras[nth].camera;
                cameras[nth] = turned;
            }
            if !is_better {
                break;
            }
        }
        self.forget();
        cameras.into_iter().map(|candidate| candidate.camera).collect()
    }

    /// The candidate that adds most, or the given one where none adds more. Those that add less to nothing are not looked at.
    fn best_exchange(&self, candidate: &Candidate, most_first: &[usize]) -> Candidate {
        let mut best = (self.gain(candidate), candidate);
        for some in most_first.chunks(AT_ONCE) {
            if self.alone[some[0]] <= best.0 {
                break;
            }
            let gains: Vec<u64> = some.par_iter().map(|index| self.gain(&self.candidates[*index])).collect();
            for (index, gain) in some.iter().zip(gains) {
                if gain > best.0 {
                    best = (gain, &self.candidates[*index]);
                }
            }
        }
        best.1.clone()
    }

    /// Cameras that stand at the places, one each, by what each adds. All of them are shown afterwards.
    pub(super) fn in_order(&mut self, cameras: Vec<Camera>) -> Vec<PlacedCamera> {
        let candidates = cameras.into_iter().enumerate();
        let mut left: Vec<Candidate> =
            candidates.map(|(place, camera)| Candidate { place, camera }).collect();
        let mut placed: Vec<PlacedCamera> = Vec::new();
        self.forget();
        while let Some(most) = (0..left.len()).rev().max_by_key(|nth| self.gain(&left[*nth])) {
            let candidate = left.remove(most);
            let adds = self.gain(&candidate) as f64 / self.total;
            self.add(&candidate);
            placed.push(PlacedCamera { camera: candidate.camera, adds, seen: self.shown() });
        }
        placed
    }

    fn best_turned(&self, candidate: &Candidate) -> Candidate {
        let mut best = (self.gain(candidate), candidate.clone());
        for degrees in TURNS {
            let angle = f64::to_radians(degrees);
            loop {
                let turns = [[angle, 0.0], [-angle, 0.0], [0.0, angle], [0.0, -angle]];
                let tried: Vec<(u64, Candidate)> = turns
                    .into_par_iter()
                    .map(|turn| {
                        let camera = turned(&best.1.camera, self.up_in_world, turn);
                        let candidate = Candidate { place: best.1.place, camera };
                        (self.gain(&candidate), candidate)
                    })
                    .collect();
                match tried.into_iter().rev().max_by_key(|(gain, _)| *gain) {
                    Some(more) if more.0 > best.0 => best = more,
                    _ => break,
                }
            }
        }
        best.1
    }

    /// The share of surface that is not shown at all.
    pub(super) fn unseen_share(&self) -> f64 {
        let unseen = self.valued().filter(|(_, value)| *value == 0);
        unseen.map(|(surfel, _)| u64::from(surfel.weight)).sum::<u64>() as f64 * f64::from(FINEST)
            / self.total
    }

    /// The surfels that are not shown at all; what stands still over all moments once.
    pub(super) fn unseen_surfels(&self) -> Vec<Surfel> {
        let mut known = std::collections::HashSet::new();
        let unseen = self.valued().filter(|(_, value)| *value == 0).map(|(surfel, _)| *surfel);
        unseen.filter(|surfel| known.insert(surfel.point_in_world.to_array().map(f64::to_bits))).collect()
    }
}

impl CoveredSet for Coverage<'_> {
    fn added_by(&self, view: usize) -> u64 {
        if self.is_empty { self.alone[view] } else { self.gain(&self.candidates[view]) }
    }

    fn take(&mut self, view: usize) {
        let candidate = self.candidates[view].clone();
        self.add(&candidate);
    }
}
