//! What surrounds a pixel: the nearest and farthest surfaces around it, and in which directions a nearer surface is found.
//!
//! Which share of a hole shows the sky, where no camera has seen all of its line of sight free.
//!
//! Surfaces are taken to be met in hidden space as if they lay there at random: along a hidden share `h` of the line of sight, of what
//! lies between the nearest and the farthest surface around, none is met with probability exp(−density · h). A hole shows the sky and
//! the surface behind it by that share, which errs least in the mean.
//!
//! Source: the exponential transmittance of random media (Blinn, *Light Reflection Functions for Simulation of Clouds and Dusty
//! Surfaces*, SIGGRAPH 1982), here of what was not seen. The densities were chosen by hand where traced scenes have their truth: leaves,
//! heaps, spheres, an orrery and a room.

use rayon::prelude::*;

use crate::render::vantage::Picture;
use crate::simd::mask;

/// Nearer surfaces are searched for this far at most, pixels.
pub(super) const MOST_REACH: usize = 16;

/// Columns of a picture to each pixel of the search: gaps are as wide as what is around them, which grows with the picture. At 256 columns
/// 16 pixels closed gaps between leaves through which there was nothing to be seen but sky.
const COLUMNS_TO_REACH: usize = 32;

/// No search is shorter than this, pixels: gaps of a few recorded pixels are closed in small pictures too.
const LEAST_REACH: usize = 8;

/// A surface is nearer than what a pixel shows if its inverse depth is more than this many times as large. Surfaces closer together are
/// left to the silhouettes, which the cameras vote on.
const NEARER: f32 = 2.0;

/// Beyond the picture there may be anything.
const OUTSIDE: f32 = f32::INFINITY;

/// Directions in which a nearer surface must be found for a pixel to be enclosed.
const ENOUGH: usize = 7;

/// Lines of sight are tested where this many directions lead to a nearer surface: through such pixels an enclosed one may see the
/// surfaces around it.
const ENOUGH_TO_TEST: usize = 5;

/// The eight directions, as steps in columns and rows.
const DIRECTIONS: [(isize, isize); 8] =
    [(1, 0), (0, 1), (1, 1), (-1, 1), (-1, 0), (0, -1), (-1, -1), (1, -1)];

/// Columns and rows of the squares whose surfaces are taken together: no less than [`MOST_REACH`], so that a direction leads through a
/// pixel's own square and its neighbors alone.
pub(super) const SQUARE: usize = MOST_REACH;

/// Surfaces are looked for in this many squares on each side of a pixel's own.
const SQUARES_AROUND: usize = 2;

/// Inverse depths of the nearest and the farthest surface, not counting the sky; 0 and infinite without a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SurfaceRange {
    pub(super) nearest: f32,
    pub(super) farthest: f32,
}

impl SurfaceRange {
    const NONE: Self = Self { nearest: 0.0, farthest: f32::INFINITY };

    #[inline(always)]
    fn joined(self, other: Self) -> Self {
        Self { nearest: self.nearest.max(other.nearest), farthest: self.farthest.min(other.farthest) }
    }
}

/// The surroundings of the pixels of a picture.
#[derive(Debug, Default)]
pub(super) struct Surroundings {
    /// Columns of the picture with a border of [`MOST_REACH`] pixels on each side.
    pub(super) across: usize,
    /// Nearer surfaces are searched for this far, pixels.
    reach: usize,
    /// Inverse depths with the border; 0 at infinity and in holes, [`OUTSIDE`] in the border.
    pub(super) w: Vec<f32>,
    /// Columns of squares.
    squares_across: usize,
    /// The surfaces in each square.
    squares: Vec<SurfaceRange>,
    /// The surfaces in each square and those around it.
    around: Vec<SurfaceRange>,
}

impl Surroundings {
    /// From the pixels of a picture.
    #[cfg(test)]
    pub(super) fn new(picture: &Picture) -> Self {
        let mut surroundings = Self::default();
        surroundings.set(picture);
        surroundings
    }

