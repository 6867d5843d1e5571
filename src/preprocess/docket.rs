//! The docket of a frame: for every sample those of other cameras that may stand for it, found once for a range of tolerances.
//!
//! Where a sample lies in the other cameras' pictures, how far it is from the surface found there, how much normals and colors
//! differ: no tolerance touches any of that. Whoever turns a threshold prunes the same frame again and again; from the docket
//! that is a walk over lists instead of a search in every picture. What differs from [`super::contest`]: nothing in the verdicts.
//!
//! ```text
//! sample ─▶ claimants, best first: (verdict if it stands, the tolerances from which on it does)
//! ```
//!
//! A list leaves out whom a better claimant covers: one that holds whenever the other does, and that nothing is better than,
//! so that it is surely kept. Nearly always one is left.

use super::claimant::{BEHIND, Claimant, Codes, Holds, Tolerances, codes, tolerances};
use super::inspection::{Rule, Verdict};
use super::layer::{Layer, Level};
use super::pruning::{BAND_ROWS, Band, DROPPED, Dispute, KEPT, Pass};
use super::registration::{LANES, Outcome};
use super::settle::Candidate;
use crate::settings::{PruningSettings, Settings};

/// How far a tolerance may be turned, either way, before the lists have to be made anew.
const RANGE: f32 = 4.0;

/// The claimants of every sample of a frame.
#[derive(Debug)]
pub(super) struct Docket {
    pub(super) reach: Reach,
    /// Per camera, per band of rows.
    pub(super) lists: Vec<Vec<Lists>>,
}

/// Which settings a docket serves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reach {
    pub(super) least: Tolerances,
    pub(super) most: Tolerances,
    overlap: bool,
}

impl Reach {
    /// Tolerances around those of `settings`.
    pub(super) fn around(settings: &PruningSettings) -> Self {
        Self {
            least: tolerances(&scaled(settings, 1.0 / RANGE)),
            most: tolerances(&scaled(settings, RANGE)),
            overlap: settings.overlap,
        }
    }

    /// Whether a docket that reaches so far serves `settings`.
    pub(super) fn serves(&self, settings: &PruningSettings) -> bool {
        let wanted = tolerances(settings);
        let within = (0..3).all(|i| self.least[i] <= wanted[i] && wanted[i] <= self.most[i]);
        within && self.overlap == settings.overlap
    }
}

fn scaled(settings: &PruningSettings, factor: f32) -> PruningSettings {
    let mut scaled = settings.clone();
    scaled.depth_tolerance *= factor;
    scaled.normal_tolerance = (settings.normal_tolerance * factor).min(180.0);
    scaled.color_tolerance *= factor;
    scaled
}

/// The most tolerant settings that a docket around `settings` serves.
pub(super) fn most_tolerant(settings: &Settings) -> Settings {
    Settings { pruning: scaled(&settings.pruning, RANGE), ..settings.clone() }
}

/// The claimants of the samples of some rows of one camera.
#[derive(Debug, Default)]
pub(super) struct Lists {
    /// Where those of each sixteen pixels begin.
    pub(super) first: Vec<u32>,
    /// Per pixel, how many claimants it has, with flags.
    pub(super) counts: Vec<u16>,
    pub(super) claimants: Vec<Claimant>,
}

/// Set in a count where the two rate models may name different winners.
pub(super) const DISPUTABLE: u16 = 1 << 15;
/// Set in a count where the sample's own color is mixed.
pub(super) const IS_MIXED: u16 = 1 << 14;
/// The rest of a count.
pub(super) const COUNT: u16 = IS_MIXED - 1;

impl Lists {
    /// The claimants of a pixel of the band, by its place in it.
    fn of(&self, place: usize, width: usize) -> &[Claimant] {
        let columns = width.div_ceil(LANES);
        let (row, x) = (place / width, place % width);
        let before = &self.counts[place - x % LANES..place];
        let skipped: usize = before.iter().map(|count| usize::from(count & COUNT)).sum();
        let first = self.first[row * columns + x / LANES] as usize + skipped;
        &self.claimants[first..first + usize::from(self.counts[place] & COUNT)]
    }
}

impl Docket {
    /// Bytes held in memory.
    pub(super) fn bytes(&self) -> usize {
        let of_lists = |lists: &Lists| {
            size_of_val(&*lists.first) + size_of_val(&*lists.counts) + size_of_val(&*lists.claimants)
        };
        self.lists.iter().flatten().map(of_lists).sum()
    }
}

