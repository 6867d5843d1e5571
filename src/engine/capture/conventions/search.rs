//! The search for readings under which views agree, in stages; each keeps what does not fall behind.

use rayon::prelude::*;

use super::agreement::Comparison;
use super::reading::Reading;
use super::views::POINTS;
use crate::capture::depth_claim::DepthMeasure;
use crate::capture::pose_convention::{CameraAxes, PoseConvention, PoseDirection};

/// Units that depth is written in: meters, centimeters, millimeters and tenths of them, feet, and the steps of TUM, D400 cameras at
/// 1/4 mm, Replica and KITTI.
pub(super) const UNITS: [f64; 10] =
    [1.0, 0.1, 1e-2, 1e-3, 1e-4, 0.3048, 1.0 / 5000.0, 1.0 / 4000.0, 1.0 / 6553.5, 1.0 / 256.0];

/// Measures that are tried in turn until one is found under which views agree: those of a group share their units.
const GROUPS: [&[DepthMeasure]; 3] = [
    &[DepthMeasure::PlanarZ, DepthMeasure::RayDistance, DepthMeasure::RayDistanceFromNearClip],
    &[DepthMeasure::InversePlanarZ, DepthMeasure::InverseRayDistance],
    &[DepthMeasure::WorldZ],
];

/// Points of each pair that sort out most readings, and most of the rest.
const FEW_POINTS: usize = 24;
const SOME_POINTS: usize = 80;
/// Readings that are left after the first and after the second sorting.
const FEW_LEFT: usize = 32;
const SOME_LEFT: usize = 10;
/// Tolerance of numbers, relative: in the search of poses and units, and in the choice of the measure.
pub(super) const WIDE: f64 = 0.03;
pub(super) const NARROW: f64 = 0.01;
/// Readings that score this are not chance; from the second on no other measure is tried.
pub(super) const NOT_CHANCE: f64 = 0.08;
const GOOD: f64 = 0.25;
/// A reading is kept that scores this share of the best.
const KEPT: f64 = 0.5;

/// A reading and its score.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scored {
    pub reading: Reading,
    pub score: f64,
}

/// The readings under which the views agree best, and the claimed one, each with its score at one tolerance; best first.
pub(super) fn search(comparison: &Comparison) -> Vec<Scored> {
    let found = of_all_groups(comparison);
    let mut readings: Vec<Reading> = vec![comparison.claimed];
    for scored in found {
        if !readings.contains(&scored.reading) {
            readings.push(scored.reading);
        }
    }
    let narrow = at_tolerance(comparison, &readings, NARROW);
    // Where depth is too noisy for the narrow tolerance, the wide one decides all.
    if best(&narrow) >= NOT_CHANCE { narrow } else { at_tolerance(comparison, &readings, WIDE) }
}

/// Poses, measures and units under which the views agree.
fn of_all_groups(comparison: &Comparison) -> Vec<Scored> {
    let mut found = Vec::new();
    for measures in ordered_groups(comparison.claimed.measure) {
        found.extend(of_group(comparison, &measures));
        if best(&found) >= GOOD {
            break;
        }
    }
    found.extend(nearby_units(comparison, &found));
    if best(&found) < NOT_CHANCE {
        found.extend(any_unit(comparison));
    }
    found
}

/// Whether the views agree as they are read.
pub(super) fn agrees_as_read(comparison: &Comparison) -> bool {
    comparison.score(&comparison.claimed, SOME_POINTS, WIDE) >= GOOD
}

/// Scores at one tolerance: by all points for readings that come near the best, by some of them for others.
fn at_tolerance(comparison: &Comparison, readings: &[Reading], tolerance: f64) -> Vec<Scored> {
    let mut scored = score_all(comparison, readings, SOME_POINTS, tolerance);
    let enough = KEPT * KEPT * best(&scored);
    let is_close = |s: &Scored| s.score >= enough || s.reading == comparison.claimed;
    let close: Vec<Reading> = scored.iter().filter(|s| is_close(s)).map(|s| s.reading).collect();
    scored.retain(|s| !is_close(s));
    scored.extend(score_all(comparison, &close, POINTS, tolerance));
    scored.sort_by(|a, b| b.score.total_cmp(&a.score));
    scored
}

/// The groups of measures, the claimed one's first and it first in its own.
fn ordered_groups(claimed: DepthMeasure) -> Vec<Vec<DepthMeasure>> {
    let mut groups: Vec<Vec<DepthMeasure>> = GROUPS.iter().map(|group| group.to_vec()).collect();
    if claimed.is_buffer() {
        groups.push(vec![DepthMeasure::ZBuffer, DepthMeasure::ReversedZBuffer]);
    }
    for group in &mut groups {
        group.sort_by_key(|measure| *measure != claimed);
    }
    groups.sort_by_key(|group| group[0] != claimed);
    groups
}

