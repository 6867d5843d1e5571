//! Building the candidate lists of a frame: every sample is reprojected into every other camera, and all that may show its
//! point are listed.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use rayon::prelude::*;

use super::candidate_lists::{
    BandCandidates, COUNT, CandidateLists, Codes, IS_MIXED, ListedCandidate, ToleranceRange, codes, codes_of,
    least_tolerant, most_tolerant,
};
use crate::capture::overlap::OverlapGraph;
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::agreement::VoteTest;
use crate::preprocess::layers::{CameraLayer, Rank, is_mixed};
use crate::preprocess::pruning::{
    BAND_ROWS, ColumnBounds, OtherCamera, Rule, Verdict, is_better, is_dropped_as_mixed, lanes_at,
    other_cameras, rule_of_dropped,
};
use crate::preprocess::registration::{
    IN_VIEW, PixelRun, ReprojectedRun, RequiredTolerances, SameSurface, SourceRun, TargetRun,
};
use crate::preprocess::temporal::{NO_SAMPLE, ROOT, SpanLevel};
use crate::samples::VoteCounts;
use crate::settings::Settings;
use crate::simd::{self, LANES, VectorLoop};

/// The candidate lists of a frame with this number of `levels`, for tolerances around those of `settings`; `None` where they would take
/// more than `bytes`, or a sample could have more candidates than are counted.
pub(crate) fn build_lists(
    pairs: &OverlapGraph<'_>,
    layers: &[CameraLayer],
    levels: usize,
    settings: &Settings,
    bytes: usize,
    job: &Job,
) -> Result<Option<CandidateLists>> {
    if layers.len() > usize::from(COUNT) {
        return Ok(None);
    }
    let range = ToleranceRange::around(&settings.pruning);
    let least = codes(range.least);
    // At the largest tolerance the fewest things count as thin.
    let votes = VoteTest::new(&least_tolerant(settings), ROOT)
        .thin_beyond(most_tolerant(settings).pruning.depth_tolerance);
    let settings = most_tolerant(settings);
    let builder = ListBuilder {
        pairs,
        layers,
        levels: levels as SpanLevel,
        settings: &settings,
        limits: SameSurface::new(&settings),
        negligible_steps: range.least[2] / 2.0,
        votes,
        may_be_beaten: layers
            .iter()
            .map(|layer| layer.level.iter().map(|_| AtomicBool::new(false)).collect())
            .collect(),
        room: AtomicUsize::new(bytes / size_of::<ListedCandidate>()),
    };
    let bands = layers.iter().enumerate().flat_map(|(camera, layer)| {
        let height = layer.height();
        (0..height).step_by(BAND_ROWS).map(move |row| (camera, row..(row + BAND_ROWS).min(height)))
    });
    let bands: Vec<(usize, Range<usize>)> = bands.collect();
    let found = bands.par_iter().map(|(camera, rows)| {
        job.check()?;
        Ok(simd::run(BandBuilder { builder: &builder, camera: *camera, rows: rows.clone() }))
    });
    let found: Vec<Option<BandCandidates>> = found.collect::<Result<_>>()?;
    let Some(mut all) = found.into_iter().collect::<Option<Vec<BandCandidates>>>() else { return Ok(None) };
    all.par_iter_mut().zip(&bands).for_each(|(band, (camera, rows))| {
        builder.drop_covered(band, &layers[*camera], rows.start, least);
    });
    let mut by_camera: Vec<Vec<BandCandidates>> = layers.iter().map(|_| Vec::new()).collect();
    for (of_band, (camera, _)) in all.into_iter().zip(bands) {
        by_camera[camera].push(of_band);
    }
    Ok(Some(CandidateLists { range, bands: by_camera }))
}

/// What all bands share.
struct ListBuilder<'a> {
    pairs: &'a OverlapGraph<'a>,
    layers: &'a [CameraLayer],
    levels: SpanLevel,
    settings: &'a Settings,
    limits: SameSurface,
    /// See [`RequiredTolerances::negligible_steps`].
    negligible_steps: f32,
    /// Whether other cameras contradict a sample, at the least tolerances and the least margin.
    votes: VoteTest,
    /// Per sample, whether any other camera may have a better one, or enough of them may contradict it.
    may_be_beaten: Vec<Vec<AtomicBool>>,
    /// How many more candidates memory has room for.
    room: AtomicUsize,
}

/// Lists all candidates of the samples of a band; `None` where there is no room.
struct BandBuilder<'a> {
    builder: &'a ListBuilder<'a>,
    camera: usize,
    rows: Range<usize>,
}

/// A candidate of the sample in column `x`, before it is known how it compares.
#[derive(Clone, Copy)]
struct FoundCandidate {
    x: u32,
    rank: Rank,
    candidate: ListedCandidate,
}

