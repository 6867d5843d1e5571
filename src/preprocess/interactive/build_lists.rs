//! Making the docket of a frame: every sample is carried into every other camera, and all that may show its point are listed.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use rayon::prelude::*;

use super::candidate::{BEHIND, Claimant, Codes, codes, codes_of};
use super::candidate_lists::{
    COUNT, CandidateLists, DISPUTABLE, IS_MIXED, Lists, ToleranceRange, most_tolerant,
};
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::layers::{CameraLayer, MIXED, Ranks};
use crate::preprocess::pruning::{BAND_ROWS, OtherCamera, Rule, Verdict, lanes_at, rivals, rule_between};
use crate::preprocess::registration::{CameraPairs, Carried, IN_VIEW, LANES, Needs, PixelRun, SameSurface};
use crate::preprocess::temporal::{NO_SAMPLE, SpanLevel};
use crate::settings::{MixedPixels, Settings};
use crate::simd::{self, VectorLoop};

/// The docket of a frame of so many `levels`, for tolerances around those of `settings`; `None` where it would take more
/// than `bytes`.
///
/// # Errors
/// `Cancelled`.
pub(crate) fn make_docket(
    rig: &CameraPairs<'_>,
    layers: &[CameraLayer],
    levels: usize,
    settings: &Settings,
    bytes: usize,
    job: &Job,
) -> Result<Option<CandidateLists>> {
    if layers.len() >= usize::from(BEHIND) {
        return Ok(None);
    }
    let reach = ToleranceRange::around(&settings.pruning);
    let least = codes(reach.least);
    let settings = most_tolerant(settings);
    let summons = Summons {
        rig,
        layers,
        levels: levels as SpanLevel,
        settings: &settings,
        limits: SameSurface::new(&settings),
        few_steps: reach.least[2] / 2.0,
        beatable: layers
            .iter()
            .map(|layer| layer.level.iter().map(|_| AtomicBool::new(false)).collect())
            .collect(),
        room: AtomicUsize::new(bytes / size_of::<Claimant>()),
    };
    let bands = layers.iter().enumerate().flat_map(|(camera, layer)| {
        let height = layer.height();
        (0..height).step_by(BAND_ROWS).map(move |row| (camera, row..(row + BAND_ROWS).min(height)))
    });
    let bands: Vec<(usize, Range<usize>)> = bands.collect();
    let summoned = bands.par_iter().map(|(camera, rows)| {
        job.check()?;
        Ok(simd::run(Call { summons: &summons, camera: *camera, rows: rows.clone() }))
    });
    let summoned: Vec<Option<Lists>> = summoned.collect::<Result<_>>()?;
    let Some(mut all) = summoned.into_iter().collect::<Option<Vec<Lists>>>() else { return Ok(None) };
    all.par_iter_mut().zip(&bands).for_each(|(lists, (camera, rows))| {
        summons.leave_out(lists, &layers[*camera], rows.start, least);
    });
    let mut lists: Vec<Vec<Lists>> = layers.iter().map(|_| Vec::new()).collect();
    for (of_band, (camera, _)) in all.into_iter().zip(bands) {
        lists[camera].push(of_band);
    }
    Ok(Some(CandidateLists { reach, lists }))
}

/// What all bands share.
struct Summons<'a> {
    rig: &'a CameraPairs<'a>,
    layers: &'a [CameraLayer],
    levels: SpanLevel,
    settings: &'a Settings,
    limits: SameSurface,
    /// See [`Needs::few_steps`].
    few_steps: f32,
    /// Per sample, whether any other may be better.
    beatable: Vec<Vec<AtomicBool>>,
    /// Claimants that there is memory for yet.
    room: AtomicUsize,
}

/// Lists all claimants of the samples of a band; `None` where there is no room.
struct Call<'a> {
    summons: &'a Summons<'a>,
    camera: usize,
    rows: Range<usize>,
}

/// A claimant of the sample in column `x`, before it is known how it compares.
#[derive(Clone, Copy)]
struct Summoned {
    x: u32,
    ranks: Ranks,
    claimant: Claimant,
}

