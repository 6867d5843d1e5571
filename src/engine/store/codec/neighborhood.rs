//! The causal neighborhood of a pixel in a block: the samples coded before it, the reference's, and what they predict.
//!
//! ```text
//!              NN
//!          NW  N  NE          neighbors are those of the same block that hold a sample
//!      WW  W   ×
//! ```

use super::model::ACTIVITIES;

/// Columns and rows of a block: four tiles.
pub(crate) const BLOCK: usize = 64;

/// Numbers a sample has at most: depth, green, red, blue, and two of the normal.
pub(super) const NUMBERS: usize = 6;

/// Columns to the left of a block and rows above it that never hold a sample, so that reading a neighbor needs no check.
const MARGIN: usize = 2;
pub(crate) const STRIDE: usize = BLOCK + MARGIN + 1;
pub(crate) const CELLS: usize = (BLOCK + MARGIN) * STRIDE;

/// The index of a pixel of a block in its arrays.
#[inline(always)]
pub(crate) const fn cell(x: usize, y: usize) -> usize {
    (y + MARGIN) * STRIDE + x + MARGIN
}

/// Something of every pixel of a block, by [`cell`].
pub(super) type PerPixel<T> = [T; CELLS];

/// What a block of pixels holds.
pub(crate) struct BlockPixels {
    /// Per row, bit `x`: whether there is a sample in column `x`.
    pub(crate) rows: [u64; BLOCK],
    /// Per number (depth, green, red, blue, normal), by [`cell`]: depth as shifted bits, color as a rank, normal as it is. Only
    /// those of samples mean something.
    pub(crate) values: Box<[PerPixel<i32>; NUMBERS]>,
}

impl Default for BlockPixels {
    /// An empty block.
    #[expect(clippy::large_stack_arrays, reason = "once a thread, on its way to the heap")]
    fn default() -> Self {
        Self { rows: [0; BLOCK], values: Box::new([[0; CELLS]; NUMBERS]) }
    }
}

impl BlockPixels {
    /// Forgets every sample.
    pub(crate) fn clear(&mut self) {
        self.rows = [0; BLOCK];
    }
}

/// Which of the pixels around one hold a sample: bits as the mask's context has them. All of these are coded before it.
#[derive(Clone, Copy, Default)]
pub(crate) struct Neighbors(pub(crate) u8);

pub(crate) const W: u8 = 1;
pub(crate) const N: u8 = 1 << 1;
pub(crate) const NW: u8 = 1 << 2;
pub(crate) const NE: u8 = 1 << 3;
pub(crate) const WW: u8 = 1 << 4;
pub(crate) const NN: u8 = 1 << 5;
/// No neighbor: the same pixel of the reference.
pub(crate) const R: u8 = 1 << 6;

/// Every neighbor.
pub(crate) const AROUND: u8 = W | N | NW | NE | WW | NN;

impl Neighbors {
    #[inline(always)]
    pub(crate) fn has(self, pixels: u8) -> bool {
        self.0 & pixels == pixels
    }

    /// How many there are of one.
    #[inline(always)]
    pub(crate) fn count(self, pixel: u8) -> u32 {
        u32::from(self.0 >> pixel.trailing_zeros() & 1)
    }

    /// The cell of the first of W, N, NW, NE that there is.
    #[inline(always)]
    pub(crate) fn first(self, at: usize) -> Option<usize> {
        const BACK: [usize; 4] = [1, STRIDE, STRIDE + 1, STRIDE - 1];
        let near = self.0 & (W | N | NW | NE);
        (near != 0).then(|| at - BACK[near.trailing_zeros() as usize % 4])
    }
}

/// The index of a sample, what is around it, and the block in the reference if that has the sample too.
#[derive(Clone, Copy)]
pub(crate) struct CodingContext<'a> {
    pub(crate) at: usize,
    pub(crate) near: Neighbors,
    pub(crate) before: Option<&'a BlockPixels>,
}

#[inline(always)]
pub(crate) fn bit_length(value: u32) -> usize {
    (32 - value.leading_zeros()) as usize
}

