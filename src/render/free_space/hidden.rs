//! Which pixels are holes although a sample was found behind them, and what kinds of holes there are.

use rayon::prelude::*;

use super::ray_test::{LineOfSight, RayTest};
use super::seen_depth::SeenDepths;
use super::window::{MARGIN, OUTSIDE, Window};
use crate::capture::Camera;
use crate::render::vantage::{NO_IMAGE, Picture};
use crate::simd::{self, VectorLoop};

/// The inverse depth of a hole that may show anything.
pub(crate) const HOLE: f32 = -1.0;

/// The inverse depth of a hole that shows either the sky or what hides it, whose line of sight passes space that no camera has seen
/// free and that nearer surfaces do not enclose.
pub(crate) const OPEN_HOLE: f32 = f32::MIN;

/// The inverse depth of a hole whose line of sight cameras have seen free: it shows the sky.
pub(crate) const SKY_HOLE: f32 = f32::NEG_INFINITY;

/// A pixel that shows its sample.
const SHOWN: f32 = 1.0;

/// Directions in which a nearer surface must be found for a pixel to be enclosed.
const ENOUGH: u32 = 7;

/// Lines of sight are tested where this many directions lead to a nearer surface: through such pixels an enclosed one may see the
/// surfaces around it.
const ENOUGH_TO_TEST: u8 = 5;

/// Lines of sight are tested down to this share of the inverse depth of the farthest surface around.
const BEYOND_FARTHEST: f32 = 0.9;

/// They are tested no farther than this many times the inverse depth of what is shown.
const BEFORE_SHOWN: f32 = 1.04;

/// Holes that nothing encloses are tested for squares of this many columns and rows: what they show is invented anyway.
const COARSE: usize = 4;

/// Rows that one thread judges together.
const ROWS: usize = 64;

/// The smallest inverse depth that the surface hidden in a hole may have, from the hole's own; 0 where that is not known.
pub(crate) fn hidden_surface_limit(hole: f32) -> f32 {
    if hole > OPEN_HOLE && hole < HOLE { HOLE - hole } else { 0.0 }
}

/// Turns pixels into holes that nearer surfaces enclose and whose line of sight passes space that no camera has seen free, and
/// marks all holes: their inverse depths become [`HOLE`], [`OPEN_HOLE`], [`SKY_HOLE`], or `−1 − w` where the surface that is hidden
/// is no farther than inverse depth `w`.
pub(crate) fn mark_holes(picture: &mut Picture, seen: &SeenDepths, cameras: &[Camera], target: &Camera) {
    let width = picture.image.width();
    let test = RayTest::new(seen, cameras, target);
    let mut marks = vec![SHOWN; picture.image.len()];
    let shown = &*picture;
    marks.par_chunks_mut(width * ROWS).enumerate().for_each_init(Window::new, |window, (nth, marks)| {
        simd::run(JudgeRows { test: &test, picture: shown, top: nth * ROWS, window, marks });
    });
    let color = picture.color.as_mut_slice().par_chunks_mut(width);
    let planes = color.zip(picture.inverse_depth.as_mut_slice().par_chunks_mut(width));
    let planes = planes.zip(picture.image.as_mut_slice().par_chunks_mut(width));
    planes.zip(marks.par_chunks(width)).for_each(|(((color, inverse_depth), image), marks)| {
        for (x, mark) in marks.iter().enumerate().filter(|(_, mark)| **mark != SHOWN) {
            (color[x], inverse_depth[x], image[x]) = ([0.0; 3], *mark, NO_IMAGE);
        }
    });
}

/// Judges some rows.
struct JudgeRows<'a> {
    test: &'a RayTest<'a>,
    picture: &'a Picture,
    top: usize,
    window: &'a mut Window,
    marks: &'a mut [f32],
}

impl VectorLoop for JudgeRows<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { test, picture, top, window, marks } = self;
        let size = picture.image.size();
        let rows = marks.len() / size.0;
        window.load(picture, top, rows);
        let may_be_enclosed: Vec<usize> =
            (0..window.counts.len()).filter(|at| window.counts[*at] >= ENOUGH_TO_TEST).collect();
        for &at in &may_be_enclosed {
            let Some((x, y)) = window.pixel(at, top, size) else { continue };
            let (range, own) = (window.range_at(at), window.w[at]);
            let far = (own * BEFORE_SHOWN).max(range.farthest * BEYOND_FARTHEST);
            if own < OUTSIDE
                && range.nearest > far
                && let LineOfSight::Hidden(end) = test.test((x as f32, y as f32), range.nearest, far)
            {
                window.hidden_until[at] = end;
            }
        }
        for &at in &may_be_enclosed {
            let Some((x, y)) = window.pixel(at, top, size) else { continue };
            let is_judged = (top..top + rows).contains(&y) && !window.hidden_until[at].is_nan();
            if is_judged && window.is_enclosed(at, ENOUGH) {
                marks[(y - top) * size.0 + x] = HOLE - window.hidden_until[at];
            }
        }
        let images = &picture.image.as_slice()[top * size.0..][..marks.len()];
        mark_open_holes(test, window, images, (size.0, top), marks);
    }
}

/// Marks the holes that nothing encloses, by the line of sight of one pixel in each square.
#[inline(always)]
fn mark_open_holes(
    test: &RayTest<'_>,
    window: &Window,
    images: &[u32],
    (width, top): (usize, usize),
    marks: &mut [f32],
) {
    let rows = marks.len() / width;
    for row in (0..rows).step_by(COARSE) {
        for column in (0..width).step_by(COARSE) {
            let in_square = (row..(row + COARSE).min(rows))
                .flat_map(|row| (column..(column + COARSE).min(width)).map(move |column| row * width + column));
            let is_open_hole = |pixel: &usize| images[*pixel] == NO_IMAGE && marks[*pixel] == SHOWN;
            let holes: Vec<usize> = in_square.filter(is_open_hole).collect();
            if holes.is_empty() {
                continue;
            }
            let range = window.range_at((row + MARGIN) * window.across + column + MARGIN);
            let middle = ((column + COARSE / 2) as f32, (top + row + COARSE / 2) as f32);
            let mark = if range.nearest == 0.0 {
                SKY_HOLE
            } else {
                match test.test(middle, range.nearest, range.farthest * BEYOND_FARTHEST) {
                    LineOfSight::Free => SKY_HOLE,
                    LineOfSight::Hidden(_) => OPEN_HOLE,
                    LineOfSight::Unseen => HOLE,
                }
            };
            for pixel in holes {
                marks[pixel] = mark;
            }
        }
    }
}
