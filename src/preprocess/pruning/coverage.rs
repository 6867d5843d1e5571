//! Deciding samples once those they wait for are decided: dropped where a candidate is kept, kept where none is.

use super::decision::{Rule, Verdict};
use super::pass::{Candidate, Pass, SearchBand, Waiting};
use super::status::{DROPPED, KEPT, UNDECIDED};
use crate::preprocess::registration::Outcome;
use crate::simd::{self, VectorLoop};

/// Statuses of witnesses are fetched so many samples ahead.
const AHEAD: usize = 24;

/// Decides every sample of the band whose best candidate is decided; the others wait.
pub(crate) fn settle(pass: &Pass<'_>, band: &mut SearchBand<'_>) {
    for index in 0..band.pixels.len() {
        if let Some(ahead) = band.verdicts.get(index + AHEAD) {
            let statuses = pass.statuses.get(ahead.witness_camera as usize);
            simd::prefetch(statuses.map_or(&[], Vec::as_slice), ahead.witness_pixel as usize);
        }
        let verdict = band.verdicts[index];
        if verdict.witness_camera == Verdict::NO_CAMERA {
            continue;
        }
        if pass.status(verdict.witness_camera as usize, verdict.witness_pixel) == KEPT {
            pass.set_status(band.camera, band.pixels[index], DROPPED);
        } else {
            band.waiting.push(Waiting { index: index as u32, others: None });
        }
    }
}

#[inline(always)]
fn still_waits(pass: &Pass<'_>, band: &mut SearchBand<'_>, sample: &mut Waiting) -> bool {
    let pixel = band.pixels[sample.index as usize];
    let verdict = &mut band.verdicts[sample.index as usize];
    loop {
        match pass.status(verdict.witness_camera as usize, verdict.witness_pixel) {
            KEPT => {
                pass.set_status(band.camera, pixel, DROPPED);
                return false;
            }
            UNDECIDED => return true,
            _ => {}
        }
        let others = sample.others.get_or_insert_with(|| all_but_the_best(pass, band.camera, pixel));
        let Some(next) = others.pop() else {
            *verdict = Verdict::without_witness(Rule::Coverage);
            pass.set_status(band.camera, pixel, KEPT);
            return false;
        };
        *verdict = pass.dropped_for(pass.layers[band.camera].ranks[pixel as usize].rank, next);
    }
}

/// All candidates of a sample but the best, worst first.
#[inline(always)]
fn all_but_the_best(pass: &Pass<'_>, camera: usize, pixel: u32) -> Vec<Candidate> {
    let layer = &pass.layers[camera];
    let (x, y) = (pixel as usize % layer.width, pixel as usize / layer.width);
    let rank = layer.ranks[pixel as usize].rank;
    let mut candidates = Vec::new();
    for other in (0..pass.layers.len()).filter(|other| *other != camera) {
        let target = &pass.layers[other];
        if target.facets.is_empty() {
            continue;
        }
        let registration = pass.rig.registration(camera, other);
        let Outcome::Same(found) = pass.limits.test(registration, (layer, x, y), target) else { continue };
        let found_rank = target.ranks[found as usize].rank;
        let own_level = target.level[found as usize] == pass.decide;
        // What is dropped by now is still a candidate; it will be passed over.
        if (own_level || pass.may_stand(other, found)) && (found_rank, other) < (rank, camera) {
            let level = target.level[found as usize];
            candidates.push(Candidate { rank: found_rank, camera: other as u16, pixel: found, level });
        }
    }
    candidates.sort_unstable_by(|a, b| b.cmp(a));
    candidates.pop();
    candidates
}

/// Decides what can be decided of the samples that wait.
pub(crate) struct SettleWaiting<'a, 'b> {
    pub(crate) pass: &'a Pass<'a>,
    pub(crate) band: &'a mut SearchBand<'b>,
}

impl VectorLoop for SettleWaiting<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let mut waiting = std::mem::take(&mut self.band.waiting);
        waiting.retain_mut(|sample| still_waits(self.pass, self.band, sample));
        self.band.waiting = waiting;
    }
}
