//! Which pixels are holes although a sample was found behind them, and what kinds of holes there are.

use rayon::prelude::*;

use super::ray_test::{LineOfSight, RayTest};
use super::surroundings::{MOST_REACH, SQUARE, Surroundings};
use crate::render::vantage::{FrontColor, LEAST_SHOWN, NO_FRONT, NO_IMAGE, Picture, pixels_around};
use crate::simd::{self, VectorLoop, mask};

/// The inverse depth of a hole that may show anything.
pub(crate) const HOLE: f32 = -1.0;

/// The inverse depth of a hole whose line of sight passes space that no camera has seen free, and that nearer surfaces do not
/// enclose: it shows the sky or a surface.
pub(crate) const OPEN_HOLE: f32 = f32::MIN / 2.0;

/// The inverse depth of a hole whose line of sight cameras have seen free: it shows the sky.
pub(crate) const SKY_HOLE: f32 = f32::MIN;

/// A pixel that shows its sample.
const SHOWN: f32 = 1.0;

/// Lines of sight are tested down to this share of the inverse depth of the farthest surface around.
const BEYOND_FARTHEST: f32 = 0.9;

/// They are tested no farther than this many times the inverse depth of what is shown.
const BEFORE_SHOWN: f32 = 1.04;

/// Holes that nothing encloses are tested for squares of this many columns and rows: what they show is invented anyway.
const COARSE: usize = 4;

/// No part of the line of sight is hidden.
const NOT_HIDDEN: f32 = -1.0;

/// What [`mark_holes`] works on, kept from picture to picture.
#[derive(Debug, Default)]
pub(crate) struct MarkPlanes {
    surroundings: Surroundings,
    /// As in [`TestSquares`], of the whole picture.
    hidden_until: Vec<f32>,
    /// Share of each line of sight that is hidden, as far as it is known; infinite where a surface is hidden behind it in any case.
    pub(crate) hidden_share: Vec<f32>,
    /// [`SHOWN`], or the mark of a hole.
    marks: Vec<f32>,
}

/// The smallest inverse depth that the surface hidden in a hole may have, from the hole's own; 0 where that is not known.
pub(crate) fn hidden_surface_limit(hole: f32) -> f32 {
    if hole > OPEN_HOLE && hole < HOLE { HOLE - hole } else { 0.0 }
}

/// Turns pixels into holes if nearer surfaces enclose them and their line of sight passes space that no camera has seen free, and
/// marks all holes: their inverse depths become [`HOLE`], [`OPEN_HOLE`], [`SKY_HOLE`], or `−1 − w` where the surface that is hidden
/// is no farther than inverse depth `w`. `fronts` are those of the picture; inverse depths that differ by no more than the factor
/// `tolerance` belong to one surface.
///
/// Returns the shown pixels whose colors may be blended with samples that are no longer shown, ascending.
pub(crate) fn mark_holes(
    picture: &mut Picture,
    fronts: &[FrontColor],
    test: &RayTest<'_>,
    tolerance: f32,
    planes: &mut MarkPlanes,
) -> Vec<usize> {
    let width = picture.image.width();
    let MarkPlanes { surroundings, hidden_until, hidden_share, marks } = planes;
    surroundings.set(picture);
    hidden_until.resize(picture.image.len(), NOT_HIDDEN);
    hidden_share.resize(picture.image.len(), 0.0);
    let rows = hidden_until.par_chunks_mut(width * SQUARE).zip(hidden_share.par_chunks_mut(width * SQUARE));
    rows.enumerate().for_each(|(row, (hidden_until, hidden_share))| {
        hidden_until.fill(NOT_HIDDEN);
        simd::run(TestSquares { test, surroundings, fronts, width, row, hidden_until, hidden_share });
    });
    let images = picture.image.as_slice();
    marks.resize(picture.image.len(), SHOWN);
    let rows = marks.par_chunks_mut(width * SQUARE).zip(hidden_share.par_chunks_mut(width * SQUARE));
    rows.enumerate().for_each(|(row, (marks, hidden_share))| {
        marks.fill(SHOWN);
        simd::run(MarkSquares {
            test,
            surroundings,
            fronts,
            hidden_until,
            images,
            width,
            row,
            marks,
            hidden_share,
        });
    });
    show_fronts(picture, fronts, marks);
    let rims: Vec<_> = beside_turned(picture.image.as_slice(), marks, width)
        .into_par_iter()
        .map(|pixel| (pixel, unblended(picture, marks, pixel, tolerance)))
        .collect();
    let mut blended = Vec::new();
    for (pixel, color) in rims {
        match color {
            Some(color) => picture.color.as_mut_slice()[pixel] = color,
            None => blended.push(pixel),
        }
    }
    let planes = picture.inverse_depth.as_mut_slice().par_chunks_mut(width);
    let planes = planes.zip(picture.image.as_mut_slice().par_chunks_mut(width));
    let rows = planes.zip(marks.par_chunks(width)).filter(|(_, marks)| has_mark(marks));
    rows.for_each(|((inverse_depth, image), marks)| {
        for (x, mark) in marks.iter().enumerate().filter(|(_, mark)| **mark != SHOWN) {
            (inverse_depth[x], image[x]) = (*mark, NO_IMAGE);
        }
    });
    blended
}

