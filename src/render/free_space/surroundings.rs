//! What surrounds a pixel: the nearest and farthest surfaces around it, and in which directions a nearer surface is found.

use rayon::prelude::*;

use crate::render::vantage::Picture;

/// How far is looked for a nearer surface, pixels.
pub(super) const REACH: usize = 16;

/// A surface is nearer than what a pixel shows if its inverse depth is more than this many times as large: what lies as near as
/// that is left to the silhouettes, which the cameras vote on.
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

/// Columns and rows of the squares whose surfaces are taken together: no less than [`REACH`], so that a direction leads through a
/// pixel's own square and its neighbors alone.
pub(super) const SQUARE: usize = REACH;

/// Surfaces are looked for in this many squares on each side of a pixel's own.
const SQUARES_AROUND: usize = 2;

/// Inverse depths of the nearest and the farthest surface, not counting the sky; 0 and infinite where there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DepthRange {
    pub(super) nearest: f32,
    pub(super) farthest: f32,
}

impl DepthRange {
    const NONE: Self = Self { nearest: 0.0, farthest: f32::INFINITY };

    #[inline(always)]
    fn joined(self, other: Self) -> Self {
        Self { nearest: self.nearest.max(other.nearest), farthest: self.farthest.min(other.farthest) }
    }
}

/// The surroundings of the pixels of a picture.
pub(super) struct Surroundings {
    /// Columns of the picture with a border of [`REACH`] pixels on each side.
    pub(super) across: usize,
    /// Inverse depths with the border; 0 at infinity and in holes, [`OUTSIDE`] in the border.
    pub(super) w: Vec<f32>,
    /// Columns of squares.
    squares_across: usize,
    /// The surfaces in each square.
    squares: Vec<DepthRange>,
    /// The surfaces in each square and those around it.
    around: Vec<DepthRange>,
}

impl Surroundings {
    /// Of the pixels of a picture.
    pub(super) fn new(picture: &Picture) -> Self {
        let (width, height) = picture.image.size();
        let across = width + 2 * REACH;
        let mut w = vec![OUTSIDE; across * (height + 2 * REACH)];
        let rows =
            w.par_chunks_mut(across).skip(REACH).zip(picture.inverse_depth.as_slice().par_chunks(width));
        rows.for_each(|(row, from)| {
            row[REACH..][..width].iter_mut().zip(from).for_each(|(w, from)| *w = from.max(0.0));
        });
        let squares_across = width.div_ceil(SQUARE);
        let depths = picture.inverse_depth.as_slice().par_chunks(width * SQUARE);
        let squares: Vec<DepthRange> =
            depths.flat_map_iter(|rows| ranges(rows, width, squares_across)).collect();
        let around =
            (0..squares.len()).map(|square| joined_around(&squares, squares_across, square)).collect();
        Self { across, w, squares_across, squares, around }
    }

    /// Where a pixel of the picture is in `w`.
    #[inline(always)]
    pub(super) fn at(&self, (x, y): (usize, usize)) -> usize {
        (y + REACH) * self.across + x + REACH
    }

    /// The surfaces around a pixel of the picture.
    #[inline(always)]
    pub(super) fn range_at(&self, (x, y): (usize, usize)) -> DepthRange {
        self.around[y / SQUARE * self.squares_across + x / SQUARE]
    }

    /// Whether surfaces in enough of the squares around a square may enclose one of its pixels.
    #[inline(always)]
    pub(super) fn may_enclose(&self, column: usize, row: usize) -> bool {
        let down = self.squares.len() / self.squares_across;
        let has_surface = |right: isize, below: isize| {
            let (column, row) = (column.wrapping_add_signed(right), row.wrapping_add_signed(below));
            let inside = column < self.squares_across && row < down;
            !inside || self.squares[row * self.squares_across + column].nearest > 0.0
        };
        let leads_to_surface = |&(right, below): &(isize, isize)| {
            has_surface(0, 0) || has_surface(right, 0) || has_surface(0, below) || has_surface(right, below)
        };
        DIRECTIONS.iter().filter(|direction| leads_to_surface(direction)).count() >= ENOUGH_TO_TEST
    }

    /// Whether lines of sight have to be tested at a position: enough directions lead to a nearer surface, or out of the picture.
    #[inline(always)]
    pub(super) fn may_be_enclosed(&self, at: usize) -> bool {
        self.leads_to_nearer(at, ENOUGH_TO_TEST, |_| true)
    }

    /// Whether a position is enclosed: enough directions lead to a nearer surface, or out of the picture, over pixels whose lines of
    /// sight are `hidden`.
    #[inline(always)]
    pub(super) fn is_enclosed(&self, at: usize, hidden: impl Fn(usize) -> bool) -> bool {
        self.leads_to_nearer(at, ENOUGH, hidden)
    }

    /// Whether `enough` directions lead from a position over pixels that `passes` holds for to a nearer surface.
    #[inline(always)]
    fn leads_to_nearer(&self, at: usize, enough: usize, passes: impl Fn(usize) -> bool) -> bool {
        let limit = self.w[at] * NEARER;
        let mut missing = 0;
        for (right, down) in DIRECTIONS {
            let stride = down * self.across as isize + right;
            let mut there = at;
            let mut is_found = false;
            for _ in 0..REACH {
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

/// The surfaces in each square of a row of squares, from the inverse depths of its pixels.
fn ranges(rows: &[f32], width: usize, squares_across: usize) -> Vec<DepthRange> {
    let mut squares = vec![DepthRange::NONE; squares_across];
    for line in rows.chunks(width) {
        for (square, line) in squares.iter_mut().zip(line.chunks(SQUARE)) {
            for &w in line {
                let farthest = if w > 0.0 { w } else { f32::INFINITY };
                *square = square.joined(DepthRange { nearest: w.max(0.0), farthest });
            }
        }
    }
    squares
}

/// The surfaces in a square and those around it.
fn joined_around(squares: &[DepthRange], across: usize, square: usize) -> DepthRange {
    let down = squares.len() / across;
    let (column, row) = (square % across, square / across);
    let span = |middle: usize, count: usize| {
        middle.saturating_sub(SQUARES_AROUND)..(middle + SQUARES_AROUND + 1).min(count)
    };
    let rows = span(row, down).map(|row| &squares[row * across..][..across]);
    let around = rows.flat_map(|squares| &squares[span(column, across)]);
    around.fold(DepthRange::NONE, |all, square| all.joined(*square))
}
