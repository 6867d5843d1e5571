//! Sixteen samples at a time against every other camera: who shows the same point, and who of them sampled it best?

use std::ops::Range;

use super::pass::{Candidate, Pass};
use crate::capture::INVALID_INVERSE_DEPTH;
use crate::preprocess::layers::{CameraLayer, Ranks};
use crate::preprocess::registration::{
    CameraPairs, Carried, IN_VIEW, LANES, PixelRun, Registration, SameSurface, lanes_of,
};
use crate::preprocess::temporal::{NO_SAMPLE, SpanLevel};
use crate::simd;

/// Another camera that may show something of a band.
pub(crate) struct OtherCamera<'a> {
    pub(crate) camera: usize,
    pub(crate) registration: &'a Registration,
    pub(crate) limits: SameSurface,
    /// For each sixteen columns of the band.
    pub(crate) may_see: Vec<bool>,
    /// Samples of the band that it knew more about than those asked before. Who does so is asked early: then the others need
    /// not be heard. No result depends on the order.
    pub(crate) told: u32,
}

/// The other cameras that may see something of a camera's rows, of whose sixteen columns each some `lanes` take part.
#[inline(always)]
pub(crate) fn rivals<'a>(
    rig: &'a CameraPairs<'_>,
    layers: &[CameraLayer],
    (camera, rows): (usize, Range<usize>),
    lanes: &[u32],
    limits: impl Fn(usize) -> SameSurface,
) -> Vec<OtherCamera<'a>> {
    let layer = &layers[camera];
    let ends = [rows.start, rows.end - 1];
    let columns = layer.width.div_ceil(LANES);
    let bounds: Vec<Option<[f32; 2]>> = (0..columns)
        .map(|at| {
            let any = lanes.iter().skip(at).step_by(columns).any(|lanes| *lanes != 0);
            any.then(|| depth_bounds(layer, at * LANES, rows.clone()))
        })
        .collect();
    let whole = bounds
        .iter()
        .flatten()
        .fold([f32::INFINITY, 0.0_f32], |all, block| [all[0].min(block[0]), all[1].max(block[1])]);
    (0..layers.len())
        .filter(|&other| other != camera && !layers[other].facets.is_empty())
        .filter_map(|other| {
            let registration = rig.registration(camera, other);
            registration.may_see([0, layer.width - 1], ends, whole).then(|| OtherCamera {
                camera: other,
                registration,
                limits: limits(other),
                told: 0,
                may_see: bounds
                    .iter()
                    .enumerate()
                    .map(|(at, bounds)| {
                        let columns = [at * LANES, (at * LANES + LANES).min(layer.width) - 1];
                        bounds.is_some_and(|bounds| registration.may_see(columns, ends, bounds))
                    })
                    .collect(),
            })
        })
        .collect()
}

/// Those of sixteen pixels from `place` on whose samples' level is asked for.
#[inline(always)]
pub(crate) fn lanes_at(layer: &CameraLayer, place: (usize, usize), holds: impl Fn(SpanLevel) -> bool) -> u32 {
    let levels = lanes_of::<_, LANES>(&layer.level, layer.width, place, NO_SAMPLE);
    let mut lanes = 0;
    for lane in 0..LANES {
        lanes |= u32::from(holds(levels[lane])) << lane;
    }
    lanes
}

/// The smallest and largest inverse depth of the samples in sixteen columns of some rows; the smallest is larger where there
/// is none.
#[inline(always)]
fn depth_bounds(layer: &CameraLayer, column: usize, rows: Range<usize>) -> [f32; 2] {
    let (mut smallest, mut largest) = ([f32::INFINITY; LANES], [0.0_f32; LANES]);
    for row in rows {
        let depths =
            lanes_of::<_, LANES>(&layer.inverse_depth, layer.width, (column, row), INVALID_INVERSE_DEPTH);
        for lane in 0..LANES {
            let w = depths[lane];
            smallest[lane] = smallest[lane].min(if w < 0.0 { f32::INFINITY } else { w });
            largest[lane] = largest[lane].max(w);
        }
    }
    [smallest.iter().copied().fold(f32::INFINITY, f32::min), largest.iter().copied().fold(0.0, f32::max)]
}

/// A block with something to decide: its place in the row, its lanes and samples, and how its contest stands.
pub(crate) struct PendingRun {
    pub(crate) at: usize,
    pub(crate) lanes: u32,
    pub(crate) block: PixelRun,
    pub(crate) contest: BestCandidates,
}

