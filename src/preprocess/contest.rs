//! Sixteen samples at a time against every other camera: who shows the same point, and who of them sampled it best?

use super::layer::Level;
use super::pruning::Pass;
use super::registration::{Block, Carried, LANES, Registration, SameSurface};

/// Another camera that may show something of a band.
pub(super) struct Rival<'a> {
    pub(super) camera: usize,
    pub(super) registration: &'a Registration,
    pub(super) limits: SameSurface,
    /// For each sixteen columns of the band.
    pub(super) may_see: Vec<bool>,
}

/// No camera.
const NOBODY: u32 = u32::MAX;

/// A camera's number, and above it the level of its sample.
const CAMERA_MASK: u32 = 0xffff;
const LEVEL_SHIFT: u32 = 16;

/// Blocks that are carried before the first of them is compared: so many fetches from memory are under way at once.
const AHEAD: usize = 8;

/// A block with something to decide: its place in the row, its lanes and samples, and how its contest stands.
pub(super) struct Entry {
    pub(super) at: usize,
    pub(super) lanes: u32,
    pub(super) block: Block,
    pub(super) contest: Contest,
}

/// Holds a row of blocks of `camera` against a rival.
#[inline(always)]
pub(super) fn hold_row(pass: &Pass<'_>, camera: usize, entries: &mut [Entry], rival: &Rival<'_>) {
    let target = &pass.layers[rival.camera];
    let mut carried = [Carried::NOWHERE; AHEAD];
    for entries in entries.chunks_mut(AHEAD) {
        for (entry, carried) in entries.iter().zip(&mut carried) {
            *carried = Carried::NOWHERE;
            if rival.may_see[entry.at] {
                *carried = rival.registration.carry(&entry.block, target.width);
                carried.prefetch(target);
            }
        }
        for (entry, carried) in entries.iter_mut().zip(&carried) {
            entry.contest.hold(pass, camera, &entry.block, rival, carried);
        }
    }
}

/// How the contest went for each sample of a block.
pub(super) struct Contest {
    rank: [u32; LANES],
    /// With the level above it, see [`LEVEL_SHIFT`].
    camera: [u32; LANES],
    pixel: [u32; LANES],
    other_rank: [u32; LANES],
    other_camera: [u32; LANES],
    seen: [u32; LANES],
    own_rank: [u32; LANES],
}

/// The best of all better samples of a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Best {
    pub(super) rank: u32,
    pub(super) camera: u16,
    pub(super) level: Level,
    pub(super) pixel: u32,
}

impl Contest {
    /// Before any other camera was asked.
    #[inline(always)]
    pub(super) fn new(block: &Block) -> Self {
        let mut contest = Self {
            rank: [0; LANES],
            camera: [NOBODY; LANES],
            pixel: [0; LANES],
            other_rank: [0; LANES],
            other_camera: [NOBODY; LANES],
            seen: [0; LANES],
            own_rank: block.rank,
        };
        // Against earlier cameras a tie is lost.
        for lane in 0..LANES {
            contest.rank[lane] = block.rank[lane].saturating_add(1);
            contest.other_rank[lane] = block.other_rank[lane].saturating_add(1);
        }
        contest
    }

    /// Holds the samples of a block of `camera`, carried to a rival, against the rival's. Rivals come in their order: of
    /// equals the earlier camera wins.
    #[inline(always)]
    fn hold(&mut self, pass: &Pass<'_>, camera: usize, block: &Block, rival: &Rival<'_>, carried: &Carried) {
        if !carried.any_in_view() {
            return;
        }
        let (source, target) = (&pass.layers[camera], &pass.layers[rival.camera]);
        // What is worse than the best so far changes nothing, once the point was seen by anybody.
        let answers =
            rival.registration.compare(source, target, block, carried, &rival.limits, |lane, found| {
                (self.seen[lane] == 0)
                    | (found.rank < self.rank[lane])
                    | (found.other_rank < self.other_rank[lane])
            });
        let mut stands = [1_u32; LANES];
        if !pass.all_stand[rival.camera] {
            for lane in 0..LANES {
                stands[lane] = u32::from(pass.may_stand(rival.camera, answers.pixel[lane]));
            }
        }
        let later = rival.camera > camera;
        let name = rival.camera as u32;
        for lane in 0..LANES {
            let same = answers.is_same(lane) & (stands[lane] != 0);
            let limit = if later { block.rank[lane] } else { u32::MAX };
            let other_limit = if later { block.other_rank[lane] } else { u32::MAX };
            let better = same & (answers.rank[lane] < self.rank[lane].min(limit));
            let otherwise = same & (answers.other_rank[lane] < self.other_rank[lane].min(other_limit));
            self.seen[lane] |= u32::from(same);
            self.rank[lane] = if better { answers.rank[lane] } else { self.rank[lane] };
            self.camera[lane] =
                if better { name | answers.level[lane] << LEVEL_SHIFT } else { self.camera[lane] };
            self.pixel[lane] = if better { answers.pixel[lane] } else { self.pixel[lane] };
            self.other_rank[lane] = if otherwise { answers.other_rank[lane] } else { self.other_rank[lane] };
            self.other_camera[lane] = if otherwise { name } else { self.other_camera[lane] };
        }
    }

    /// The best sample of the point in `lane` where another camera has a better one than the block's own.
    #[inline(always)]
    pub(super) fn best(&self, lane: usize) -> Option<Best> {
        (self.camera[lane] != NOBODY).then(|| Best {
            rank: self.rank[lane],
            camera: (self.camera[lane] & CAMERA_MASK) as u16,
            level: (self.camera[lane] >> LEVEL_SHIFT) as Level,
            pixel: self.pixel[lane],
        })
    }

    /// The rank of the block's own sample in `lane`.
    #[inline(always)]
    pub(super) fn own_rank(&self, lane: usize) -> u32 {
        self.own_rank[lane]
    }

    /// Whether any other camera shows the point in `lane`.
    #[inline(always)]
    pub(super) fn is_seen(&self, lane: usize) -> bool {
        self.seen[lane] != 0
    }

    /// The camera that has the best sample of the point in `lane` by the model in use, and by the other one; `None` is the
    /// block's own.
    #[inline(always)]
    pub(super) fn winners(&self, lane: usize) -> [Option<u16>; 2] {
        [self.camera[lane], self.other_camera[lane]]
            .map(|camera| (camera != NOBODY).then_some((camera & CAMERA_MASK) as u16))
    }
}

#[cfg(test)]
mod tests {
    use crate::capture::demo::{Demo, DemoSpec};
    use crate::grid::Grid;
    use crate::job::Job;
    use crate::preprocess::inspect_frame;
    use crate::settings::{CaptureSettings, Settings};
    use crate::simd;

    #[test]
    fn every_instruction_set_prunes_the_same_samples_for_the_same_witnesses() {
        let spec = DemoSpec {
            scene: "nine-cameras".to_owned(),
            cameras: Some(4),
            frames: Some(1),
            size: Some((75, 50)),
            noise: None,
        };
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