    /// Takes in the pixels of a picture instead of those of an earlier one.
    pub(super) fn set(&mut self, picture: &Picture) {
        let (width, height) = picture.image.size();
        let across = width + 2 * MOST_REACH;
        self.reach = reach_in(width);
        // As many more at the end as are read at once.
        let length = across * (height + 2 * MOST_REACH) + SQUARE;
        if (self.across, self.w.len()) != (across, length) {
            // The border stays as it is.
            (self.across, self.w) = (across, vec![OUTSIDE; length]);
        }
        let rows = self.w.par_chunks_mut(across).skip(MOST_REACH);
        let rows = rows.zip(picture.inverse_depth.as_slice().par_chunks(width));
        rows.for_each(|(row, from)| {
            row[MOST_REACH..][..width].iter_mut().zip(from).for_each(|(w, from)| *w = from.max(0.0));
        });
        let squares_across = width.div_ceil(SQUARE);
        let depths = picture.inverse_depth.as_slice().par_chunks(width * SQUARE);
        let squares: Vec<SurfaceRange> =
            depths.flat_map_iter(|rows| ranges(rows, width, squares_across)).collect();
        self.around =
            (0..squares.len()).map(|square| joined_around(&squares, squares_across, square)).collect();
        (self.squares_across, self.squares) = (squares_across, squares);
    }

    /// Where a pixel of the picture is in `w`.
    #[inline(always)]
    pub(super) fn at(&self, (x, y): (usize, usize)) -> usize {
        (y + MOST_REACH) * self.across + x + MOST_REACH
    }

    /// The surfaces around a pixel of the picture.
    #[inline(always)]
    pub(super) fn range_at(&self, (x, y): (usize, usize)) -> SurfaceRange {
        self.around[y / SQUARE * self.squares_across + x / SQUARE]
    }

    /// Whether surfaces in enough of the squares around a square may enclose one of its pixels.
    #[inline(always)]
    pub(super) fn may_enclose(&self, column: usize, row: usize) -> bool {
        // The last squares may reach out of the picture, where anything may be.
        let full = |with_border: usize| (with_border - 2 * MOST_REACH) / SQUARE;
        let (columns, rows) = (full(self.across), full(self.w.len() / self.across));
        let has_surface = |right: isize, below: isize| {
            let (column, row) = (column.wrapping_add_signed(right), row.wrapping_add_signed(below));
            let inside = column < columns && row < rows;
            !inside || self.squares[row * self.squares_across + column].nearest > 0.0
        };
        let leads_to_surface = |&(right, below): &(isize, isize)| {
            has_surface(0, 0) || has_surface(right, 0) || has_surface(0, below) || has_surface(right, below)
        };
        DIRECTIONS.iter().filter(|direction| leads_to_surface(direction)).count() >= ENOUGH_TO_TEST
    }

    /// Whether lines of sight have to be tested at [`SQUARE`] positions from one on, which show something at inverse depths `w`:
    /// enough directions lead to a nearer surface, or out of the picture. A mask of positions.
    #[inline(always)]
    pub(super) fn may_be_enclosed(&self, at: usize, w: &[f32; SQUARE]) -> u32 {
        let mut found = [0_u32; SQUARE];
        for (right, down) in DIRECTIONS {
            let stride = down * self.across as isize + right;
            let (mut nearest, mut there) = ([0.0_f32; SQUARE], at);
            for _ in 0..self.reach {
                there = there.wrapping_add_signed(stride);
                let Some(row) = self.w.get(there..).and_then(|row| row.first_chunk::<SQUARE>()) else {
                    break;
                };
                for i in 0..SQUARE {
                    nearest[i] = nearest[i].max(row[i]);
                }
            }
            for i in 0..SQUARE {
                found[i] += u32::from(nearest[i] > w[i] * NEARER);
            }
        }
        mask(|i| found[i] >= ENOUGH_TO_TEST as u32)
    }

    /// Whether a position that shows something at inverse depth `w` is enclosed: enough directions lead to a nearer surface, or out
    /// of the picture, over pixels whose lines of sight are `hidden`.
    #[inline(always)]
    pub(super) fn is_enclosed(&self, at: usize, w: f32, hidden: impl Fn(usize) -> bool) -> bool {
        self.leads_to_nearer(at, w, ENOUGH, hidden)
    }

    /// Whether `enough` directions lead from a position over pixels that `passes` holds for to a nearer surface.
    #[inline(always)]
    fn leads_to_nearer(&self, at: usize, w: f32, enough: usize, passes: impl Fn(usize) -> bool) -> bool {
        let limit = w * NEARER;
        let mut missing = 0;
        for (right, down) in DIRECTIONS {
            let stride = down * self.across as isize + right;
            let mut there = at;
            let mut is_found = false;
            for _ in 0..self.reach {
                there = there.wrapping_add_signed(stride);
                is_found = self.w[there] > limit;
                if is_found || !passes(there) {
                    break;
                }
            }
            missing += usize::from(!is_found);
            if missing > DIRECTIONS.len() - enough {
                return false;
            }
        }
        true
    }
}