/// Where the samples of a block lie in a rival's picture, and which of them are to be compared with what it saw.
pub(crate) struct Way {
    carried: Carried,
    wanted: [u32; LANES],
}

impl Way {
    pub(crate) const NOWHERE: Self = Self { carried: Carried::NOWHERE, wanted: [0; LANES] };
}

/// Holds a row of blocks of `camera` against a rival. `ways` are scratch, one for each block. The whole row is carried before
/// any of it is compared: so many fetches from memory are under way at once.
#[inline(always)]
pub(crate) fn hold_row(
    pass: &Pass<'_>,
    camera: usize,
    entries: &mut [PendingRun],
    rival: &mut OtherCamera<'_>,
    ways: &mut [Way],
) {
    let target = &pass.layers[rival.camera];
    for (entry, way) in entries.iter().zip(&mut *ways) {
        way.carried.bits = [0; LANES];
        if rival.may_see[entry.at] {
            way.carried = rival.registration.carry(&entry.block, target.width);
            way.carried.prefetch_ranks(target);
        }
    }
    for (entry, way) in entries.iter().zip(&mut *ways) {
        way.wanted = entry.contest.wanted(target, rival.camera, &way.carried);
        if any(&way.wanted) {
            way.carried.prefetch(target);
        }
    }
    for (entry, way) in entries.iter_mut().zip(&*ways) {
        if any(&way.wanted) {
            rival.told += entry.contest.hold(pass, camera, &entry.block, rival, &way.carried, way.wanted);
        }
    }
}

#[inline(always)]
fn any(lanes: &[u32; LANES]) -> bool {
    simd::joined(lanes) != 0
}

/// How the contest went for each sample of a block: the best sample so far, at first its own, by both rate models.
pub(crate) struct BestCandidates {
    own_camera: u32,
    rank: [u32; LANES],
    camera: [u32; LANES],
    level: [u32; LANES],
    pixel: [u32; LANES],
    other_rank: [u32; LANES],
    other_camera: [u32; LANES],
    seen: [u32; LANES],
    /// Whether somebody has a better sample of the point that may not stand for it.
    passed_over: [u32; LANES],
    own_rank: [u32; LANES],
}

impl BestCandidates {
    /// Before any other camera than the block's own was asked.
    #[inline(always)]
    pub(crate) fn new(block: &PixelRun, camera: usize) -> Self {
        Self {
            own_camera: camera as u32,
            rank: block.rank,
            camera: [camera as u32; LANES],
            level: [0; LANES],
            pixel: [0; LANES],
            other_rank: block.other_rank,
            other_camera: [camera as u32; LANES],
            seen: [0; LANES],
            passed_over: [0; LANES],
            own_rank: block.rank,
        }
    }

    /// For which samples it matters what the target saw: where nobody else saw the point yet, or its sample would be the best
    /// by either model.
    #[inline(always)]
    fn wanted(&self, target: &CameraLayer, rival: usize, carried: &Carried) -> [u32; LANES] {
        if !any(&carried.bits) {
            return [0; LANES];
        }
        let mut ranks = [Ranks::ABSENT; LANES];
        for i in 0..LANES {
            ranks[i] = target.ranks[carried.pixel[i] as usize];
        }
        let rival = rival as u32;
        let mut wanted = [0; LANES];
        for i in 0..LANES {
            let better = wins(ranks[i].rank, rival, self.rank[i], self.camera[i]);
            let otherwise = wins(ranks[i].other_rank, rival, self.other_rank[i], self.other_camera[i]);
            let in_view = carried.bits[i] & IN_VIEW != 0;
            wanted[i] = u32::from(in_view & (better | otherwise | (self.seen[i] == 0)));
        }
        wanted
    }