impl VectorLoop for Call<'_> {
    type Output = Option<Lists>;

    #[inline(always)]
    fn run(self) -> Option<Lists> {
        let Self { summons, camera, rows } = self;
        let layer = &summons.layers[camera];
        let columns = layer.width.div_ceil(LANES);
        let lanes: Vec<u32> = rows.clone().flat_map(|row| lanes_with_samples(layer, row)).collect();
        let mut rivals = rivals(summons.rig, summons.layers, (camera, rows.clone()), &lanes, |other| {
            summons.limits.between(layer, &summons.layers[other])
        });
        let mut lists = Lists {
            first: Vec::with_capacity(lanes.len()),
            counts: vec![0; rows.len() * layer.width],
            claimants: Vec::new(),
        };
        let mut ways: Vec<Carried> = (0..columns).map(|_| Carried::NOWHERE).collect();
        let (mut row_of, mut sorted) = (Vec::new(), Vec::new());
        for (index, row) in rows.enumerate() {
            row_of.clear();
            for level in (0..summons.levels)
                .filter(|level| layer.level[row * layer.width..][..layer.width].contains(level))
            {
                summons.call_row(camera, (row, level), &mut rivals, &mut ways, &mut row_of);
            }
            let counts = &mut lists.counts[index * layer.width..][..layer.width];
            sort_by_column(&row_of, counts, &mut sorted);
            if summons
                .room
                .fetch_update(Ordering::Relaxed, Ordering::Relaxed, |room| room.checked_sub(sorted.len()))
                .is_err()
            {
                return None;
            }
            let mut rest = &mut sorted[..];
            for (x, count) in counts.iter_mut().enumerate() {
                if x.is_multiple_of(LANES) {
                    lists.first.push(lists.claimants.len() as u32);
                }
                let (own, others) = rest.split_at_mut(usize::from(*count));
                rest = others;
                *count |= summons.compare_ranks((camera, row * layer.width + x), own);
                lists.claimants.extend(own.iter().map(|summoned| summoned.claimant));
            }
        }
        Some(lists)
    }
}

/// Which pixels of each sixteen of a row hold a sample.
#[inline(always)]
fn lanes_with_samples(layer: &CameraLayer, row: usize) -> impl Iterator<Item = u32> + '_ {
    (0..layer.width)
        .step_by(LANES)
        .map(move |column| lanes_at(layer, (column, row), |level| level != NO_SAMPLE))
}