impl VectorLoop for BandBuilder<'_> {
    type Output = Option<BandCandidates>;

    #[inline(always)]
    fn run(self) -> Option<BandCandidates> {
        let Self { builder, camera, rows } = self;
        let layer = &builder.layers[camera];
        let columns = layer.width.div_ceil(LANES);
        let mut bounds = ColumnBounds::new(layer.width);
        for row in rows.clone() {
            let depths = &layer.inverse_depth[row * layer.width..][..layer.width];
            depths.iter().enumerate().for_each(|(x, inverse_depth)| bounds.add(x / LANES, *inverse_depth));
        }
        let mut others =
            other_cameras(builder.pairs, builder.layers, camera, rows.clone(), &bounds, |other| {
                builder.limits.between(layer, &builder.layers[other])
            });
        let mut lists = BandCandidates {
            first: Vec::with_capacity(rows.len() * columns),
            counts: vec![0; rows.len() * layer.width],
            candidates: Vec::new(),
        };
        let mut reprojected: Vec<ReprojectedRun> = (0..columns).map(|_| ReprojectedRun::NOWHERE).collect();
        let (mut row_of, mut sorted) = (Vec::new(), Vec::new());
        for (index, row) in rows.enumerate() {
            row_of.clear();
            for level in (0..builder.levels)
                .filter(|level| layer.level[row * layer.width..][..layer.width].contains(level))
            {
                builder.find_in_row(camera, row, level, &mut others, &mut reprojected, &mut row_of);
            }
            let counts = &mut lists.counts[index * layer.width..][..layer.width];
            sort_by_column(&row_of, counts, &mut sorted);
            if builder
                .room
                .fetch_update(Ordering::Relaxed, Ordering::Relaxed, |room| room.checked_sub(sorted.len()))
                .is_err()
            {
                return None;
            }
            let mut rest = &mut sorted[..];
            for (x, count) in counts.iter_mut().enumerate() {
                if x.is_multiple_of(LANES) {
                    lists.first.push(lists.candidates.len() as u32);
                }
                let (own, others) = rest.split_at_mut(usize::from(*count));
                rest = others;
                *count |= builder.compare_ranks(camera, row * layer.width + x, own);
                lists.candidates.extend(own.iter().map(|found| found.candidate));
            }
        }
        Some(lists)
    }
}

/// Sixteen pixels of a row whose candidates are listed.
struct ListedRun {
    /// Which sixteen columns these are.
    nth: usize,
    /// Which of them hold a sample of the level.
    lanes: u32,
    pixels: PixelRun,
}

