//! Units and lenses under which the pictures of the views agree far better than as the capture is read.
//!
//! Purpose and source: see `picture_agreement`. Poses and the measure of depth are what `verdict` made of them: they show in depth.
//!
//! How well the pictures of the views agree under a reading.
//!
//! Purpose: cameras that stand close together see almost the same depth whatever its unit is, and smooth surfaces whatever the focal
//! length is. What is painted on the surfaces still moves by many pixels. Source: normalized cross-correlation of small patches that
//! are carried from view to view, as in multi-view stereo (M. Goesele et al., *Multi-View Stereo for Community Photo Collections*,
//! ICCV 2007). What differs: patches face the camera that they come from, and are compared in small pictures, because the readings that
//! are told apart here differ by many pixels.

use std::sync::Arc;

use glam::{DAffine3, DVec2};
use rayon::prelude::*;

use super::agreement::Comparison;
use super::pictures::{shrunk, small};
use super::reading::{LensReading, PixelRay, Reading};
use super::search::{NARROW, UNITS, three_digits};
use super::verdict::{
    Alternative, ConventionVerdict, Evidence, Finding, ReadingPart, Undecided, keys, number,
};
use super::views::{POINTS, SourcePoint};
use crate::capture::camera::Intrinsics;
use crate::capture::frame::Frame;
use crate::color::brightness;
use crate::grid::Grid;

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
/// Depth is exact where other views contradict at most this share of the points about which they say anything, at this tolerance as a share
/// of depth. Then the unit and the lens that it was carried through are right, whatever pictures show: under lights that move with the
/// cameras, patches of smooth surfaces meet look-alikes that correlate by up to 0.62.
const MOST_CONTRADICTED: f64 = 0.01;
const EXACT_TOLERANCE: f64 = 0.002;
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
    if pictures.patches.iter().map(Vec::len).sum::<usize>() < LEAST_PATCHES {
        return finding;
    }
    let claimed = comparison.claimed;
    // Depth through a wrong lens may agree under poses and measures that mean nothing.
    let of_other = finding.alternative().map(|other| pictures.correlations(&other.reading, ALL));
    let as_read = pictures.correlations(&claimed, ALL);
    let rivals: Vec<&Vec<f64>> = of_other.iter().chain([&as_read]).collect();
    if rivals.iter().any(|rival| mean(rival) * UNIT_DECIDES >= 1.0) {
        return finding;
    }
    let votes = comparison.votes(&claimed, POINTS, EXACT_TOLERANCE);
    let is_exact = votes.contradict as f64 <= MOST_CONTRADICTED * (votes.agree + votes.contradict) as f64;
    let by_depth = |reading: &Reading| comparison.score(reading, POINTS, NARROW);
    // Depth that nothing contradicts by chance, as where few points meet, is as exact under the other reading.
    let is_refuted = |reading: &Reading| is_exact && by_depth(reading) < by_depth(&claimed);
    let is_believed = |reading: &Reading| {
        let found = pictures.correlations(reading, ALL);
        let decides = if reading.lens == claimed.lens { UNIT_DECIDES } else { LENS_DECIDES };
        differs(reading, &claimed)
            && rivals.iter().all(|rival| is_better(&found, rival, decides))
            && !is_refuted(reading)
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

/// Columns of the pictures that are compared, at most.
const WIDTH: usize = 320;
/// Pixels of a patch to each side of its middle.
const RADIUS: i32 = 3;
const PATCH: usize = ((2 * RADIUS + 1) * (2 * RADIUS + 1)) as usize;
/// Patches whose brightness (the square root of luminance) has a smaller standard deviation show no texture.
const LEAST_TEXTURE: f64 = 0.02;
/// The same where a patch arrives: noise, which correlates with nothing.
const NOISE: f64 = 0.005;

/// The pictures of the views of a comparison.
pub(super) struct PictureComparison<'a> {
    comparison: &'a Comparison,
    /// In the order of its views: brightness, small.
    pictures: Vec<Grid<f32>>,
    /// Per pair, what is carried: its points with texture around them.
    patches: Vec<Vec<Patch<'a>>>,
}

/// A point with the brightness around it, less its mean.
struct Patch<'a> {
    point: &'a SourcePoint,
    values: [f64; PATCH],
    deviation: f64,
}

impl<'a> PictureComparison<'a> {
    pub(super) fn new(comparison: &'a Comparison, frames: &[Arc<Frame>]) -> Self {
        let pictures = frames.iter().zip(&comparison.views);
        let pictures: Vec<Grid<f32>> = pictures
            .map(|(frame, view)| {
                shrunk(frame, &small(&view.intrinsics, WIDTH)).map(|color| brightness(*color))
            })
            .collect();
        let of_pair = |&(from, _): &(usize, usize)| {
            let step = pixel_step(&comparison.views[from].intrinsics);
            let points = comparison.views[from].points.iter();
            points.filter_map(|point| Patch::around(point, &pictures[from], step)).collect()
        };
        let patches = comparison.pairs.iter().map(of_pair).collect();
        Self { comparison, pictures, patches }
    }

