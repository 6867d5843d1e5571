//! Units and lenses under which the pictures of the views agree far better than as the capture is read.
//!
//! Purpose and source: see `picture_agreement`. Poses and the measure of depth are what `verdict` made of them: they show in depth.

use std::sync::Arc;

use rayon::prelude::*;

use super::agreement::Comparison;
use super::picture_agreement::PictureComparison;
use super::reading::{LensReading, Reading};
use super::search::{UNITS, three_digits};
use super::verdict::{
    Alternative, ConventionVerdict, Evidence, Finding, ReadingPart, Undecided, keys, number,
};
use crate::capture::frame::Frame;

/// Patches of each pair that sort the readings, and that decide.
const FEW: usize = 48;
const ALL: usize = usize::MAX;
/// With fewer patches a correlation is chance.
const LEAST_PATCHES: usize = 200;
/// A correlation below this is chance.
const NOT_CHANCE: f64 = 0.15;
/// Another unit is believed if it fits this many times as well. So is another lens: it bends views, and patches meet look-alikes by
/// chance. Among 200 exact scenes, four have a lens that fits 1.4 to 1.6 times as well.
const UNIT_DECIDES: f64 = 1.4;
const LENS_DECIDES: f64 = 1.8;
/// Both have to fit better by this much, and by this many standard errors of the pairs: some pairs see nothing in common.
const LEAST_GAIN: f64 = 0.08;
const STANDARD_ERRORS: f64 = 2.0;
/// Readings that fit this share as well as the best are as good.
const EQUAL: f64 = 0.95;
/// Focal lengths nearer to those claimed are left to the alignment of cameras, as a ratio; principal points, as a share of the picture.
const LEAST_FOCAL: f64 = 1.06;
const LEAST_CENTER: f64 = 0.05;

/// What depth says, unless pictures say more.
pub(super) fn refined(finding: Finding, comparison: &Comparison, frames: &[Arc<Frame>]) -> Finding {
    let unit_is_open = match &finding.verdict {
        ConventionVerdict::Other(_) => false,
        ConventionVerdict::Stands { undecided } => {
            undecided.iter().any(|open| open.part == ReadingPart::Unit)
        }
        ConventionVerdict::Unknown { .. } => true,
    };
    let pictures = PictureComparison::new(comparison, frames);
    if pictures.patch_count() < LEAST_PATCHES {
        return finding;
    }
    let claimed = comparison.claimed;
    // Depth through a wrong lens may agree under poses and measures that mean nothing.
    let by_depth = finding.alternative().map(|other| pictures.correlations(&other.reading, ALL));
    let as_read = pictures.correlations(&claimed, ALL);
    let rivals: Vec<&Vec<f64>> = by_depth.iter().chain([&as_read]).collect();
    if rivals.iter().any(|rival| mean(rival) * UNIT_DECIDES >= 1.0) {
        return finding;
    }
    let is_believed = |reading: &Reading| {
        let found = pictures.correlations(reading, ALL);
        let decides = if reading.lens == claimed.lens { UNIT_DECIDES } else { LENS_DECIDES };
        differs(reading, &claimed) && rivals.iter().all(|rival| is_better(&found, rival, decides))
    };
    let units = if unit_is_open && !claimed.measure.is_buffer() { other_units(&claimed) } else { Vec::new() };
    let believed = [other_lenses(&claimed), units].into_iter().filter_map(|readings| {
        let (coarse, _) = scored(&pictures, &readings, FEW).into_iter().next()?;
        let near = scored_near(&pictures, &coarse);
        near.first().is_some_and(|(reading, _)| is_believed(reading)).then_some(near)
    });
    let Some(best) = believed.max_by(|a, b| a[0].1.total_cmp(&b[0].1)) else { return finding };
    let verdict = ConventionVerdict::Other(Box::new(alternative(comparison, &best, mean(&as_read))));
    Finding { verdict, ..finding }
}

/// Whether the pairs agree that a reading fits better, by this factor at least.
fn is_better(other: &[f64], as_read: &[f64], decides: f64) -> bool {
    let gains: Vec<f64> = other.iter().zip(as_read).map(|(other, as_read)| other - as_read).collect();
    let gain = mean(&gains);
    let count = gains.len() as f64;
    let square: f64 = gains.iter().map(|value| (value - gain) * (value - gain)).sum();
    let error = (square / (count * (count - 1.0).max(1.0))).sqrt();
    let best = mean(other);
    best >= NOT_CHANCE && best >= decides * mean(as_read) && gain > LEAST_GAIN.max(STANDARD_ERRORS * error)
}

/// Whether two readings differ by more than an alignment of cameras would find.
fn differs(reading: &Reading, claimed: &Reading) -> bool {
    let focal = reading.lens.focal.max(reading.lens.focal.recip());
    let center = reading.lens.center.iter().fold(0.0_f64, |most, shift| most.max(shift.abs()));
    reading.unit != claimed.unit || focal > LEAST_FOCAL || center > LEAST_CENTER
}

