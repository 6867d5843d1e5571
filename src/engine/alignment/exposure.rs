//! Exposure and white balance: one gain per camera and channel.
//!
//! Purpose: cameras that see one surface are to show it in one color. Source: gains by least squares over pairs of overlapping
//! pictures (M. Brown and D. Lowe, *Automatic Panoramic Image Stitching using Invariant Features*, IJCV 2007). What differs: a
//! pair gives the median ratio of its samples in a coarse picture, so that highlights and other surfaces do not count. Ratios are
//! logarithms, so that their sum holds the mean gain.

use glam::DVec2;
use rayon::prelude::*;

use super::judge::Judgment;
use super::normal_equations::NormalEquations;
use super::reference_view::ReferenceView;
use super::solver::{PairWeighing, Problem, Weighing, loss};
use super::surface_samples::SurfaceSample;
use crate::median::{MEDIAN_PER_SIGMA, median};

/// Half the side of the square whose mean color is compared, pixels.
const RADIUS: usize = 2;
/// Pixels of the square that have to be of the sample's surface: their inverse depths differ from it by no more than this, relative.
const LEAST_PIXELS: usize = 6;
const SAME_SURFACE: f32 = 0.05;
/// Linear colors below the first are too dark for a ratio; those above the second may be cut off.
const USABLE: [f32; 2] = [0.004, 0.85];
/// A pair with fewer samples gives no ratio.
const LEAST_SAMPLES: usize = 16;
/// A gain that changes less, in stops, does not show.
pub(crate) const LEAST_STOPS: f64 = 0.02;
/// A gain is kept from this many standard errors on. They are wider than those of independent samples.
const LEAST_ERRORS: f64 = 2.0;
/// The least spread of samples for other reasons than the gain, natural logarithm.
const LEAST_SPREAD: f64 = 0.02;

/// What was found of one camera's exposure.
#[derive(Clone, Debug)]
pub(crate) struct GainCorrection {
    pub(crate) kept: bool,
    /// Natural logarithm of what colors are multiplied with, per channel, and its standard error.
    pub(crate) log_gain: [f64; 3],
    pub(crate) standard_error: [f64; 3],
    pub(crate) judgment: Judgment,
}

/// What was kept of a camera's exposure.
pub(super) fn kept_gain(gains: &[GainCorrection], camera: usize) -> Option<&GainCorrection> {
    gains.get(camera).filter(|gain| gain.kept)
}

/// The logarithms of colors of two cameras at one sample: the sample's own, and what the other shows.
struct ColorPair {
    own: [f64; 3],
    found: [f64; 3],
    region: usize,
    judges: bool,
}

/// A pair of cameras, with the colors of the samples that both see.
type ColorsOfPair = ([usize; 2], Vec<ColorPair>);

/// Per pair and channel: the median difference of logarithms, its weight, and the spread.
struct Ratio {
    pair: [usize; 2],
    difference: [f64; 3],
    weight: [f64; 3],
    spread: [f64; 3],
}

/// Gains under which cameras agree about colors. Those that do not pay are 0.
pub(crate) fn align_gains(problem: &Problem, weighing: &Weighing) -> Vec<GainCorrection> {
    let views = problem.views.par_iter().zip(&problem.samples);
    let own: Vec<Vec<LogColor>> = views.map(|(view, samples)| own_colors(view, samples)).collect();
    let of_pair = |(pair, weighed): (&[usize; 2], &PairWeighing)| {
        (*pair, color_pairs(problem, weighing.level, weighed.gate, *pair, &own[pair[0]]))
    };
    let colors: Vec<ColorsOfPair> = problem.pairs.par_iter().zip(&weighing.pairs).map(of_pair).collect();
    let ratios: Vec<Ratio> = colors.iter().filter_map(|(pair, colors)| ratio(*pair, colors)).collect();
    let mut corrections = solved(&ratios, &problem.is_free);
    let spreads = spreads(&ratios, &colors);
    // All gains are applied; then each camera's is judged beside those of the others.
    let found: Vec<[f64; 3]> = corrections.iter().map(|correction| correction.log_gain).collect();
    for (camera, correction) in corrections.iter_mut().enumerate() {
        correction.judgment = judged(camera, &found, colors.iter().zip(&spreads), problem.regions);
        let largest =
            |values: [f64; 3]| values.into_iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        let [stops, errors] = [correction.log_gain, correction.standard_error]
            .map(|logarithms| largest(logarithms) / std::f64::consts::LN_2);
        correction.kept = correction.judgment.pays() && stops > LEAST_STOPS && stops > LEAST_ERRORS * errors;
    }
    corrections
}

/// The gains that fit the ratios best, with their standard errors; nothing is judged yet. The mean of those that stay is held, or of all
/// where all are free.
fn solved(ratios: &[Ratio], is_free: &[bool]) -> Vec<GainCorrection> {
    let cameras = is_free.len();
    let are_all_free = is_free.iter().all(|is_free| *is_free);
    let held: Vec<usize> = (0..cameras).filter(|camera| are_all_free || !is_free[*camera]).collect();
    let none = GainCorrection {
        kept: false,
        log_gain: [0.0; 3],
        standard_error: [0.0; 3],
        judgment: Judgment::default(),
    };
    let mut corrections = vec![none; cameras];
    for channel in 0..3 {
        let mut equations = NormalEquations::new(cameras);
        for Ratio { pair, difference, weight, .. } in ratios {
            equations.add_difference(*pair, difference[channel], weight[channel]);
        }
        hold_mean(&mut equations, &held);
        let Some(factor) = equations.factor() else { continue };
        for (camera, gain) in factor.solve(&equations.right).into_iter().enumerate() {
            corrections[camera].log_gain[channel] = gain;
            corrections[camera].standard_error[channel] =
                factor.inverse_block::<1>(camera)[0][0].max(0.0).sqrt();
        }
    }
    corrections
}

