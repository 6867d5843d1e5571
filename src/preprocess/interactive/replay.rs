//! Pruning a frame from its docket: what [`crate::preprocess::pruning`] decides, without searching.

use std::sync::atomic::{AtomicU8, Ordering};

use rayon::prelude::*;

use super::candidate::{BEHIND, CandidateValidity, Claimant, Codes, codes, tolerances};
use super::candidate_lists::{COUNT, CandidateLists, DISPUTABLE, IS_MIXED, Lists};
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::layers::CameraLayer;
use crate::preprocess::pruning::{BAND_ROWS, DROPPED, Dispute, KEPT, Rule, Statuses, UNDECIDED, Verdict};
use crate::preprocess::registration::{CameraPairs, LANES, Outcome, SameSurface};
use crate::preprocess::temporal::SpanLevel;
use crate::settings::{MixedPixels, Settings};

/// Decides every sample of level `decide` of a frame whose docket serves the settings. `verdicts` has one for each pixel of
/// each camera; those of other levels stay as they are. Gives each camera's disputes.
///
/// # Errors
/// `Cancelled`.
pub(crate) fn prune(
    (docket, rig): (&CandidateLists, &CameraPairs<'_>),
    layers: &[CameraLayer],
    statuses: &Statuses,
    decide: SpanLevel,
    settings: &Settings,
    verdicts: &mut [Vec<Verdict>],
    job: &Job,
) -> Result<Vec<Vec<Dispute>>> {
    let limits = SameSurface::new(settings).at_level(decide);
    let codes = codes(tolerances(&settings.pruning));
    let walk = ReplayContext { docket, rig, layers, statuses, decide, settings, limits, codes };
    let mut bands: Vec<ReplayBand<'_>> = Vec::new();
    for (camera, (layer, verdicts)) in layers.iter().zip(verdicts).enumerate() {
        let size = (BAND_ROWS * layer.width).max(1);
        bands.extend(verdicts.chunks_mut(size).enumerate().map(|(index, verdicts)| ReplayBand {
            camera,
            index,
            first: index * size,
            verdicts,
            disputes: Vec::new(),
            waiting: Vec::new(),
        }));
    }
    bands.par_iter_mut().try_for_each(|band| {
        job.check()?;
        walk.find_best(band);
        Ok(())
    })?;
    bands.retain(|band| !(band.waiting.is_empty() && band.disputes.is_empty()));
    while bands.iter().any(|band| !band.waiting.is_empty()) {
        job.check()?;
        bands.par_iter_mut().for_each(|band| walk.settle(band));
    }
    let mut disputes = vec![Vec::new(); layers.len()];
    for band in bands {
        disputes[band.camera].extend(band.disputes);
    }
    Ok(disputes)
}

/// What all bands share.
struct ReplayContext<'a> {
    docket: &'a CandidateLists,
    rig: &'a CameraPairs<'a>,
    layers: &'a [CameraLayer],
    statuses: &'a Statuses,
    decide: SpanLevel,
    settings: &'a Settings,
    limits: SameSurface,
    codes: Codes,
}

/// Some rows of one camera. Until a sample is settled, its verdict names its best candidate as if that one were kept.
struct ReplayBand<'a> {
    camera: usize,
    index: usize,
    /// Its first pixel.
    first: usize,
    /// Of all its pixels.
    verdicts: &'a mut [Verdict],
    disputes: Vec<Dispute>,
    /// Places of samples whose candidate may be dropped itself.
    waiting: Vec<u32>,
}

