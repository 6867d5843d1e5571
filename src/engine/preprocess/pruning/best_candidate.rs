//! Sixteen samples at a time against every other camera: who shows the same point, and who of them sampled it best?

use std::ops::Range;

use super::decision::{Candidate, Rule, Verdict, is_better, rule_of_kept};
use super::pass::PruningPass;
use crate::capture::overlap::{OverlapGraph, Registration};
use crate::preprocess::layers::{ABSENT_RANK, CameraLayer, Rank, RatedSamples, SampleRun};
use crate::preprocess::registration::{
    IN_VIEW, PixelRun, ReprojectedRun, SameSurface, SourceRun, TargetRun, lanes_of,
};
use crate::preprocess::temporal::{NO_SAMPLE, SpanLevel};
use crate::simd::{self, LANES};

/// Another camera that may show something of a band.
pub(crate) struct OtherCamera<'a> {
    pub(crate) camera: usize,
    pub(crate) registration: &'a Registration,
    pub(crate) limits: SameSurface,
    /// For each sixteen columns of the band.
    pub(crate) may_see: Vec<bool>,
    /// How often this camera gave the best candidate so far. Cameras are tried in descending order of it, which affects
    /// speed only.
    pub(crate) improved: u32,
}

/// The smallest and largest inverse depths of some samples, for each sixteen columns of a picture.
pub(crate) struct ColumnBounds {
    width: usize,
    /// The smallest is larger where there is no sample.
    bounds: Vec<[f32; 2]>,
}

impl ColumnBounds {
    /// Holds no sample yet; the picture has this many columns.
    pub(crate) fn new(width: usize) -> Self {
        Self { width, bounds: vec![[f32::INFINITY, 0.0]; width.div_ceil(LANES)] }
    }

    /// Adds a sample in the `nth` sixteen columns; nothing where the inverse depth is negative.
    #[inline(always)]
    pub(crate) fn add(&mut self, nth: usize, inverse_depth: f32) {
        if inverse_depth >= 0.0 {
            let [smallest, largest] = &mut self.bounds[nth];
            *smallest = smallest.min(inverse_depth);
            *largest = largest.max(inverse_depth);
        }
    }
}

/// The other cameras that may see any of the samples within `bounds` in a camera's rows.
#[inline(always)]
pub(crate) fn other_cameras<'a>(
    pairs: &'a OverlapGraph<'_>,
    layers: &[CameraLayer],
    camera: usize,
    rows: Range<usize>,
    bounds: &ColumnBounds,
    limits: impl Fn(usize) -> SameSurface,
) -> Vec<OtherCamera<'a>> {
    let ends = [rows.start, rows.end - 1];
    let ColumnBounds { width, bounds } = bounds;
    let whole = bounds
        .iter()
        .fold([f32::INFINITY, 0.0_f32], |all, block| [all[0].min(block[0]), all[1].max(block[1])]);
    let may_see = |(other, registration): &(usize, &Registration)| {
        !layers[*other].geometry.is_empty() && registration.may_see([0, width - 1], ends, whole)
    };
    let of_other = |(camera, registration): (usize, &'a Registration)| {
        let of_columns = |(at, bounds): (usize, &[f32; 2])| {
            let columns = [at * LANES, (at * LANES + LANES).min(*width) - 1];
            bounds[0] <= bounds[1] && registration.may_see(columns, ends, *bounds)
        };
        let may_see = bounds.iter().enumerate().map(of_columns).collect();
        OtherCamera { camera, registration, limits: limits(camera), improved: 0, may_see }
    };
    pairs.others(camera).filter(may_see).map(of_other).collect()
}

/// Which of sixteen pixels from `position`, column and row, on have a sample of a wanted level.
#[inline(always)]
pub(crate) fn lanes_at(
    layer: &CameraLayer,
    position: (usize, usize),
    is_wanted: impl Fn(SpanLevel) -> bool,
) -> u32 {
    let levels = lanes_of::<_, LANES>(&layer.level, layer.width, position, NO_SAMPLE);
    let mut lanes = 0;
    for lane in 0..LANES {
        lanes |= u32::from(is_wanted(levels[lane])) << lane;
    }
    lanes
}

