//! A part of the picture with what surrounds it: the nearest and farthest surfaces around each pixel, and in how many directions a
//! nearer surface is found.

use crate::render::vantage::Picture;

/// How far is looked for a nearer surface, pixels: four doublings.
pub(super) const REACH: usize = 16;

/// Pixels around the part that is judged. Pixels within reach of those that are judged must be tested, and their directions be
/// counted.
pub(super) const MARGIN: usize = 2 * REACH;

/// A surface is nearer than what a pixel shows if its inverse depth is more than this many times as large: what lies as near as
/// that is left to the silhouettes, which the cameras vote on.
pub(super) const NEARER: f32 = 2.0;

/// Beyond the picture there may be anything.
pub(super) const OUTSIDE: f32 = f32::INFINITY;

/// The eight directions, as steps in columns and rows.
const DIRECTIONS: [(isize, isize); 8] = [(1, 0), (0, 1), (1, 1), (-1, 1), (-1, 0), (0, -1), (-1, -1), (1, -1)];

/// Columns and rows of the squares whose surfaces are taken together.
const SQUARE: usize = 16;

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

/// Some rows of a picture and [`MARGIN`] pixels around them.
pub(super) struct Window {
    /// Columns with the margin.
    pub(super) across: usize,
    down: usize,
    /// Inverse depths; 0 at infinity and in holes, [`OUTSIDE`] beyond the picture.
    pub(super) w: Vec<f32>,
    /// In how many directions a nearer surface is found within [`REACH`].
    pub(super) counts: Vec<u8>,
    /// See [`Window::range_at`].
    ranges: Vec<DepthRange>,
    /// Largest inverse depths in a direction.
    running: [Vec<f32>; 2],
    /// Where the line of sight passes space that no camera has seen free, the inverse depth at which that ends; NaN elsewhere.
    pub(super) hidden_until: Vec<f32>,
}

impl Window {
    pub(super) fn new() -> Self {
        Self {
            across: 0,
            down: 0,
            w: Vec::new(),
            counts: Vec::new(),
            ranges: Vec::new(),
            running: [Vec::new(), Vec::new()],
            hidden_until: Vec::new(),
        }
    }

    /// The pixel of the picture at a position in the window, if it lies in the picture; `top` is the first row that is judged.
    #[inline(always)]
    pub(super) fn pixel(&self, at: usize, top: usize, size: (usize, usize)) -> Option<(usize, usize)> {
        let x = (at % self.across).checked_sub(MARGIN).filter(|x| *x < size.0)?;
        let y = (top + at / self.across).checked_sub(MARGIN).filter(|y| *y < size.1)?;
        Some((x, y))
    }

    /// Loads `rows` rows of a picture from row `top` on, and finds out about their surroundings.
    #[inline(always)]
    pub(super) fn load(&mut self, picture: &Picture, top: usize, rows: usize) {
        let (width, height) = picture.image.size();
        (self.across, self.down) = (width + 2 * MARGIN, rows + 2 * MARGIN);
        let count = self.across * self.down;
        for plane in self.running.iter_mut().chain([&mut self.w, &mut self.hidden_until]) {
            plane.resize(count, 0.0);
        }
        self.counts.resize(count, 0);
        self.w.fill(OUTSIDE);
        self.hidden_until.fill(f32::NAN);
        for (row, line) in self.w.chunks_exact_mut(self.across).enumerate() {
            if let Some(y) = (top + row).checked_sub(MARGIN).filter(|y| *y < height) {
                let from = &picture.inverse_depth.as_slice()[y * width..][..width];
                for (w, from) in line[MARGIN..][..width].iter_mut().zip(from) {
                    *w = from.max(0.0);
                }
            }
        }
        self.find_ranges();
        self.count_directions();
    }

