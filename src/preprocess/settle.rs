//! Deciding samples once those they wait for are decided: dropped where a candidate is kept, kept where none is.

use super::Rule;
use super::Verdict;
use super::layer::Level;
use super::pruning::{Band, DROPPED, KEPT, Pass, UNDECIDED};
use super::registration::Outcome;
use crate::simd::{self, Work};

/// Statuses of witnesses are fetched so many samples ahead.
const AHEAD: usize = 24;

/// A sample whose candidate is undecided yet.
pub(super) struct Waiting {
    /// Index into the band's pixels.
    index: u32,
    /// All candidates, worst first; found only where the best was dropped. The verdict names the one that is waited for.
    others: Option<Vec<Candidate>>,
}

/// A better sample of a point, in the order in which they win.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Candidate {
    pub(super) rank: u32,
    pub(super) camera: u16,
    pub(super) pixel: u32,
    pub(super) level: Level,
}

impl Pass<'_> {
    /// Decides every sample of the band whose best candidate is decided; the others wait.
    pub(super) fn settle(&self, band: &mut Band<'_>) {
        for index in 0..band.pixels.len() {
            if let Some(ahead) = band.verdicts.get(index + AHEAD) {
                let statuses = self.statuses.get(ahead.witness_camera as usize);
                simd::prefetch(statuses.map_or(&[], Vec::as_slice), ahead.witness_pixel as usize);
            }
            let verdict = band.verdicts[index];
            if verdict.witness_camera == Verdict::NO_CAMERA {
                continue;
            }
            if self.status(verdict.witness_camera as usize, verdict.witness_pixel) == KEPT {
                self.set_status(band.camera, band.pixels[index], DROPPED);
            } else {
                band.waiting.push(Waiting { index: index as u32, others: None });
            }
        }
    }

    #[inline(always)]
    fn still_waits(&self, band: &mut Band<'_>, sample: &mut Waiting) -> bool {
        let pixel = band.pixels[sample.index as usize];
        let verdict = &mut band.verdicts[sample.index as usize];
        loop {
            match self.status(verdict.witness_camera as usize, verdict.witness_pixel) {
                KEPT => {
                    self.set_status(band.camera, pixel, DROPPED);
                    return false;
                }
                UNDECIDED => return true,
                _ => {}
            }
            let others = sample.others.get_or_insert_with(|| self.all_but_the_best(band.camera, pixel));
            let Some(next) = others.pop() else {
                *verdict = Verdict::without_witness(Rule::Coverage);
                self.set_status(band.camera, pixel, KEPT);
                return false;
            };
            *verdict = self.dropped_for(self.layers[band.camera].ranks[pixel as usize].rank, next);
        }
    }

    /// All candidates of a sample but the best, worst first.
    #[inline(always)]
    fn all_but_the_best(&self, camera: usize, pixel: u32) -> Vec<Candidate> {
        let layer = &self.layers[camera];
        let (x, y) = (pixel as usize % layer.width, pixel as usize / layer.width);
        let rank = layer.ranks[pixel as usize].rank;
        let mut candidates = Vec::new();
        for other in (0..self.layers.len()).filter(|other| *other != camera) {
            let target = &self.layers[other];
            if target.facets.is_empty() {
                continue;
            }
            let registration = self.rig.registration(camera, other);
            let Outcome::Same(found) = registration.test(layer, target, x, y, &self.limits) else { continue };
            let found_rank = target.ranks[found as usize].rank;
            let own_level = target.level[found as usize] == self.decide;
            // What is dropped by now is still a candidate; it will be passed over.
            if (own_level || self.may_stand(other, found)) && (found_rank, other) < (rank, camera) {
                let level = target.level[found as usize];
                candidates.push(Candidate { rank: found_rank, camera: other as u16, pixel: found, level });
            }
        }
        candidates.sort_unstable_by(|a, b| b.cmp(a));
        candidates.pop();
        candidates
    }
}

/// Decides what can be decided of the samples that wait.
pub(super) struct SettleWaiting<'a, 'b> {
    pub(super) pass: &'a Pass<'a>,
    pub(super) band: &'a mut Band<'b>,
}

impl Work for SettleWaiting<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let mut waiting = std::mem::take(&mut self.band.waiting);
        waiting.retain_mut(|sample| self.pass.still_waits(self.band, sample));
        self.band.waiting = waiting;
    }
}