/// Focal lengths from a third to three times those claimed; lenses of pictures of other sizes; principal points.
fn other_lenses(claimed: &Reading) -> Vec<Reading> {
    const STEP: f64 = 1.04;
    const STEPS: i32 = 28;
    const SIZES: [f64; 8] = [0.25, 1.0 / 3.0, 0.5, 2.0 / 3.0, 1.5, 2.0, 3.0, 4.0];
    const SHIFTS: [f64; 9] = [-0.25, -0.1875, -0.125, -0.0625, 0.0, 0.0625, 0.125, 0.1875, 0.25];
    let focal = (-STEPS..=STEPS).map(|step| LensReading { focal: STEP.powi(step), ..LensReading::default() });
    // A principal point in the middle of a picture of another size.
    let sizes = SIZES.map(|size| LensReading { focal: size, center: [0.5 * size - 0.5; 2] });
    let centers = SHIFTS.iter().flat_map(|&x| SHIFTS.map(|y| LensReading { focal: 1.0, center: [x, y] }));
    let all = focal.chain(sizes).chain(centers).filter(|lens| *lens != LensReading::default());
    all.map(|lens| Reading { lens, ..*claimed }).collect()
}

/// Common units, and those up to a hundred times as large and as small as the claimed one.
fn other_units(claimed: &Reading) -> Vec<Reading> {
    const STEP: f64 = 1.1;
    const STEPS: i32 = 48;
    let near = (-STEPS..=STEPS).map(|step| three_digits(claimed.unit * STEP.powi(step)));
    UNITS.into_iter().chain(near).map(|unit| Reading { unit, ..*claimed }).collect()
}

/// A reading with those beside it, the best first; before it what is simpler and as good: a common unit, the claimed focal length.
fn scored_near(pictures: &PictureComparison, coarse: &Reading) -> Vec<(Reading, f64)> {
    let is_lens = coarse.lens != LensReading::default();
    let readings = if is_lens { lenses_near(coarse) } else { units_near(coarse) };
    let mut scored = scored(pictures, &readings, ALL);
    let enough = EQUAL * scored.first().map_or(0.0, |(_, score)| *score);
    let rank = |reading: &Reading| {
        if is_lens {
            (reading.lens.focal == 1.0).then_some(0)
        } else {
            UNITS.iter().position(|common| *common == reading.unit)
        }
    };
    let as_good = (0..scored.len()).filter(|&index| scored[index].1 >= enough);
    if let Some((_, simple)) = as_good.filter_map(|index| Some((rank(&scored[index].0)?, index))).min() {
        scored.swap(0, simple);
    }
    scored
}

fn lenses_near(coarse: &Reading) -> Vec<Reading> {
    let focal = |step: i32| coarse.lens.focal * (1.0 + 0.01 * f64::from(step));
    let lens = |focal: f64| LensReading { focal, ..coarse.lens };
    let near = (-4..=4).map(focal).chain([1.0]);
    near.map(|focal| Reading { lens: lens(focal), ..*coarse }).collect()
}

fn units_near(coarse: &Reading) -> Vec<Reading> {
    let ratio = |unit: f64| (unit / coarse.unit).max(coarse.unit / unit);
    let near = (-10..=10).map(|step| three_digits(coarse.unit * 1.1_f64.powi(step)));
    let units = UNITS.into_iter().filter(|unit| ratio(*unit) < 3.0).chain(near);
    units.map(|unit| Reading { unit, ..*coarse }).collect()
}

/// Best first.
fn scored(pictures: &PictureComparison, readings: &[Reading], most: usize) -> Vec<(Reading, f64)> {
    let score = |&reading: &Reading| (reading, mean(&pictures.correlations(&reading, most)));
    let mut scored: Vec<(Reading, f64)> = readings.par_iter().map(score).collect();
    scored.sort_by(|a, b| b.1.total_cmp(&a.1));
    scored
}

fn alternative(comparison: &Comparison, near: &[(Reading, f64)], as_read: f64) -> Alternative {
    let (reading, score) = near[0];
    let claimed = comparison.claimed;
    let range = |value: fn(&Reading) -> f64| {
        let alike =
            near.iter().filter(|(_, other)| *other >= EQUAL * score).map(|(reading, _)| value(reading));
        alike.fold([f64::INFINITY, 0.0], |[least, most], value| [value.min(least), value.max(most)])
    };
    let mut undecided = Vec::new();
    let [least, most] = range(|reading| reading.unit);
    if reading.unit != claimed.unit && least < most {
        let why = format!("units from {} to {} fit about as well", number(least), number(most));
        undecided.push(Undecided { part: ReadingPart::Unit, why });
    }
    let [least, most] = range(|reading| reading.lens.focal);
    if reading.lens.focal != 1.0 && least < most {
        let why = format!("focal lengths of {least:.2} to {most:.2} times those claimed fit about as well");
        undecided.push(Undecided { part: ReadingPart::Lens, why });
    }
    Alternative {
        reading,
        score,
        margin: (score / as_read.max(1e-3)).min(99.0),
        undecided,
        keys: keys(comparison, &reading),
        evidence: Evidence::Pictures { as_read },
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}