/// The inverse depth of the farthest surface that a pixel shows; most of the pixel shows `w`.
#[inline(always)]
fn farthest_shown(fronts: &[FrontColor], pixel: usize, w: f32) -> f32 {
    fronts.get(pixel).map_or(w, |front| if front[3] >= 0.0 { front[3] } else { w })
}

/// Whether any of these pixels is not shown.
fn has_mark(marks: &[f32]) -> bool {
    marks.iter().fold(false, |any, mark| any | (*mark != SHOWN))
}

/// Shows only what is in front where a pixel's farthest surface is hidden: in a hole if that is less than half of the pixel.
fn show_fronts(picture: &mut Picture, fronts: &[FrontColor], marks: &mut [f32]) {
    let width = picture.image.width();
    let images = picture.image.as_slice().par_chunks(width);
    let mut coverage: Vec<&mut [f32]> = picture.coverage.chunks_mut(width).collect();
    coverage.resize_with(images.len(), Default::default);
    let rows = picture.color.as_mut_slice().par_chunks_mut(width).zip(coverage).zip(images);
    let rows = rows.zip(marks.par_chunks_mut(width)).enumerate().filter(|(_, (_, marks))| has_mark(marks));
    rows.for_each(|(y, (((colors, coverage), images), marks))| {
        let turned = marks.iter_mut().enumerate();
        for (x, mark) in turned.filter(|(x, mark)| **mark != SHOWN && images[*x] != NO_IMAGE) {
            let front = fronts.get(y * width + x).filter(|front| front[3] >= 0.0);
            let [red, green, blue, _, share] = *front.unwrap_or(&NO_FRONT);
            if share >= LEAST_SHOWN {
                *mark = SHOWN;
            }
            let is_shown = *mark == SHOWN || !coverage.is_empty();
            colors[x] = if is_shown { [red, green, blue] } else { [0.0; 3] };
            if let Some(coverage) = coverage.get_mut(x) {
                *coverage = share;
            }
        }
    });
}

/// Tests the lines of sight of the pixels in a row of squares that nearer surfaces may enclose.
struct TestSquares<'a> {
    test: &'a RayTest<'a>,
    surroundings: &'a Surroundings,
    /// As in a picture.
    fronts: &'a [FrontColor],
    width: usize,
    row: usize,
    /// Inverse depth at which the hidden part of each line of sight ends; else [`NOT_HIDDEN`].
    hidden_until: &'a mut [f32],
    /// Share of each of them that is hidden.
    hidden_share: &'a mut [f32],
}

