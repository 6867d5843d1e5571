//! Sixteen samples at a time against every other camera: who shows the same point, and who of them sampled it best?

use super::pruning::Pass;
use super::registration::{Block, LANES, Registration, SameSurface};

/// The other cameras that may show something of a block, in their order, with the way there and the thresholds.
pub(super) type Witnesses<'a> = Vec<(usize, &'a Registration, SameSurface)>;

/// No camera.
const NOBODY: u32 = u32::MAX;

/// How the contest went for each sample of a block.
pub(super) struct Contest {
    rank: [u32; LANES],
    camera: [u32; LANES],
    pixel: [u32; LANES],
    other_rank: [u32; LANES],
    other_camera: [u32; LANES],
    seen: [u32; LANES],
}

/// The best of all better samples of a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Best {
    pub(super) rank: u32,
    pub(super) camera: u32,
    pub(super) pixel: u32,
}

impl Contest {
    /// Holds the samples of a block of `camera` against those of all `witnesses`. Of equals the earlier camera wins.
    #[inline(always)]
    pub(super) fn hold(pass: &Pass<'_>, camera: usize, block: &Block, witnesses: &Witnesses<'_>) -> Self {
        let mut contest = Self {
            rank: [0; LANES],
            camera: [NOBODY; LANES],
            pixel: [0; LANES],
            other_rank: [0; LANES],
            other_camera: [NOBODY; LANES],
            seen: [0; LANES],
        };
        // Against earlier cameras a tie is lost.
        for lane in 0..LANES {
            contest.rank[lane] = block.rank[lane].saturating_add(1);
            contest.other_rank[lane] = block.other_rank[lane].saturating_add(1);
        }
        let mut later = false;
        for (other, registration, limits) in witnesses {
            if *other > camera && !later {
                later = true;
                for lane in 0..LANES {
                    contest.rank[lane] = contest.rank[lane].min(block.rank[lane]);
                    contest.other_rank[lane] = contest.other_rank[lane].min(block.other_rank[lane]);
                }
            }
            let (source, target) = (&pass.layers[camera], &pass.layers[*other]);
            let Some(answers) = registration.ask(source, target, block, limits) else { continue };
            let mut stands = [1_u32; LANES];
            if !pass.all_stand[*other] {
                for lane in 0..LANES {
                    stands[lane] = u32::from(pass.may_stand(*other, answers.pixel[lane]));
                }
            }
            for lane in 0..LANES {
                let same = answers.is_same(lane) & (stands[lane] != 0);
                let better = same & (answers.rank[lane] < contest.rank[lane]);
                let otherwise = same & (answers.other_rank[lane] < contest.other_rank[lane]);
                contest.seen[lane] |= u32::from(same);
                contest.rank[lane] = if better { answers.rank[lane] } else { contest.rank[lane] };
                contest.camera[lane] = if better { *other as u32 } else { contest.camera[lane] };
                contest.pixel[lane] = if better { answers.pixel[lane] } else { contest.pixel[lane] };
                contest.other_rank[lane] =
                    if otherwise { answers.other_rank[lane] } else { contest.other_rank[lane] };
                contest.other_camera[lane] =
                    if otherwise { *other as u32 } else { contest.other_camera[lane] };
            }
        }
        contest
    }

    /// The best sample of the point in `lane` where another camera has a better one than the block's own.
    #[inline(always)]
    pub(super) fn best(&self, lane: usize) -> Option<Best> {
        (self.camera[lane] != NOBODY).then(|| Best {
            rank: self.rank[lane],
            camera: self.camera[lane],
            pixel: self.pixel[lane],
        })
    }

    /// Whether any other camera shows the point in `lane`.
    #[inline(always)]
    pub(super) fn is_seen(&self, lane: usize) -> bool {
        self.seen[lane] != 0
    }

    /// The camera that has the best sample of the point in `lane` by the model in use, and by the other one; `None` is the
    /// block's own.
    #[inline(always)]
    pub(super) fn winners(&self, lane: usize) -> [Option<u32>; 2] {
        [self.camera[lane], self.other_camera[lane]].map(|camera| (camera != NOBODY).then_some(camera))
    }
}