/// How badly the neighbors were predicted: the length of four times the mean of their residuals, nearer ones twice.
#[inline(always)]
pub(crate) fn activity(residuals: &PerPixel<u32>, place: CodingContext<'_>) -> usize {
    /// By which of W, N, NW, NE there are: 2³² over the sum of their weights, rounded up. Exact for what is divided here.
    const RECIPROCALS: [u64; 16] = {
        let mut reciprocals = [0; 16];
        let mut near = 1;
        while near < 16 {
            let weights = 2 * (near & 1) + 2 * (near >> 1 & 1) + (near >> 2 & 1) + (near >> 3 & 1);
            reciprocals[near as usize] = (1_u64 << 32).div_ceil(weights);
            near += 1;
        }
        reciprocals
    };
    let CodingContext { at, near, .. } = place;
    let of = |back: usize, pixel| u64::from(residuals[at - back]) * u64::from(near.count(pixel));
    let sum = 2 * (of(1, W) + of(STRIDE, N)) + of(STRIDE + 1, NW) + of(STRIDE - 1, NE);
    // From here on the length is the largest in any case.
    let four = (4 * sum).min(1 << 20);
    let mean = (four * RECIPROCALS[usize::from(near.0 & (W | N | NW | NE))]) >> 32;
    if near.first(at).is_none() { ACTIVITIES - 1 } else { bit_length(mean as u32).min(ACTIVITIES - 2) }
}

/// Bits of an inverse depth of 1/8 per unit of length: what is predicted where nothing is known.
const NO_DEPTH: i32 = 0x3E00_0000;

/// The depth at a pixel if its neighbors are on one plane, and from how much that was concluded: 3 a plane, 2 a neighbor, 1 nothing.
#[inline(always)]
pub(crate) fn plane_prediction(depths: &PerPixel<i32>, shift: u32, place: CodingContext<'_>) -> (i32, usize) {
    let CodingContext { at, near, .. } = place;
    let depth = |back: usize| f64::from(f32::from_bits((depths[at - back] as u32) << shift));
    let [w, n, nw, ne] = [depth(1), depth(STRIDE), depth(STRIDE + 1), depth(STRIDE - 1)];
    let planes = [w + n - nw, 2.0 * w - depth(2), 2.0 * n - depth(2 * STRIDE), w + ne - n];
    let there = [W | N | NW, W | WW, N | NN, W | N | NE].map(|pixels| near.has(pixels));
    let count = there.iter().filter(|there| **there).count();
    if count == 0 {
        return near.first(at).map_or((NO_DEPTH >> shift, 1), |first| (depths[first % CELLS], 2));
    }
    // Those that are not there are sorted to the end.
    let mut planes: [f64; 4] =
        std::array::from_fn(|nth| if there[nth] { planes[nth] } else { f64::INFINITY });
    for (a, b) in [(0, 1), (2, 3), (0, 2), (1, 3), (1, 2)] {
        let (low, high) = if planes[b] < planes[a] { (planes[b], planes[a]) } else { (planes[a], planes[b]) };
        (planes[a], planes[b]) = (low, high);
    }
    let median = (planes[(count - 1) / 2] + planes[count / 2 % 4]) * 0.5;
    let bits = (median as f32).max(0.0).to_bits();
    // Rounded to the numbers that the store has.
    let half = if shift == 0 { 0 } else { 1 << (shift - 1) };
    ((bits.wrapping_add(half) >> shift) as i32, 3)
}

/// The color at a pixel from its neighbors.
#[inline(always)]
pub(crate) fn median_prediction(channel: &PerPixel<i32>, place: CodingContext<'_>, colors: usize) -> i32 {
    let CodingContext { at, near, .. } = place;
    if !near.has(W | N) {
        return near.first(at).map_or(colors as i32 / 2, |first| channel[first % CELLS]);
    }
    let (w, n) = (channel[at - 1], channel[at - STRIDE]);
    if near.has(NW) {
        // The median of W, N and W + N − NW.
        w.wrapping_add(n).wrapping_sub(channel[at - STRIDE - 1]).max(w.min(n)).min(w.max(n))
    } else {
        i32::midpoint(w, n)
    }
}