impl Summons<'_> {
    /// Asks every rival about the samples of a level in a row.
    #[inline(always)]
    fn call_row(
        &self,
        camera: usize,
        (row, level): (usize, SpanLevel),
        rivals: &mut [OtherCamera<'_>],
        ways: &mut [Carried],
        found: &mut Vec<Summoned>,
    ) {
        let layer = &self.layers[camera];
        let blocks: Vec<(usize, u32, PixelRun)> = (0..layer.width)
            .step_by(LANES)
            .enumerate()
            .map(|(at, column)| (at, lanes_at(layer, (column, row), |found| found == level)))
            .filter(|(_, lanes)| *lanes != 0)
            .map(|(at, lanes)| (at, lanes, PixelRun::new(layer, at * LANES, row, lanes)))
            .collect();
        for rival in rivals {
            let target = &self.layers[rival.camera];
            let limits = rival.limits.at_level(level).with_deeper(level + 1 < self.levels);
            for ((at, _, block), way) in blocks.iter().zip(&mut *ways) {
                way.bits = [0; LANES];
                if rival.may_see[*at] {
                    *way = rival.registration.carry(block, target.width);
                    way.prefetch_ranks(target);
                    way.prefetch(target);
                }
            }
            for ((at, lanes, block), way) in blocks.iter().zip(&*ways) {
                self.call_block((camera, at * LANES, *lanes, block), (rival, &limits), way, found);
            }
        }
    }

    #[inline(always)]
    fn call_block(
        &self,
        (camera, left, lanes, block): (usize, usize, u32, &PixelRun),
        (rival, limits): (&OtherCamera<'_>, &SameSurface),
        way: &Carried,
        found: &mut Vec<Summoned>,
    ) {
        let (source, target) = (&self.layers[camera], &self.layers[rival.camera]);
        let mut wanted = [0; LANES];
        let mut any = 0;
        for i in 0..LANES {
            wanted[i] = u32::from(way.bits[i] & IN_VIEW != 0);
            any |= wanted[i];
        }
        if any == 0 {
            return;
        }
        let mut needs = Needs::new(self.few_steps);
        let answers = limits.compare_telling::<LANES, true>(
            rival.registration,
            (source, block),
            (target, way),
            wanted,
            &mut needs,
        );
        for lane in (0..LANES).filter(|lane| lanes >> lane & 1 == 1 && answers.is_same(*lane)) {
            let pixel = answers.pixel[lane];
            let ranks = target.ranks[pixel as usize];
            if self.settings.pruning.mixed_pixels == MixedPixels::Drop && ranks.rank & MIXED != 0 {
                continue;
            }
            let verdict = Verdict {
                rule: Rule::BestRate,
                witness_level: answers.level[lane] as SpanLevel,
                witness_camera: rival.camera as u16,
                witness_pixel: pixel,
            };
            let claimant = Claimant { verdict, needs: codes_of(&needs, lane), place: BEHIND, is_sure: false };
            found.push(Summoned { x: (left + lane) as u32, ranks, claimant });
        }
    }

    /// Orders the claimants of a sample, best first, and tells each how it compares with the sample. Gives the flags of the
    /// sample's count.
    #[inline(always)]
    fn compare_ranks(&self, (camera, pixel): (usize, usize), claimants: &mut [Summoned]) -> u16 {
        let own = self.layers[camera].ranks[pixel];
        let name = camera as u16;
        let flags =
            if self.layers[camera].level[pixel] != NO_SAMPLE && own.rank & MIXED != 0 { IS_MIXED } else { 0 };
        let of = |summoned: &Summoned| summoned.claimant.verdict.witness_camera;
        claimants.sort_unstable_by_key(|summoned| (summoned.ranks.rank, of(summoned)));
        let mut any_better = false;
        for index in 0..claimants.len() {
            let this = claimants[index];
            let otherwise = (this.ranks.other_rank, of(&this));
            if (this.ranks.rank, of(&this)) < (own.rank, name) {
                claimants[index].claimant.verdict.rule =
                    rule_between(self.settings.pruning.method, own.rank, this.ranks.rank);
                any_better = true;
            }
            if otherwise < (own.other_rank, name) {
                let ahead = claimants.iter().filter(|other| (other.ranks.other_rank, of(other)) < otherwise);
                claimants[index].claimant.place = ahead.count() as u8;
            }
        }
        self.beatable[camera][pixel].store(any_better, Ordering::Relaxed);
        flags
    }

    /// Leaves out the claimants that are covered by better ones, and finds out where the rate models may disagree.
    fn leave_out(&self, lists: &mut Lists, layer: &CameraLayer, first_row: usize, least: Codes) {
        let all = std::mem::take(&mut lists.claimants);
        let mut kept: Vec<Claimant> = Vec::with_capacity(all.len());
        let mut next = 0;
        for (place, count) in lists.counts.iter_mut().enumerate() {
            let x = place % layer.width;
            if x.is_multiple_of(LANES) {
                lists.first[place / layer.width * layer.width.div_ceil(LANES) + x / LANES] =
                    kept.len() as u32;
            }
            let listed = &all[next..next + usize::from(*count & COUNT)];
            next += listed.len();
            let own_level = layer.level[first_row * layer.width + place];
            let from = kept.len();
            for claimant in listed {
                let covered = kept[from..].iter().any(|better| {
                    better.is_sure
                        && better.place.min(BEHIND - 1) < claimant.place
                        && better.covers(claimant, least)
                });
                if !covered {
                    let is_sure =
                        claimant.verdict.witness_level == own_level && !self.is_beatable(claimant.verdict);
                    kept.push(Claimant { is_sure, ..*claimant });
                }
            }
            let left = &kept[from..];
            *count = *count & IS_MIXED | left.len() as u16 | if is_disputable(left) { DISPUTABLE } else { 0 };
        }
        kept.shrink_to_fit();
        lists.claimants = kept;
    }

    fn is_beatable(&self, claim: Verdict) -> bool {
        self.beatable[usize::from(claim.witness_camera)][claim.witness_pixel as usize].load(Ordering::Relaxed)
    }
}

/// Whether, of the claimants of a sample in their order, another may be ahead by the other rate model.
fn is_disputable(claimants: &[Claimant]) -> bool {
    let in_order = claimants.windows(2).all(|pair| pair[0].place <= pair[1].place);
    let alike = claimants.iter().all(|claimant| claimant.is_better() == (claimant.place != BEHIND));
    !(in_order && alike)
}

/// Sorts by column, keeping the order within each, and counts.
#[inline(always)]
fn sort_by_column(found: &[Summoned], counts: &mut [u16], sorted: &mut Vec<Summoned>) {
    for summoned in found {
        counts[summoned.x as usize] += 1;
    }
    let mut ends = Vec::with_capacity(counts.len());
    let mut end = 0_usize;
    for &count in counts.iter() {
        ends.push(end);
        end += usize::from(count);
    }
    sorted.clear();
    if let Some(&any) = found.first() {
        sorted.resize(found.len(), any);
    }
    for summoned in found {
        let at = &mut ends[summoned.x as usize];
        sorted[*at] = *summoned;
        *at += 1;
    }
}