/// How far nearer surfaces are searched for in a picture of so many columns, pixels.
fn reach_in(width: usize) -> usize {
    (width / COLUMNS_TO_REACH).clamp(LEAST_REACH, MOST_REACH)
}

/// The surfaces in each square of a row of squares, from the inverse depths of its pixels.
fn ranges(rows: &[f32], width: usize, squares_across: usize) -> Vec<SurfaceRange> {
    let mut squares = vec![SurfaceRange::NONE; squares_across];
    for (column, square) in squares.iter_mut().enumerate() {
        // Column by column, so that vectors do it.
        let (mut nearest, mut farthest) = ([0.0_f32; SQUARE], [f32::INFINITY; SQUARE]);
        for line in rows.chunks(width) {
            let line = &line[column * SQUARE..];
            let mut there = [0.0; SQUARE];
            if let Some(line) = line.first_chunk::<SQUARE>() {
                there = *line;
            } else {
                there[..line.len()].copy_from_slice(line);
            }
            for i in 0..SQUARE {
                nearest[i] = nearest[i].max(there[i]);
                farthest[i] = farthest[i].min(if there[i] > 0.0 { there[i] } else { f32::INFINITY });
            }
        }
        for i in 0..SQUARE {
            *square = square.joined(SurfaceRange { nearest: nearest[i], farthest: farthest[i] });
        }
    }
    squares
}

/// The surfaces in a square and those around it.
fn joined_around(squares: &[SurfaceRange], across: usize, square: usize) -> SurfaceRange {
    let down = squares.len() / across;
    let (column, row) = (square % across, square / across);
    let span = |middle: usize, count: usize| {
        middle.saturating_sub(SQUARES_AROUND)..(middle + SQUARES_AROUND + 1).min(count)
    };
    let rows = span(row, down).map(|row| &squares[row * across..][..across]);
    let around = rows.flat_map(|squares| &squares[span(column, across)]);
    around.fold(SurfaceRange::NONE, |all, square| all.joined(*square))
}

/// The density between parts of a surface on both sides, and where no sky is seen across the hole.
const FACING_DENSITY: f32 = 16.0;

/// The density within nearer surfaces.
const ENCLOSED_DENSITY: f32 = 24.0;

/// Within nearer surfaces a surface may be met where hardly anything is hidden.
const ENCLOSED_SKY: f32 = 0.9;

/// What is around a hole whose line of sight is hidden in part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum HolePlace {
    /// The sky is seen across the hole, and parts of a surface do not face each other.
    Open,
    /// Parts of a surface face each other, or no sky is seen.
    Facing,
    /// Nearer surfaces enclose it.
    Enclosed,
}