    /// The mean correlation of patches under a reading, in each pair that has some; those that are carried out of the picture count as 0.
    /// At most `most` patches of a pair are carried.
    pub(super) fn correlations(&self, reading: &Reading, most: usize) -> Vec<f64> {
        let poses = self.comparison.poses(reading);
        let pairs =
            self.comparison.pairs.iter().zip(&self.patches).filter(|(_, patches)| !patches.is_empty());
        let of_pair = |(&(from, to), patches): (&(usize, usize), &Vec<Patch>)| {
            let taken = patches.len().min(most);
            let places = self.places(reading, [from, to], [&poses[from], &poses[to]]);
            let sum: f64 = patches[..taken].iter().filter_map(|patch| patch.correlation(&places)).sum();
            sum / taken as f64
        };
        pairs.map(of_pair).collect()
    }

    fn places(&self, reading: &Reading, pair: [usize; 2], poses: [&DAffine3; 2]) -> Carried<'_> {
        let views = pair.map(|view| &self.comparison.views[view]);
        let [lens, target_lens] = views.map(|view| reading.lens.of(&view.intrinsics));
        Carried {
            reading: *reading,
            lens,
            target_lens,
            world_from_source: *poses[0],
            target_from_source: poses[1].inverse() * *poses[0],
            near_clip: self.comparison.near_clip,
            steps: views.map(|view| pixel_step(&view.intrinsics)),
            picture: &self.pictures[pair[1]],
        }
    }
}

/// From one view into another under a reading.
struct Carried<'a> {
    reading: Reading,
    lens: Intrinsics,
    target_lens: Intrinsics,
    world_from_source: DAffine3,
    target_from_source: DAffine3,
    near_clip: f64,
    /// Pixels of the source and of the target for a pixel of their small pictures.
    steps: [f64; 2],
    picture: &'a Grid<f32>,
}

impl Carried<'_> {
    /// Brightness where the other view sees a pixel of the source that has the planar z `z`; `None` outside of its picture.
    fn brightness(&self, pixel: DVec2, z: f64) -> Option<f64> {
        let point = self.target_from_source.transform_point3(self.lens.ray_in_camera(pixel) * z);
        let at = self.target_lens.project(point).filter(|_| point.z > 0.0)?;
        brightness_at(self.picture, at / self.steps[1])
    }
}

impl<'a> Patch<'a> {
    /// `step` is the width of a pixel of the small picture. `None` without texture, and at the border.
    fn around(point: &'a SourcePoint, picture: &Grid<f32>, step: f64) -> Option<Self> {
        let mut values = [0.0; PATCH];
        for (value, offset) in values.iter_mut().zip(offsets()) {
            *value = brightness_at(picture, point.pixel / step + offset)?;
        }
        let deviation = centered(&mut values);
        (deviation > LEAST_TEXTURE).then_some(Self { point, values, deviation })
    }

    /// With what the other view shows in its place; `None` if that is not all within the picture.
    fn correlation(&self, carried: &Carried) -> Option<f64> {
        let ray = PixelRay::through(&carried.lens, self.point.pixel);
        let z =
            carried.reading.planar_z(self.point.value, ray, &carried.world_from_source, carried.near_clip);
        if z.is_nan() || z <= 0.0 {
            return None;
        }
        let mut found = [0.0; PATCH];
        for (value, offset) in found.iter_mut().zip(offsets()) {
            *value = carried.brightness(self.point.pixel + offset * carried.steps[0], z)?;
        }
        let deviation = centered(&mut found);
        let product: f64 = self.values.iter().zip(&found).map(|(a, b)| a * b).sum();
        Some(product / PATCH as f64 / (self.deviation * deviation.max(NOISE)))
    }
}

/// Pixels of a view for a pixel of its small picture.
fn pixel_step(lens: &Intrinsics) -> f64 {
    f64::from(lens.width) / f64::from(small(lens, WIDTH).width)
}

fn offsets() -> impl Iterator<Item = DVec2> {
    let side = -RADIUS..=RADIUS;
    side.clone().flat_map(move |y| side.clone().map(move |x| DVec2::new(f64::from(x), f64::from(y))))
}

/// Takes the mean away; the standard deviation of what is left.
fn centered(values: &mut [f64; PATCH]) -> f64 {
    let mean = values.iter().sum::<f64>() / PATCH as f64;
    for value in values.iter_mut() {
        *value -= mean;
    }
    (values.iter().map(|value| value * value).sum::<f64>() / PATCH as f64).sqrt()
}

/// Between the four pixels around a position, in pixels from the corner of the picture; `None` where it has not all four.
fn brightness_at(picture: &Grid<f32>, at: DVec2) -> Option<f64> {
    let corner = at - 0.5;
    let (left, top) = (corner.x.floor(), corner.y.floor());
    let (width, height) = picture.size();
    if !(left >= 0.0 && top >= 0.0 && left + 1.0 < width as f64 && top + 1.0 < height as f64) {
        return None;
    }
    let (right, down) = (corner.x - left, corner.y - top);
    let start = top as usize * width + left as usize;
    let values = picture.as_slice();
    let row = |start: usize| f64::from(values[start]) * (1.0 - right) + f64::from(values[start + 1]) * right;
    Some(row(start) * (1.0 - down) + row(start + width) * down)
}