impl VectorLoop for TestSquares<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { test, surroundings, fronts, width, row, hidden_until, hidden_share } = self;
        for column in (0..width.div_ceil(SQUARE)).filter(|column| surroundings.may_enclose(*column, row)) {
            let range = surroundings.range_at((column * SQUARE, row * SQUARE));
            let lines = hidden_until.chunks_mut(width).zip(hidden_share.chunks_mut(width));
            for (below, (line, shares)) in lines.enumerate() {
                let y = row * SQUARE + below;
                let left = column * SQUARE;
                let at = surroundings.at((left, y));
                let mut shown = [0.0; SQUARE];
                for (nth, w) in shown.iter_mut().enumerate().take(width - left) {
                    *w = farthest_shown(fronts, y * width + left + nth, surroundings.w[at + nth]);
                }
                let is_tested = |i: usize| {
                    left + i < width
                        && range.nearest > (shown[i] * BEFORE_SHOWN).max(range.farthest * BEYOND_FARTHEST)
                };
                let mut tested = mask(is_tested);
                if tested != 0 {
                    tested &= surroundings.may_be_enclosed(at, &shown);
                }
                while tested != 0 {
                    let i = tested.trailing_zeros() as usize % SQUARE;
                    tested &= tested - 1;
                    let (x, far) =
                        (left + i, (shown[i] * BEFORE_SHOWN).max(range.farthest * BEYOND_FARTHEST));
                    if let LineOfSight::Hidden(part) = test.test((x as f32, y as f32), range.nearest, far) {
                        (line[x], shares[x]) = (part.end, part.share);
                    }
                }
            }
        }
    }
}

/// Marks the holes in a row of squares.
struct MarkSquares<'a> {
    test: &'a RayTest<'a>,
    surroundings: &'a Surroundings,
    /// As in a picture.
    fronts: &'a [FrontColor],
    /// As in [`TestSquares`], of the whole picture.
    hidden_until: &'a [f32],
    /// The images of the whole picture.
    images: &'a [u32],
    width: usize,
    row: usize,
    marks: &'a mut [f32],
    /// As in [`TestSquares`].
    hidden_share: &'a mut [f32],
}

impl VectorLoop for MarkSquares<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { test, surroundings, fronts, hidden_until, images, width, row, marks, hidden_share } = self;
        let (top, first) = (row * SQUARE, row * SQUARE * width);
        let is_hidden = |there: usize| {
            // Only positions in the picture are looked up: beyond it every surface counts as nearer.
            let (x, y) = (there % surroundings.across - MOST_REACH, there / surroundings.across - MOST_REACH);
            hidden_until[y * width + x] >= 0.0
        };
        for (pixel, mark) in marks.iter_mut().enumerate() {
            let hidden_until = hidden_until[first + pixel];
            if hidden_until < 0.0 {
                continue;
            }
            let at = surroundings.at((pixel % width, top + pixel / width));
            let w = farthest_shown(fronts, first + pixel, surroundings.w[at]);
            if surroundings.is_enclosed(at, w, is_hidden) {
                *mark = HOLE - hidden_until;
                if w > 0.0 {
                    hidden_share[pixel] = f32::INFINITY;
                }
            }
        }
        let rows = marks.len() / width;
        let images = &images[first..][..marks.len()];
        let is_hole = |images: &[u32]| images.iter().fold(false, |any, image| any | (*image == NO_IMAGE));
        for row in (0..rows).step_by(COARSE) {
            if !is_hole(&images[row * width..(row + COARSE).min(rows) * width]) {
                continue;
            }
            for column in (0..width).step_by(COARSE) {
                let rows = row..(row + COARSE).min(rows);
                let columns = column..(column + COARSE).min(width);
                let pixels = || rows.clone().flat_map(|y| columns.clone().map(move |x| y * width + x));
                let is_open_hole = |pixel: &usize| images[*pixel] == NO_IMAGE && marks[*pixel] == SHOWN;
                if pixels().any(|pixel| is_open_hole(&pixel)) {
                    let (mark, share) = mark_of_open_hole(test, surroundings, (column, top + row));
                    for pixel in pixels() {
                        if images[pixel] == NO_IMAGE && marks[pixel] == SHOWN {
                            (marks[pixel], hidden_share[pixel]) = (mark, share);
                        }
                    }
                }
            }
        }
    }
}