    /// The surfaces around a position.
    #[inline(always)]
    pub(super) fn range_at(&self, at: usize) -> DepthRange {
        let (column, row) = (at % self.across / SQUARE, at / self.across / SQUARE);
        self.ranges[row * self.across.div_ceil(SQUARE) + column]
    }

    /// Whether at least `enough` directions lead from a position over pixels of hidden lines of sight to a nearer surface, or out of
    /// the picture.
    #[inline(always)]
    pub(super) fn is_enclosed(&self, at: usize, enough: u32) -> bool {
        let limit = self.w[at] * NEARER;
        let leads_to_nearer = |(right, down): (isize, isize)| {
            let stride = down * self.across as isize + right;
            let mut there = at;
            for _ in 0..REACH {
                there = there.wrapping_add_signed(stride);
                if self.w[there] > limit {
                    return true;
                }
                if self.hidden_until[there].is_nan() {
                    return false;
                }
            }
            false
        };
        DIRECTIONS.iter().filter(|direction| leads_to_nearer(**direction)).count() >= enough as usize
    }

    #[inline(always)]
    fn find_ranges(&mut self) {
        let (across, down) = (self.across.div_ceil(SQUARE), self.down.div_ceil(SQUARE));
        let mut squares = vec![DepthRange::NONE; across * down];
        for (row, line) in self.w.chunks_exact(self.across).enumerate() {
            let squares = &mut squares[row / SQUARE * across..][..across];
            for (square, line) in squares.iter_mut().zip(line.chunks(SQUARE)) {
                for &w in line {
                    let is_surface = w > 0.0 && w < OUTSIDE;
                    let range = if is_surface { DepthRange { nearest: w, farthest: w } } else { DepthRange::NONE };
                    *square = square.joined(range);
                }
            }
        }
        self.ranges.clear();
        for row in 0..down {
            let rows = row.saturating_sub(SQUARES_AROUND)..(row + SQUARES_AROUND + 1).min(down);
            for column in 0..across {
                let columns = column.saturating_sub(SQUARES_AROUND)..(column + SQUARES_AROUND + 1).min(across);
                let around = rows.clone().flat_map(|row| &squares[row * across..][columns.clone()]);
                self.ranges.push(around.fold(DepthRange::NONE, |all, square| all.joined(*square)));
            }
        }
    }

    /// Sets `counts` of all pixels that are at least [`REACH`] pixels from the window's edge.
    #[inline(always)]
    fn count_directions(&mut self) {
        let Self { across, down, w, counts, running, .. } = self;
        let (across, down) = (*across, *down);
        counts.fill(0);
        for (right, below) in DIRECTIONS {
            let [from, to] = &mut *running;
            from.copy_from_slice(w);
            let stride = below * across as isize + right;
            let mut reach = 1;
            while reach < REACH {
                // The largest of twice as many pixels in this direction, the first one included.
                largest_of_two(from, to, stride * reach as isize);
                std::mem::swap(from, to);
                reach *= 2;
            }
            for row in REACH..down - REACH {
                let at = row * across + REACH;
                let count = across - 2 * REACH;
                let ahead = &from[at.wrapping_add_signed(stride)..][..count];
                let (here, counts) = (&w[at..][..count], &mut counts[at..][..count]);
                for ((count, here), ahead) in counts.iter_mut().zip(here).zip(ahead) {
                    *count += u8::from(*ahead > *here * NEARER);
                }
            }
        }
    }
}

/// The larger of each value and the one `stride` after it.
#[inline(always)]
fn largest_of_two(from: &[f32], to: &mut [f32], stride: isize) {
    let shift = stride.unsigned_abs();
    let inner = from.len() - shift;
    let (here, ahead, to) = if stride >= 0 {
        (&from[..inner], &from[shift..], &mut to[..inner])
    } else {
        (&from[shift..], &from[..inner], &mut to[shift..])
    };
    for ((to, here), ahead) in to.iter_mut().zip(here).zip(ahead) {
        *to = here.max(*ahead);
    }
}