/// Poses, units and measures of a group under which the views agree.
fn of_group(comparison: &Comparison, measures: &[DepthMeasure]) -> Vec<Scored> {
    let mut placed: Vec<Scored> = Vec::new();
    // Distances along rays and along the axis differ little in the middle of a picture: one of them finds the pose as a rule.
    for &measure in measures.iter().take(2) {
        let few = score_all(comparison, &all_poses_and_units(comparison, measure), FEW_POINTS, WIDE);
        let enough = KEPT * best(&few) - 0.02;
        let kept = few.iter().take(FEW_LEFT).filter(|scored| scored.score > enough.max(0.0));
        let kept: Vec<Reading> = kept.map(|scored| scored.reading).collect();
        placed.extend(score_all(comparison, &kept, SOME_POINTS, WIDE));
        if best(&placed) >= GOOD {
            break;
        }
    }
    let enough = KEPT * best(&placed);
    placed.retain(|scored| scored.score >= enough && scored.score > 0.0);
    placed.sort_by(|a, b| b.score.total_cmp(&a.score));
    placed.truncate(SOME_LEFT);
    let measured = placed
        .iter()
        .flat_map(|scored| measures.iter().map(|&measure| Reading { measure, ..scored.reading }));
    let measured: Vec<Reading> = measured.collect();
    score_all(comparison, &measured, SOME_POINTS, WIDE)
}

fn all_poses_and_units(comparison: &Comparison, measure: DepthMeasure) -> Vec<Reading> {
    let claimed = comparison.claimed.unit;
    // Planes are in world units: numbers between them have no other.
    let is_other = |unit: &f64| !measure.is_buffer() && (unit / claimed - 1.0).abs() > 1e-3;
    let (planes, lens) = (comparison.claimed.planes.filter(|_| measure.is_buffer()), comparison.claimed.lens);
    let units: Vec<f64> = std::iter::once(claimed).chain(UNITS.into_iter().filter(is_other)).collect();
    let mut readings = Vec::new();
    for axes in CameraAxes::all() {
        for direction in [PoseDirection::CameraToWorld, PoseDirection::WorldToCamera] {
            let pose = PoseConvention { direction, axes };
            readings.extend(units.iter().map(|&unit| Reading { pose, measure, unit, planes, lens }));
        }
    }
    readings
}

/// Units near those of the best reading and of the claimed one, for poses that another program scaled.
fn nearby_units(comparison: &Comparison, found: &[Scored]) -> Vec<Scored> {
    const STEPS: i32 = 20;
    let best = found.iter().max_by(|a, b| a.score.total_cmp(&b.score)).map(|scored| scored.reading);
    let around = |reading: Reading| {
        (-STEPS..=STEPS)
            .map(move |step| Reading { unit: reading.unit * (1.0 + 0.03 * f64::from(step)), ..reading })
    };
    let have_units = best.into_iter().chain([comparison.claimed]).filter(|it| !it.measure.is_buffer());
    let readings: Vec<Reading> = have_units.flat_map(around).collect();
    refined(comparison, &readings)
}

/// Units over ten powers of ten, where none that is common fits: the claimed pose, and OpenGL's and OpenCV's of both directions.
fn any_unit(comparison: &Comparison) -> Vec<Scored> {
    const STEP: f64 = 1.03;
    let claimed = comparison.claimed;
    let mut poses = vec![claimed.pose];
    for axes in [CameraAxes::OPENGL, CameraAxes::OPENCV] {
        for direction in [PoseDirection::CameraToWorld, PoseDirection::WorldToCamera] {
            poses.push(PoseConvention { direction, axes });
        }
    }
    let measures = [DepthMeasure::PlanarZ, DepthMeasure::RayDistance];
    let steps = (1e5_f64.ln() / STEP.ln()) as i32;
    let mut readings = Vec::new();
    for &pose in &poses {
        for measure in measures {
            let unit = |step| claimed.unit * STEP.powi(step);
            let read = |step| Reading { pose, measure, unit: unit(step), planes: None, ..claimed };
            readings.extend((-steps..=steps).map(read));
        }
    }
    refined(comparison, &readings)
}

/// The best of some readings that differ in their units, and a better one between them.
fn refined(comparison: &Comparison, readings: &[Reading]) -> Vec<Scored> {
    let few = score_all(comparison, readings, FEW_POINTS, WIDE);
    let Some(coarse) = few.first().filter(|scored| scored.score > 0.0) else { return Vec::new() };
    let fine = (-12..=12).map(|step| Reading {
        unit: coarse.reading.unit * (1.0 + 0.0025 * f64::from(step)),
        ..coarse.reading
    });
    let fine: Vec<Reading> = fine.collect();
    score_all(comparison, &fine, SOME_POINTS, NARROW)
        .first()
        .map(|best| Reading { unit: three_digits(best.reading.unit), ..best.reading })
        .map(|reading| Scored { reading, score: comparison.score(&reading, SOME_POINTS, WIDE) })
        .into_iter()
        .collect()
}

/// Rounded to the precision of the search.
pub(super) fn three_digits(unit: f64) -> f64 {
    let step = 10_f64.powf(unit.log10().floor() - 2.0);
    let rounded = (unit / step).round() * step;
    // The decimal that is meant, rather than a product that is nearly it.
    format!("{rounded:.2e}").parse().unwrap_or(rounded)
}

/// Scores readings; best first, and equal ones in the order given.
fn score_all(comparison: &Comparison, readings: &[Reading], points: usize, tolerance: f64) -> Vec<Scored> {
    let score = |&reading: &Reading| Scored { reading, score: comparison.score(&reading, points, tolerance) };
    let mut scored: Vec<Scored> = readings.par_iter().map(score).collect();
    scored.sort_by(|a, b| b.score.total_cmp(&a.score));
    scored
}

fn best(found: &[Scored]) -> f64 {
    found.iter().map(|scored| scored.score).fold(0.0, f64::max)
}