/// Sixteen pixels of a row with samples to decide, and the best candidates found so far.
pub(crate) struct UndecidedRun {
    pub(crate) run: SampleRun,
    pub(crate) block: PixelRun,
    pub(crate) best: BestCandidates,
}

/// Where the samples of a run lie in another camera's picture, and which of them depend on what it saw.
pub(crate) struct ComparedRun {
    reprojected: ReprojectedRun,
    relevant: [u32; LANES],
}

impl ComparedRun {
    pub(crate) const NOWHERE: Self = Self { reprojected: ReprojectedRun::NOWHERE, relevant: [0; LANES] };
}

/// Compares samples of a camera with those of another camera. `compared` is scratch, at least one for each run. All are reprojected
/// before any of them is compared, so that many fetches from memory are under way at once.
#[inline(always)]
pub(crate) fn compare_runs(
    pass: &PruningPass<'_>,
    (camera, samples): (usize, &RatedSamples),
    undecided: &mut [UndecidedRun],
    other: &mut OtherCamera<'_>,
    compared: &mut [ComparedRun],
) {
    let target = &pass.layers[other.camera];
    for (run, compared) in undecided.iter().zip(&mut *compared) {
        compared.reprojected.bits = [0; LANES];
        if other.may_see[run.run.nth] {
            compared.reprojected = other.registration.reproject(&run.block, target.width);
            compared.reprojected.prefetch_ranks(target);
        }
    }
    for (run, compared) in undecided.iter().zip(&mut *compared) {
        compared.relevant = run.best.relevant(target, other.camera, &compared.reprojected);
        if any(&compared.relevant) {
            compared.reprojected.read_only(&compared.relevant);
            compared.reprojected.prefetch(target);
        }
    }
    for (run, compared) in undecided.iter_mut().zip(&*compared) {
        if any(&compared.relevant) {
            let SampleRun { first, lanes, .. } = run.run;
            let source = SourceRun::of_samples(&pass.layers[camera], &run.block, samples, first, lanes);
            other.improved += run.best.compare(pass, source, other, compared);
        }
    }
}

#[inline(always)]
fn any(lanes: &[u32; LANES]) -> bool {
    simd::joined(lanes) != 0
}

/// The best sample of each sample's point so far, at first its own.
pub(crate) struct BestCandidates {
    own_camera: u32,
    rank: [Rank; LANES],
    camera: [u32; LANES],
    level: [u32; LANES],
    pixel: [u32; LANES],
    /// Whether any other camera shows the point with a sample that may be a witness.
    seen: [u32; LANES],
    /// Whether there is a better sample of the point that may not be a witness.
    passed_over: [u32; LANES],
    pub(super) own_rank: [Rank; LANES],
}

impl BestCandidates {
    /// Before any other camera was compared.
    #[inline(always)]
    pub(crate) fn new(block: &PixelRun, camera: usize) -> Self {
        Self {
            own_camera: camera as u32,
            rank: block.rank,
            camera: [camera as u32; LANES],
            level: [0; LANES],
            pixel: [0; LANES],
            seen: [0; LANES],
            passed_over: [0; LANES],
            own_rank: block.rank,
        }
    }

    /// Begins in `lane` with what was found in other layers before: a verdict as if the best candidate were kept, and that candidate's
    /// rank.
    #[inline(always)]
    pub(crate) fn resume(&mut self, lane: usize, found: Verdict, rank: Rank) {
        if found.witness_camera == Verdict::NO_CAMERA {
            self.passed_over[lane] = u32::from(found.rule == Rule::Coverage);
            self.seen[lane] = u32::from(found.rule == Rule::BestRate);
        } else {
            self.rank[lane] = rank;
            self.camera[lane] = u32::from(found.witness_camera);
            self.level[lane] = u32::from(found.witness_level);
            self.pixel[lane] = found.witness_pixel;
            self.seen[lane] = 1;
        }
    }