/// Judges one camera's gain by the samples that took no part in finding it. The other cameras have theirs.
fn judged<'a>(
    camera: usize,
    found: &[[f64; 3]],
    pairs: impl Iterator<Item = (&'a ColorsOfPair, &'a [f64; 3])>,
    regions: usize,
) -> Judgment {
    let mut losses = Vec::new();
    for ((pair, colors), spread) in pairs.filter(|((pair, _), _)| pair.contains(&camera)) {
        let now = pair.map(|index| found[index]);
        let before = pair.map(|index| if index == camera { [0.0; 3] } else { found[index] });
        for color in colors.iter().filter(|color| color.judges) {
            let off = |[own, other]: [[f64; 3]; 2]| -> f64 {
                let of_channel = |channel: usize| {
                    let off = color.own[channel] + own[channel] - color.found[channel] - other[channel];
                    loss(off, spread[channel])
                };
                (0..3).map(of_channel).sum()
            };
            losses.push((color.region, [off(before), off(now)]));
        }
    }
    Judgment::of_regions(&losses, regions)
}

/// The spreads of each pair that has a ratio; of others nothing counts.
fn spreads(ratios: &[Ratio], colors: &[ColorsOfPair]) -> Vec<[f64; 3]> {
    let of_pair = |(pair, _): &ColorsOfPair| {
        ratios.iter().find(|ratio| ratio.pair == *pair).map_or([1e-9; 3], |ratio| ratio.spread)
    };
    colors.iter().map(of_pair).collect()
}

fn hold_mean(equations: &mut NormalEquations, held: &[usize]) {
    const WEIGHT: f64 = 1e3;
    const PULL: f64 = 1.0;
    for a in 0..equations.size() {
        equations.add(a, a, PULL);
    }
    for (nth, &a) in held.iter().enumerate() {
        for &b in &held[..=nth] {
            equations.add(a, b, WEIGHT / held.len() as f64);
        }
    }
}

/// The mean colors of a camera's own samples.
fn own_colors(view: &ReferenceView, samples: &[SurfaceSample]) -> Vec<LogColor> {
    let of_sample = |sample: &SurfaceSample| mean_log_color(view, sample.pixel);
    samples.iter().map(of_sample).collect()
}

fn color_pairs(
    problem: &Problem,
    level: usize,
    gate: f64,
    pair: [usize; 2],
    own_colors: &[LogColor],
) -> Vec<ColorPair> {
    let views = problem.pair(pair);
    let [own, other] = pair.map(|camera| &problem.views[camera]);
    let samples = problem.samples[pair[0]].iter().zip(own_colors);
    let colors = samples.filter_map(|(sample, own_color)| {
        let own_color = (*own_color)?;
        views.terms(sample, level, gate)?;
        let point = own.camera.unproject(sample.pixel, 1.0 / sample.inverse_depth);
        let (image, _) = other.camera.project(point)?;
        let found = mean_log_color(other, image)?;
        Some(ColorPair { own: own_color, found, region: sample.region, judges: sample.judges })
    });
    colors.collect()
}

/// Logarithms of the mean color of a surface; `None` near the border of the picture, and where little of the square is of the surface,
/// or some of it is too dark or too bright for a ratio.
type LogColor = Option<[f64; 3]>;

fn mean_log_color(view: &ReferenceView, image: DVec2) -> LogColor {
    let (color, depth) = (&view.frame.color, &view.frame.inverse_depth);
    let (width, height) = color.size();
    let (x, y) = (image.x as usize, image.y as usize);
    if x < RADIUS || y < RADIUS || x + RADIUS >= width || y + RADIUS >= height {
        return None;
    }
    // What has no depth may be the background of something cut out, or a hole in what a sensor measured.
    let here = depth[(x, y)];
    let is_here = |there: f32| there > 0.0 && (there - here).abs() <= SAME_SURFACE * here;
    let (mut sum, mut count) = ([0.0_f32; 3], 0);
    for row in y - RADIUS..=y + RADIUS {
        for column in (x - RADIUS..=x + RADIUS).filter(|column| is_here(depth[(*column, row)])) {
            for (sum, value) in sum.iter_mut().zip(color[(column, row)]) {
                let value = f32::from(value);
                if value > USABLE[1] {
                    return None;
                }
                *sum += value;
            }
            count += 1;
        }
    }
    let mean = sum.map(|sum| sum / count as f32);
    let is_usable = count >= LEAST_PIXELS && mean.iter().all(|mean| *mean >= USABLE[0]);
    is_usable.then(|| mean.map(|mean| f64::from(mean.ln())))
}

fn ratio(pair: [usize; 2], colors: &[ColorPair]) -> Option<Ratio> {
    let fitting: Vec<&ColorPair> = colors.iter().filter(|color| !color.judges).collect();
    if fitting.len() < LEAST_SAMPLES {
        return None;
    }
    let mut ratio = Ratio { pair, difference: [0.0; 3], weight: [0.0; 3], spread: [0.0; 3] };
    for channel in 0..3 {
        let mut differences: Vec<f64> =
            fitting.iter().map(|color| color.found[channel] - color.own[channel]).collect();
        let middle = median(&mut differences)?;
        let mut away: Vec<f64> = differences.iter().map(|difference| (difference - middle).abs()).collect();
        let spread = (median(&mut away)? / MEDIAN_PER_SIGMA).max(LEAST_SPREAD);
        ratio.difference[channel] = middle;
        ratio.spread[channel] = spread;
        // The median has π/2 the variance of the mean, and neighbors are not independent.
        ratio.weight[channel] = fitting.len() as f64 / (4.0 * spread * spread);
    }
    Some(ratio)
}