impl ReplayContext<'_> {
    fn lists(&self, band: &ReplayBand<'_>) -> &Lists {
        &self.docket.lists[band.camera][band.index]
    }

    fn status(&self, claim: Verdict) -> u8 {
        self.statuses[usize::from(claim.witness_camera)][claim.witness_pixel as usize].load(Ordering::Relaxed)
    }

    /// The best candidate of every sample of a band; settles those whose candidate is surely kept, or who have none.
    fn find_best(&self, band: &mut ReplayBand<'_>) {
        let layer = &self.layers[band.camera];
        let (lists, columns) = (self.lists(band), layer.width.div_ceil(LANES));
        let levels = &layer.level[band.first..band.first + band.verdicts.len()];
        let statuses = &self.statuses[band.camera][band.first..band.first + band.verdicts.len()];
        for (block, &first) in lists.first.iter().enumerate() {
            let left = block % columns * LANES;
            let start = block / columns * layer.width + left;
            let places = start..start + LANES.min(layer.width - left);
            if levels[places.clone()].contains(&self.decide) {
                self.find_in_block(band, (lists, first as usize), places, levels, statuses);
            }
        }
    }

    #[inline(always)]
    fn find_in_block(
        &self,
        band: &mut ReplayBand<'_>,
        (lists, mut first): (&Lists, usize),
        places: std::ops::Range<usize>,
        levels: &[SpanLevel],
        statuses: &[AtomicU8],
    ) {
        for place in places {
            let count = lists.counts[place];
            let claimants = &lists.claimants[first..first + usize::from(count & COUNT)];
            first += claimants.len();
            if levels[place] != self.decide {
                continue;
            }
            let (verdict, status) = self.first_verdict(band, place, count, claimants);
            band.verdicts[place] = verdict;
            statuses[place].store(status, Ordering::Relaxed);
        }
    }

    /// The verdict on a sample if its best candidate is kept, and its status as far as that is known.
    #[inline(always)]
    fn first_verdict(
        &self,
        band: &mut ReplayBand<'_>,
        place: usize,
        count: u16,
        claimants: &[Claimant],
    ) -> (Verdict, u8) {
        if count & IS_MIXED != 0 && self.settings.pruning.mixed_pixels == MixedPixels::Drop {
            return (Verdict::without_witness(Rule::MixedDropped), DROPPED);
        }
        let best = claimants.iter().find(|claimant| self.stands(band, place, claimant));
        let better = best.filter(|best| best.is_better());
        if count & DISPUTABLE != 0 {
            self.dispute(band, place, better, claimants);
        }
        if let Some(better) = better {
            // Samples of longer spans stand here only where they are kept already.
            if better.is_sure || better.verdict.witness_level != self.decide {
                return (better.verdict, DROPPED);
            }
            band.waiting.push(place as u32);
            return (better.verdict, UNDECIDED);
        }
        let mut ahead = claimants.iter().take_while(|claimant| claimant.is_better());
        let rule = if ahead.any(|claimant| self.shows(band, place, claimant)) {
            Rule::Coverage
        } else if best.is_some() {
            Rule::BestRate
        } else {
            Rule::OnlyWitness
        };
        (Verdict::without_witness(rule), KEPT)
    }

    /// Notes where the other rate model names another winner.
    fn dispute(
        &self,
        band: &mut ReplayBand<'_>,
        place: usize,
        better: Option<&Claimant>,
        claimants: &[Claimant],
    ) {
        let ahead = claimants.iter().filter(|claimant| claimant.place != BEHIND);
        let other =
            ahead.filter(|claimant| self.stands(band, place, claimant)).min_by_key(|claimant| claimant.place);
        let name =
            |winner: Option<&Claimant>| winner.map_or(band.camera as u16, |w| w.verdict.witness_camera);
        let (camera, other_camera) = (name(better), name(other));
        if camera != other_camera {
            band.disputes.push(Dispute { pixel: (band.first + place) as u32, camera, other_camera });
        }
    }

    /// Whether a claimant shows the sample's point and may stand for others, as far as is known before anything of this level
    /// is decided.
    #[inline(always)]
    fn stands(&self, band: &ReplayBand<'_>, place: usize, claimant: &Claimant) -> bool {
        let own_level = claimant.verdict.witness_level == self.decide;
        self.shows(band, place, claimant)
            && (own_level || (self.settings.pruning.across_spans && self.status(claimant.verdict) == KEPT))
    }

    /// Whether a claimant shows the sample's point.
    #[inline(always)]
    fn shows(&self, band: &ReplayBand<'_>, place: usize, claimant: &Claimant) -> bool {
        match claimant.holds(self.codes) {
            CandidateValidity::Yes => true,
            CandidateValidity::No => false,
            CandidateValidity::Ask => self.ask(band, place, claimant),
        }
    }

    #[cold]
    #[inline(never)]
    fn ask(&self, band: &ReplayBand<'_>, place: usize, claimant: &Claimant) -> bool {
        let (layer, other) = (&self.layers[band.camera], usize::from(claimant.verdict.witness_camera));
        let pixel = band.first + place;
        let (x, y) = (pixel % layer.width, pixel / layer.width);
        let registration = self.rig.registration(band.camera, other);
        let outcome = self.limits.test(registration, (layer, x, y), &self.layers[other]);
        outcome == Outcome::Same(claimant.verdict.witness_pixel)
    }

    /// Decides the waiting samples of a band whose candidate is decided; the others wait on.
    fn settle(&self, band: &mut ReplayBand<'_>) {
        let mut waiting = std::mem::take(&mut band.waiting);
        waiting.retain(|&place| self.still_waits(band, place as usize));
        band.waiting = waiting;
    }

    fn still_waits(&self, band: &mut ReplayBand<'_>, place: usize) -> bool {
        let own = &self.statuses[band.camera][band.first + place];
        loop {
            match self.status(band.verdicts[place]) {
                KEPT => {
                    own.store(DROPPED, Ordering::Relaxed);
                    return false;
                }
                UNDECIDED => return true,
                _ => {}
            }
            let asked = band.verdicts[place].witness_camera;
            let claimants = self.lists(band).of(place, self.layers[band.camera].width).iter();
            let after = claimants.skip_while(|claimant| claimant.verdict.witness_camera != asked).skip(1);
            let next = after
                .take_while(|claimant| claimant.is_better())
                .find(|claimant| self.stands(band, place, claimant))
                .map(|claimant| claimant.verdict);
            band.verdicts[place] = next.unwrap_or_else(|| Verdict::without_witness(Rule::Coverage));
            if next.is_none() {
                own.store(KEPT, Ordering::Relaxed);
                return false;
            }
        }
    }
}