    /// By which rule the sample in `lane` is kept if it has no candidate.
    #[inline(always)]
    pub(crate) fn rule_of_kept(&self, lane: usize) -> Rule {
        rule_of_kept(self.passed_over[lane] != 0, self.seen[lane] != 0)
    }

    /// For which samples it matters what the target saw: where no other camera saw the point yet, or the target's sample would
    /// be the best.
    #[inline(always)]
    fn relevant(&self, target: &CameraLayer, camera: usize, reprojected: &ReprojectedRun) -> [u32; LANES] {
        if !any(&reprojected.bits) {
            return [0; LANES];
        }
        let ranks = ranks_at(target, reprojected);
        let camera = camera as u32;
        let mut relevant = [0; LANES];
        for i in 0..LANES {
            let better = is_better(ranks[i], camera, self.rank[i], self.camera[i]);
            let in_view = reprojected.bits[i] & IN_VIEW != 0;
            relevant[i] = u32::from(in_view & (ranks[i] < ABSENT_RANK) & (better | (self.seen[i] == 0)));
        }
        relevant
    }

    /// Compares the samples of a block with those of another camera. Gives for how many that camera's is the best
    /// so far.
    #[inline(always)]
    fn compare(
        &mut self,
        pass: &PruningPass<'_>,
        source: SourceRun<'_>,
        other: &OtherCamera<'_>,
        ComparedRun { reprojected, relevant }: &ComparedRun,
    ) -> u32 {
        let target = &pass.layers[other.camera];
        let matches = other.limits.compare(
            other.registration,
            source,
            TargetRun { layer: target, reprojected },
            *relevant,
        );
        let mut may_be_witness = *relevant;
        if !pass.all_may_be_witnesses[other.camera] {
            // Looked up one by one, and far apart in memory.
            for lane in (0..LANES).filter(|lane| relevant[*lane] != 0 && matches.is_same(*lane)) {
                may_be_witness[lane] = u32::from(pass.may_be_witness(other.camera, matches.pixel[lane]));
            }
        }
        let ranks = ranks_at(target, reprojected);
        let name = other.camera as u32;
        let mut improved = 0;
        for i in 0..LANES {
            let shows = matches.is_same(i) & (relevant[i] != 0);
            let same = shows & (may_be_witness[i] != 0);
            let beats_own = is_better(ranks[i], name, self.own_rank[i], self.own_camera);
            self.passed_over[i] |= u32::from(shows & !same & beats_own);
            let better = same & is_better(ranks[i], name, self.rank[i], self.camera[i]);
            improved += u32::from(better | (same & (self.seen[i] == 0)));
            self.seen[i] |= u32::from(same);
            self.rank[i] = if better { ranks[i] } else { self.rank[i] };
            self.camera[i] = if better { name } else { self.camera[i] };
            self.level[i] = if better { matches.level[i] } else { self.level[i] };
            self.pixel[i] = if better { matches.pixel[i] } else { self.pixel[i] };
        }
        improved
    }

    /// The best sample of the point in `lane` where another camera has a better one than the block's own.
    #[inline(always)]
    pub(crate) fn candidate(&self, lane: usize) -> Option<Candidate> {
        (self.camera[lane] != self.own_camera).then(|| Candidate {
            rank: self.rank[lane],
            camera: self.camera[lane] as u16,
            level: self.level[lane] as SpanLevel,
            pixel: self.pixel[lane],
        })
    }
}

/// The ranks of what the target saw where samples lie.
#[inline(always)]
fn ranks_at(target: &CameraLayer, reprojected: &ReprojectedRun) -> [Rank; LANES] {
    let mut ranks = [ABSENT_RANK; LANES];
    for i in 0..LANES {
        ranks[i] = target.ranks[reprojected.pixel[i] as usize];
    }
    ranks
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