/// The best candidate of every sample of a band, from the docket.
pub(super) fn find_best(pass: &Pass<'_>, docket: &Docket, band: &mut Band<'_>) {
    let rows = band.rows.clone();
    let layer = &pass.layers[band.camera];
    let lists = &docket.lists[band.camera][rows.start / BAND_ROWS];
    let limits = codes(tolerances(&pass.settings.pruning));
    let mut next = 0;
    for (block, &first) in lists.first.iter().enumerate() {
        let columns = layer.width.div_ceil(LANES);
        let (row, left) = (block / columns, block % columns * LANES);
        let width = LANES.min(layer.width - left);
        let (start, place) = ((rows.start + row) * layer.width + left, row * layer.width + left);
        let levels = &layer.level[start..start + width];
        if !levels.contains(&pass.decide) {
            continue;
        }
        let mut first = first as usize;
        for (i, (&level, &count)) in levels.iter().zip(&lists.counts[place..place + width]).enumerate() {
            let claimants = &lists.claimants[first..first + usize::from(count & COUNT)];
            first += claimants.len();
            if level != pass.decide {
                continue;
            }
            let pixel = (start + i) as u32;
            band.mixed += u64::from(count & IS_MIXED != 0);
            band.pixels[next] = pixel;
            band.verdicts[next] = first_verdict(pass, band, (pixel, count), claimants, &limits);
            next += 1;
        }
    }
}

/// The verdict on a sample if its best candidate is kept. Keeps the sample where there is none.
#[inline(always)]
fn first_verdict(
    pass: &Pass<'_>,
    band: &mut Band<'_>,
    (pixel, count): (u32, u16),
    claimants: &[Claimant],
    limits: &Codes,
) -> Verdict {
    let camera = band.camera;
    // Only a mixed sample may be dropped before anything is decided.
    if count & IS_MIXED != 0 && pass.status(camera, pixel) == DROPPED {
        return Verdict::without_witness(Rule::MixedDropped);
    }
    let mut best: Option<&Claimant> = None;
    let mut other: Option<&Claimant> = None;
    for claimant in claimants {
        if !holds(pass, camera, pixel, claimant, limits) || !stands(pass, &claimant.verdict) {
            continue;
        }
        best = best.or(Some(claimant));
        if count & DISPUTABLE == 0 {
            break;
        }
        if claimant.place < other.map_or(BEHIND, |other| other.place) {
            other = Some(claimant);
        }
    }
    let better = best.filter(|best| best.is_better());
    if count & DISPUTABLE != 0 {
        let of = |winner: Option<&Claimant>| winner.map_or(camera as u16, |w| w.verdict.witness_camera);
        let winners = [of(better), of(other)];
        if winners[0] != winners[1] {
            band.disputes.push(Dispute { pixel, camera: winners[0], other_camera: winners[1] });
        }
    }
    if let Some(better) = better {
        return better.verdict;
    }
    pass.set_status(camera, pixel, KEPT);
    Verdict::without_witness(if best.is_some() { Rule::BestRate } else { Rule::OnlyWitness })
}

/// Whether a claimant may stand for others, as far as is known before anything of this level is decided.
#[inline(always)]
fn stands(pass: &Pass<'_>, claim: &Verdict) -> bool {
    claim.witness_level == pass.decide
        || (pass.settings.pruning.across_spans
            && pass.status(claim.witness_camera.into(), claim.witness_pixel) == KEPT)
}

/// Whether a claimant shows the sample's point.
#[inline(always)]
fn holds(pass: &Pass<'_>, camera: usize, pixel: u32, claimant: &Claimant, limits: &Codes) -> bool {
    match claimant.holds(limits) {
        Holds::Yes => true,
        Holds::No => false,
        Holds::Ask => ask(pass, camera, pixel, claimant),
    }
}

#[cold]
#[inline(never)]
fn ask(pass: &Pass<'_>, camera: usize, pixel: u32, claimant: &Claimant) -> bool {
    let (layer, other) = (&pass.layers[camera], usize::from(claimant.verdict.witness_camera));
    let (x, y) = (pixel as usize % layer.width, pixel as usize / layer.width);
    let outcome = pass.rig.registration(camera, other).test(layer, &pass.layers[other], x, y, &pass.limits);
    outcome == Outcome::Same(claimant.verdict.witness_pixel)
}

/// All candidates of a sample but the best, worst first.
pub(super) fn all_but_the_best(
    pass: &Pass<'_>,
    docket: &Docket,
    camera: usize,
    pixel: u32,
) -> Vec<Candidate> {
    let layer: &Layer = &pass.layers[camera];
    let band = pixel as usize / (BAND_ROWS * layer.width);
    let place = pixel as usize % (BAND_ROWS * layer.width);
    let limits = codes(tolerances(&pass.settings.pruning));
    let claimants = docket.lists[camera][band].of(place, layer.width).iter();
    let held = claimants
        .take_while(|claimant| claimant.is_better())
        .filter(|claimant| holds(pass, camera, pixel, claimant, &limits) && stands(pass, &claimant.verdict));
    let mut candidates: Vec<Candidate> = held.skip(1).map(|claimant| candidate(pass, claimant)).collect();
    candidates.reverse();
    candidates
}

fn candidate(pass: &Pass<'_>, claimant: &Claimant) -> Candidate {
    let Verdict { witness_camera: camera, witness_pixel: pixel, witness_level: level, .. } = claimant.verdict;
    let level: Level = level;
    Candidate { rank: pass.layers[usize::from(camera)].ranks[pixel as usize].rank, camera, pixel, level }
}