impl ListBuilder<'_> {
    /// Lists the candidates in all other cameras of the samples of a level in a row.
    #[inline(always)]
    fn find_in_row(
        &self,
        camera: usize,
        row: usize,
        level: SpanLevel,
        others: &mut [OtherCamera<'_>],
        reprojected: &mut [ReprojectedRun],
        found: &mut Vec<FoundCandidate>,
    ) {
        let layer = &self.layers[camera];
        let blocks: Vec<ListedRun> = (0..layer.width)
            .step_by(LANES)
            .enumerate()
            .map(|(nth, column)| (nth, lanes_at(layer, (column, row), |found| found == level)))
            .filter(|(_, lanes)| *lanes != 0)
            .map(|(nth, lanes)| ListedRun {
                nth,
                lanes,
                pixels: PixelRun::new(layer, nth * LANES, row, lanes),
            })
            .collect();
        for other in others {
            let target = &self.layers[other.camera];
            let limits = other.limits.at_level(level).with_deeper(level + 1 < self.levels);
            for (block, run) in blocks.iter().zip(&mut *reprojected) {
                run.bits = [0; LANES];
                if other.may_see[block.nth] {
                    *run = other.registration.reproject(&block.pixels, target.width);
                    run.prefetch_ranks(target);
                    run.prefetch(target);
                }
            }
            for (block, run) in blocks.iter().zip(&*reprojected) {
                self.find_in_run(layer, block, other, &limits, run, found);
            }
        }
    }

    #[inline(always)]
    fn find_in_run(
        &self,
        source: &CameraLayer,
        block: &ListedRun,
        other: &OtherCamera<'_>,
        limits: &SameSurface,
        run: &ReprojectedRun,
        found: &mut Vec<FoundCandidate>,
    ) {
        let (ListedRun { nth, lanes, pixels }, target) = (block, &self.layers[other.camera]);
        let mut relevant = [0; LANES];
        let mut any = 0;
        for i in 0..LANES {
            relevant[i] = u32::from(run.bits[i] & IN_VIEW != 0);
            any |= relevant[i];
        }
        if any == 0 {
            return;
        }
        let mut required = RequiredTolerances::new(self.negligible_steps);
        let matches = limits.compare_measuring::<LANES, true>(
            other.registration,
            SourceRun::of_layer(source, pixels),
            TargetRun { layer: target, reprojected: run },
            relevant,
            &mut required,
        );
        for lane in (0..LANES).filter(|lane| lanes >> lane & 1 == 1 && matches.is_same(*lane)) {
            let pixel = matches.pixel[lane];
            let rank = target.ranks[pixel as usize];
            if is_dropped_as_mixed(self.settings.pruning.mixed_pixels, rank) {
                continue;
            }
            let verdict = Verdict {
                rule: Rule::BestRate,
                witness_level: matches.level[lane] as SpanLevel,
                witness_camera: other.camera as u16,
                witness_pixel: pixel,
            };
            let required = codes_of(&required, lane);
            let candidate = ListedCandidate { verdict, required, is_sure: false };
            found.push(FoundCandidate { x: (nth * LANES + lane) as u32, rank, candidate });
        }
    }

    /// Orders the candidates of a sample, best first, and notes how each compares with the sample. Gives the flags of the
    /// sample's count.
    #[inline(always)]
    fn compare_ranks(&self, camera: usize, pixel: usize, candidates: &mut [FoundCandidate]) -> u16 {
        let own = self.layers[camera].ranks[pixel];
        let flags = if self.layers[camera].level[pixel] != NO_SAMPLE && is_mixed(own) { IS_MIXED } else { 0 };
        let of = |found: &FoundCandidate| found.candidate.verdict.witness_camera;
        candidates.sort_unstable_by_key(|found| (found.rank, of(found)));
        let mut any_better = false;
        for this in candidates {
            if is_better(this.rank, u32::from(of(this)), own, camera as u32) {
                this.candidate.verdict.rule = rule_of_dropped(self.settings.pruning.method, own, this.rank);
                any_better = true;
            }
        }
        let may_be_dropped = any_better || self.may_be_contradicted(camera, pixel);
        self.may_be_beaten[camera][pixel].store(may_be_dropped, Ordering::Relaxed);
        flags
    }

    /// Drops the candidates that better ones dominate.
    fn drop_covered(&self, lists: &mut BandCandidates, layer: &CameraLayer, first_row: usize, least: Codes) {
        let all = std::mem::take(&mut lists.candidates);
        let mut kept: Vec<ListedCandidate> = Vec::with_capacity(all.len());
        let mut next = 0;
        for (index, count) in lists.counts.iter_mut().enumerate() {
            let x = index % layer.width;
            if x.is_multiple_of(LANES) {
                lists.first[index / layer.width * layer.width.div_ceil(LANES) + x / LANES] =
                    kept.len() as u32;
            }
            let listed = &all[next..next + usize::from(*count & COUNT)];
            next += listed.len();
            let own_level = layer.level[first_row * layer.width + index];
            let from = kept.len();
            for candidate in listed {
                let covered =
                    kept[from..].iter().any(|better| better.is_sure && better.covers(candidate, least));
                if !covered {
                    let is_sure =
                        candidate.verdict.witness_level == own_level && !self.is_beatable(candidate.verdict);
                    kept.push(ListedCandidate { is_sure, ..*candidate });
                }
            }
            *count = *count & IS_MIXED | (kept.len() - from) as u16;
        }
        kept.shrink_to_fit();
        lists.candidates = kept;
    }

    /// Whether any tolerances and margin that the lists serve let other cameras contradict a sample.
    fn may_be_contradicted(&self, camera: usize, pixel: usize) -> bool {
        let level = self.layers[camera].level[pixel];
        if level == NO_SAMPLE || !self.votes.is_on() {
            return false;
        }
        // Larger tolerances let more cameras confirm and fewer look past. Confirmations are left out, because other tolerances need not give
        // them.
        let counts = self.votes.at_level(level).counts(self.pairs, self.layers, camera, pixel as u32);
        let is_flying = self.layers[camera].packed_colors[pixel].is_flying();
        self.votes.is_contradicted(VoteCounts { confirm: 0, ..counts }, is_flying)
    }

    fn is_beatable(&self, candidate: Verdict) -> bool {
        self.may_be_beaten[usize::from(candidate.witness_camera)][candidate.witness_pixel as usize]
            .load(Ordering::Relaxed)
    }
}

/// Sorts by column, keeping the order within each, and counts.
#[inline(always)]
fn sort_by_column(found: &[FoundCandidate], counts: &mut [u16], sorted: &mut Vec<FoundCandidate>) {
    for found in found {
        counts[found.x as usize] += 1;
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
    for found in found {
        let at = &mut ends[found.x as usize];
        sorted[*at] = *found;
        *at += 1;
    }
}