    /// Holds the samples of a block of `camera`, carried to a rival, against the rival's. Gives how many are known better now.
    #[inline(always)]
    fn hold(
        &mut self,
        pass: &Pass<'_>,
        camera: usize,
        block: &PixelRun,
        rival: &OtherCamera<'_>,
        carried: &Carried,
        wanted: [u32; LANES],
    ) -> u32 {
        let (source, target) = (&pass.layers[camera], &pass.layers[rival.camera]);
        let answers = rival.limits.compare(rival.registration, (source, block), (target, carried), wanted);
        let mut stands = wanted;
        if !pass.all_stand[rival.camera] {
            for lane in 0..LANES {
                stands[lane] &= u32::from(pass.may_stand(rival.camera, answers.pixel[lane]));
            }
        }
        let mut ranks = [Ranks::ABSENT; LANES];
        for i in 0..LANES {
            ranks[i] = target.ranks[carried.pixel[i] as usize];
        }
        let name = rival.camera as u32;
        let mut told = 0;
        for i in 0..LANES {
            let shows = answers.is_same(i);
            let same = shows & (stands[i] != 0);
            let beats_own = wins(ranks[i].rank, name, self.own_rank[i], self.own_camera);
            self.passed_over[i] |= u32::from(shows & !same & beats_own);
            let better = same & wins(ranks[i].rank, name, self.rank[i], self.camera[i]);
            let otherwise = same & wins(ranks[i].other_rank, name, self.other_rank[i], self.other_camera[i]);
            told += u32::from(better | (same & (self.seen[i] == 0)));
            self.seen[i] |= u32::from(same);
            self.rank[i] = if better { ranks[i].rank } else { self.rank[i] };
            self.camera[i] = if better { name } else { self.camera[i] };
            self.level[i] = if better { answers.level[i] } else { self.level[i] };
            self.pixel[i] = if better { answers.pixel[i] } else { self.pixel[i] };
            self.other_rank[i] = if otherwise { ranks[i].other_rank } else { self.other_rank[i] };
            self.other_camera[i] = if otherwise { name } else { self.other_camera[i] };
        }
        told
    }

    /// The best sample of the point in `lane` where another camera has a better one than the block's own.
    #[inline(always)]
    pub(crate) fn best(&self, lane: usize) -> Option<Candidate> {
        (self.camera[lane] != self.own_camera).then(|| Candidate {
            rank: self.rank[lane],
            camera: self.camera[lane] as u16,
            level: self.level[lane] as SpanLevel,
            pixel: self.pixel[lane],
        })
    }

    /// The rank of the block's own sample in `lane`.
    #[inline(always)]
    pub(crate) fn own_rank(&self, lane: usize) -> u32 {
        self.own_rank[lane]
    }

    /// Whether some better sample of the point in `lane` may not stand for it.
    #[inline(always)]
    pub(crate) fn passed_over_a_better(&self, lane: usize) -> bool {
        self.passed_over[lane] != 0
    }

    /// Whether any other camera shows the point in `lane`.
    #[inline(always)]
    pub(crate) fn is_seen(&self, lane: usize) -> bool {
        self.seen[lane] != 0
    }

    /// The camera that has the best sample of the point in `lane` by the model in use, and by the other one.
    #[inline(always)]
    pub(crate) fn winners(&self, lane: usize) -> [u16; 2] {
        [self.camera[lane] as u16, self.other_camera[lane] as u16]
    }
}

/// Whether a sample of `rank` beats one of `other_rank`: of equals the earlier camera's wins.
#[inline(always)]
fn wins(rank: u32, camera: u32, other_rank: u32, other_camera: u32) -> bool {
    (rank < other_rank) | ((rank == other_rank) & (camera < other_camera))
}

#[cfg(test)]
mod tests {
    use crate::demo::{Demo, DemoSpec};
    use crate::grid::Grid;
    use crate::job::Job;
    use crate::preprocess::inspect_frame;
    use crate::settings::{CaptureSettings, Settings};
    use crate::simd;

    #[test]
    fn every_instruction_set_prunes_the_same_samples_for_the_same_witnesses() {
        let spec = DemoSpec::new("nine-cameras").cameras(4).frames(1).size((75, 50));
        let capture = Demo::new(&spec).unwrap().capture(&CaptureSettings::default());
        let verdicts = simd::at_every_level(|| {
            let inspection = inspect_frame(&capture, None, &Settings::default(), 0, &Job::new()).unwrap();
            inspection.cameras.into_iter().map(|camera| camera.verdict).collect::<Vec<_>>()
        });
        let dropped = verdicts[0].iter().flat_map(Grid::as_slice).filter(|verdict| !verdict.is_kept());
        assert!(dropped.count() > 75 * 50 / 2);
        assert!(verdicts.iter().all(|found| *found == verdicts[0]));
    }
}