/// The mark of holes that nothing encloses in the square of [`COARSE`] columns and rows that begins at a pixel, and the share of their
/// line of sight that is hidden.
#[inline(always)]
fn mark_of_open_hole(test: &RayTest<'_>, surroundings: &Surroundings, (x, y): (usize, usize)) -> (f32, f32) {
    let range = surroundings.range_at((x, y));
    if range.nearest == 0.0 {
        return (SKY_HOLE, 0.0);
    }
    let middle = ((x + COARSE / 2) as f32, (y + COARSE / 2) as f32);
    match test.test(middle, range.nearest, range.farthest * BEYOND_FARTHEST) {
        LineOfSight::Free => (SKY_HOLE, 0.0),
        LineOfSight::Hidden(part) => (OPEN_HOLE, part.share),
        LineOfSight::Unseen => (HOLE, 0.0),
    }
}

/// Whether a pixel that a sample reached was turned into a hole.
#[inline(always)]
fn was_turned(images: &[u32], marks: &[f32], pixel: usize) -> bool {
    images[pixel] != NO_IMAGE && marks[pixel] != SHOWN
}

/// The shown pixels beside those that were turned into holes, ascending.
fn beside_turned(images: &[u32], marks: &[f32], width: usize) -> Vec<usize> {
    let height = marks.len() / width;
    let rows = (0..height).into_par_iter().filter(|row| has_mark(&marks[row * width..][..width]));
    let turned = rows.flat_map_iter(|row| row * width..(row + 1) * width);
    let turned = turned.filter(|pixel| was_turned(images, marks, *pixel));
    let mut beside: Vec<usize> = turned
        .flat_map_iter(|pixel| {
            pixels_around(pixel, (width, height))
                .filter(|there| images[*there] != NO_IMAGE && marks[*there] == SHOWN)
        })
        .collect();
    beside.par_sort_unstable();
    beside.dedup();
    beside
}

/// The color of a shown pixel beside one that was turned into a hole, whose sample may have been blended into it: the mean of the
/// same surface beside it, `None` where the surface is not shown farther from the hole.
fn unblended(picture: &Picture, marks: &[f32], pixel: usize, tolerance: f32) -> Option<[f32; 3]> {
    let (width, height) = picture.image.size();
    let (images, depths) = (picture.image.as_slice(), picture.inverse_depth.as_slice());
    let is_rim =
        |pixel: usize| pixels_around(pixel, (width, height)).any(|there| was_turned(images, marks, there));
    let own = depths[pixel];
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    for there in pixels_around(pixel, (width, height)) {
        let is_same = depths[there].max(own) <= depths[there].min(own) * tolerance;
        if is_same && images[there] != NO_IMAGE && marks[there] == SHOWN && !is_rim(there) {
            (0..3).for_each(|channel| sum[channel] += picture.color.as_slice()[there][channel]);
            count += 1.0;
        }
    }
    (count > 0.0).then(|| sum.map(|sum| sum / count))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mark_tells_how_far_the_hidden_surface_may_be() {
        for hidden_until in [0.0_f32, 0.003, 0.25, 1.0, 40.0] {
            let mark = HOLE - hidden_until;
            assert!(mark <= HOLE && mark > OPEN_HOLE);
            assert!((hidden_surface_limit(mark) - hidden_until).abs() < 1e-6 * (1.0 + hidden_until));
        }
        for unlimited in [HOLE, OPEN_HOLE, SKY_HOLE, 0.0, 0.5] {
            assert_eq!(hidden_surface_limit(unlimited), 0.0, "{unlimited}");
        }
    }
}