/// The share of a hole that shows the sky, 0 to 1, by the share of its line of sight that is hidden.
pub(crate) fn sky_share(place: HolePlace, hidden_share: f32) -> f32 {
    match place {
        HolePlace::Open => 1.0,
        HolePlace::Facing => (-FACING_DENSITY * hidden_share).exp(),
        HolePlace::Enclosed => ENCLOSED_SKY * (-ENCLOSED_DENSITY * hidden_share).exp(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::render::vantage::NO_IMAGE;

    /// A picture of surfaces, sky and holes in patches: the `scarce`r, the fewer surfaces.
    fn patches(size: (usize, usize), patch: usize, scarce: u32, seed: u32) -> Picture {
        let depth = |x: usize, y: usize| {
            let (column, row) = (x / patch, y / patch);
            let mut mixed = (column as u32).wrapping_mul(0x9e37_79b1)
                ^ (row as u32).wrapping_mul(0x85eb_ca77)
                ^ seed.wrapping_mul(0xc2b2_ae3d);
            mixed = (mixed ^ mixed >> 15).wrapping_mul(0x2c1b_3c6d);
            mixed = (mixed ^ mixed >> 12).wrapping_mul(0x297a_2d39);
            mixed ^= mixed >> 15;
            match mixed % scarce {
                0 => 1.0,
                1 => 0.3,
                2 => 0.1,
                3 => -1.0,
                _ => 0.0,
            }
        };
        Picture {
            color: Grid::filled(size.0, size.1, [0.0; 3]),
            inverse_depth: Grid::from_fn(size.0, size.1, depth),
            image: Grid::from_fn(size.0, size.1, |x, y| if depth(x, y) < 0.0 { NO_IMAGE } else { 0 }),
            ..Picture::empty(0, 0)
        }
    }

    /// Whether enough directions lead to a nearer surface or the edge of the picture, found by stepping over the picture itself.
    fn plainly_enclosed(picture: &Picture, (x, y): (usize, usize), enough: usize) -> bool {
        let own = picture.inverse_depth[(x, y)].max(0.0);
        let leads_to_nearer = |(right, below): (isize, isize)| {
            (1..=reach_in(picture.inverse_depth.size().0) as isize).any(|step| {
                let at = (x.wrapping_add_signed(step * right), y.wrapping_add_signed(step * below));
                picture.inverse_depth.get(at.0, at.1).is_none_or(|w| *w > 2.0 * own)
            })
        };
        DIRECTIONS.into_iter().filter(|direction| leads_to_nearer(*direction)).count() >= enough
    }

    #[test]
    fn no_square_is_passed_over_that_holds_a_pixel_which_may_be_enclosed() {
        let (mut may, mut passed_over) = (0, 0);
        for seed in 0..12 {
            for (patch, scarce) in [(3, 40), (5, 30), (9, 12), (16, 6), (40, 5)] {
                let (width, height) = (131 + seed as usize, 90);
                let picture = patches((width, height), patch, scarce, seed);
                let surroundings = Surroundings::new(&picture);
                for y in 0..height {
                    for x in 0..width {
                        let (at, square) = (surroundings.at((x, y)), (x / SQUARE, y / SQUARE));
                        let found = surroundings.may_be_enclosed(at, &[surroundings.w[at]; SQUARE]) & 1 == 1;
                        assert_eq!(found, plainly_enclosed(&picture, (x, y), ENOUGH_TO_TEST));
                        assert!(
                            !found || surroundings.may_enclose(square.0, square.1),
                            "({x}, {y}), seed {seed}"
                        );
                        let is_enclosed = surroundings.is_enclosed(at, surroundings.w[at], |_| true);
                        assert_eq!(is_enclosed, plainly_enclosed(&picture, (x, y), ENOUGH));
                        may += usize::from(found);
                        passed_over += usize::from(!surroundings.may_enclose(square.0, square.1));
                    }
                }
            }
        }
        // Both happen, so that neither answer goes untested.
        assert!(may > 10_000 && passed_over > 10_000, "{may} may be enclosed, {passed_over} passed over");
    }

    #[test]
    fn a_pixel_is_not_enclosed_over_pixels_that_are_seen_free() {
        // A ring of surface around 9×9 pixels of sky.
        let mut picture = patches((160, 40), 1, u32::MAX, 0);
        for y in 0..40_usize {
            for x in 0..160_usize {
                let from_middle = x.abs_diff(20).max(y.abs_diff(20));
                picture.inverse_depth[(x, y)] = if from_middle == 5 { 1.0 } else { 0.0 };
            }
        }
        let surroundings = Surroundings::new(&picture);
        let middle = surroundings.at((20, 20));
        let w = surroundings.w[middle];
        assert!(surroundings.is_enclosed(middle, w, |_| true));
        let (left, right) = (surroundings.at((18, 20)), surroundings.at((22, 20)));
        assert!(surroundings.is_enclosed(middle, w, |there| there != left));
        assert!(!surroundings.is_enclosed(middle, w, |there| there != left && there != right));
        // The ring itself is enclosed by nothing.
        assert!(!surroundings.is_enclosed(surroundings.at((15, 20)), 1.0, |_| true));
    }

    #[test]
    fn the_range_around_a_pixel_counts_surfaces_but_neither_sky_nor_holes() {
        let mut picture = patches((100, 100), 1, u32::MAX, 0);
        picture.inverse_depth = Grid::filled(100, 100, 0.0);
        picture.inverse_depth[(40, 40)] = -1.0;
        assert_eq!(Surroundings::new(&picture).range_at((50, 50)), SurfaceRange::NONE);
        picture.inverse_depth[(50, 52)] = 0.5;
        picture.inverse_depth[(70, 30)] = 0.25;
        picture.inverse_depth[(99, 99)] = 2.0;
        let range = Surroundings::new(&picture).range_at((50, 50));
        assert_eq!(range, SurfaceRange { nearest: 0.5, farthest: 0.25 });
    }

    #[test]
    fn the_more_is_hidden_the_less_of_the_sky_is_shown_and_least_within_nearer_surfaces() {
        for hidden in [1.0 / 64.0, 0.1, 0.5, 1.0] {
            let share = |place| sky_share(place, hidden);
            assert!(share(HolePlace::Enclosed) < share(HolePlace::Facing));
            assert!(share(HolePlace::Facing) < share(HolePlace::Open));
            assert!(sky_share(HolePlace::Facing, 2.0 * hidden) < share(HolePlace::Facing));
        }
        assert_eq!(sky_share(HolePlace::Enclosed, f32::INFINITY), 0.0);
    }
}
