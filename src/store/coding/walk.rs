//! The one walk over a block that counting, encoding and decoding share: what each number is predicted from, and in which
//! context its residual is coded.
//!
//! Prediction of colors is the median of Weinberger, Seroussi and Sapiro, *The LOCO-I lossless image compression algorithm*
//! (JPEG-LS), 2000; red and blue take over what green was mispredicted by. Surfaces are planes in inverse depth, so that it is
//! continued from two or three neighbors as a plane, and the median of up to four such planes is taken: one of them across a
//! silhouette does no harm. What differs: where the *reference*, the image of the frames just before, has a sample at the pixel,
//! that sample is the prediction. Its depth is believed only while a neighbor's depth equalled its reference's: things move.
//!
//! ```text
//!              NN
//!          NW  N  NE          neighbors are those of the same block that hold a sample
//!      WW  W   ×
//! ```

use super::integers::{unzigzag, zigzag};
use super::model::{ACTIVITIES, Plane};

/// Columns and rows of a block: four tiles.
pub const BLOCK: usize = 64;

/// Numbers a sample has at most: depth, green, red, blue, and two of the normal.
pub const NUMBERS: usize = 6;

/// Columns to the left of a block and rows above it that never hold a sample, so that no neighbor needs a check.
const MARGIN: usize = 2;
const STRIDE: usize = BLOCK + MARGIN + 1;
const CELLS: usize = (BLOCK + MARGIN + 1) * STRIDE;

/// Where a pixel of a block stands in its arrays.
#[inline(always)]
#[must_use]
pub const fn cell(x: usize, y: usize) -> usize {
    (y + MARGIN) * STRIDE + x + MARGIN
}

/// What a block of pixels holds.
pub struct Pixels {
    /// Whether there is a sample, by [`cell`].
    pub present: Vec<bool>,
    /// Per number (depth, green, red, blue, normal), by [`cell`]: depth as shifted bits, color as a rank, normal as it is.
    pub values: [Vec<i32>; NUMBERS],
}

impl Default for Pixels {
    /// An empty block.
    fn default() -> Self {
        Self { present: vec![false; CELLS], values: std::array::from_fn(|_| vec![0; CELLS]) }
    }
}

impl Pixels {
    /// Forgets every sample.
    pub fn clear(&mut self) {
        self.present.fill(false);
    }
}

/// What is known of a block before its samples.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// Columns of the block that lie in the picture.
    pub width: usize,
    /// Rows of the block that lie in the picture.
    pub height: usize,
    /// Bit `4 y + x`: whether the tile in column `x`, row `y` of the block holds a sample.
    pub tiles: u16,
    /// Lowest bits that no inverse depth of the store has.
    pub depth_shift: u32,
    /// Colors of the palette.
    pub colors: usize,
    /// Whether samples have normals.
    pub normals: bool,
}

/// What becomes of residuals.
pub trait Coder {
    /// Whether numbers are predicted; without, they come as they are.
    const PREDICTS: bool = true;

    /// Codes `value`, or ignores it and decodes one.
    fn code(&mut self, plane: Plane, context: usize, value: u32) -> u32;
}

/// Walks over a block. Reused from block to block.
pub struct Walker {
    /// Zigzag residuals of each number, by [`cell`].
    residuals: [Vec<u32>; NUMBERS],
    /// Whether the depth equalled the reference's, by [`cell`].
    as_before: Vec<bool>,
    /// Cells that hold a sample, in order.
    cells: Vec<usize>,
}

/// The cells around one that hold a sample.
#[derive(Clone, Copy)]
struct Neighbors {
    w: Option<usize>,
    n: Option<usize>,
    nw: Option<usize>,
    ne: Option<usize>,
    ww: Option<usize>,
    nn: Option<usize>,
}

impl Neighbors {
    #[inline(always)]
    fn of(present: &[bool], at: usize) -> Self {
        let held = |cell: usize| present[cell].then_some(cell);
        Self {
            w: held(at - 1),
            n: held(at - STRIDE),
            nw: held(at - STRIDE - 1),
            ne: held(at - STRIDE + 1),
            ww: held(at - 2),
            nn: held(at - 2 * STRIDE),
        }
    }

    #[inline(always)]
    fn any(self) -> Option<usize> {
        self.w.or(self.n).or(self.nw).or(self.ne)
    }
}

impl Default for Walker {
    /// Ready for any block.
    fn default() -> Self {
        Self {
            residuals: std::array::from_fn(|_| vec![0; CELLS]),
            as_before: vec![false; CELLS],
            cells: Vec::with_capacity(BLOCK * BLOCK),
        }
    }
}

impl Walker {
    /// Hands every number of `pixels` to `coder` and takes what it gives back.
    pub fn walk<C: Coder>(
        &mut self,
        coder: &mut C,
        shape: &Shape,
        pixels: &mut Pixels,
        reference: Option<&Pixels>,
    ) {
        self.mask(coder, shape, &mut pixels.present, reference.map(|reference| reference.present.as_slice()));
        for nth in 0..self.cells.len() {
            let at = self.cells[nth];
            let near = Neighbors::of(&pixels.present, at);
            let before = reference.filter(|reference| reference.present[at]);
            self.depth(coder, shape.depth_shift, &mut pixels.values[0], near, (at, before));
            self.color(coder, shape.colors, &mut pixels.values, near, (at, before));
            if shape.normals {
                self.normal(coder, &mut pixels.values, near, (at, before));
            }
        }
    }

    fn mask<C: Coder>(
        &mut self,
        coder: &mut C,
        shape: &Shape,
        present: &mut [bool],
        reference: Option<&[bool]>,
    ) {
        self.cells.clear();
        for y in 0..shape.height {
            for tile_x in 0..shape.width.div_ceil(16) {
                if shape.tiles >> (y / 16 * 4 + tile_x) & 1 == 0 {
                    continue;
                }
                for x in tile_x * 16..shape.width.min(tile_x * 16 + 16) {
                    let at = cell(x, y);
                    let held = |cell: usize| usize::from(present[cell]);
                    let mut context = held(at - 1)
                        | held(at - STRIDE) << 1
                        | held(at - STRIDE - 1) << 2
                        | held(at - STRIDE + 1) << 3
                        | held(at - 2) << 4
                        | held(at - 2 * STRIDE) << 5;
                    if let Some(reference) = reference {
                        let held = |cell: usize| usize::from(reference[cell]);
                        context |= held(at) << 6 | held(at + 1) << 7 | held(at + STRIDE) << 8 | 1 << 9;
                    }
                    present[at] = coder.code(Plane::Mask, context, u32::from(present[at])) != 0;
                    if present[at] {
                        self.cells.push(at);
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn depth<C: Coder>(
        &mut self,
        coder: &mut C,
        shift: u32,
        depths: &mut [i32],
        near: Neighbors,
        (at, before): (usize, Option<&Pixels>),
    ) {
        let (spatial, kind) = plane_prediction(depths, shift, near);
        let before = before.map(|before| before.values[0][at]);
        let (prediction, kind) = match before {
            None => (spatial, kind),
            Some(before) => {
                let known = usize::from(near.w.is_some()) + usize::from(near.n.is_some());
                let resting = near.w.is_some_and(|w| self.as_before[w]);
                let resting = usize::from(resting) + usize::from(near.n.is_some_and(|n| self.as_before[n]));
                if known == 0 || resting > 0 { (before, 4 + resting) } else { (spatial, 7 + kind) }
            }
        };
        let context = kind * ACTIVITIES + activity(&self.residuals[0], near);
        code_number(coder, (Plane::Depth, context), prediction, &mut depths[at], &mut self.residuals[0][at]);
        self.as_before[at] = before == Some(depths[at]);
    }

    #[inline(always)]
    fn color<C: Coder>(
        &mut self,
        coder: &mut C,
        colors: usize,
        values: &mut [Vec<i32>; NUMBERS],
        near: Neighbors,
        (at, before): (usize, Option<&Pixels>),
    ) {
        let mut green_residual = 0;
        for (number, plane) in [(1, Plane::Green), (2, Plane::Red), (3, Plane::Blue)] {
            let channel = &mut values[number];
            let (spatial, kind) = median_prediction(channel, near, colors);
            let (prediction, kind) = match before {
                Some(before) => (before.values[number][at], kind + 3),
                None => (spatial, kind),
            };
            let mut context = kind * ACTIVITIES + activity(&self.residuals[number], near);
            if number > 1 {
                context = context * 8 + bit_length(zigzag(green_residual)).min(14) / 2;
            }
            let prediction = prediction.wrapping_add(green_residual);
            let residual = &mut self.residuals[number][at];
            code_number(coder, (plane, context), prediction, &mut channel[at], residual);
            if number == 1 {
                green_residual = unzigzag(*residual);
            }
        }
    }

    #[inline(always)]
    fn normal<C: Coder>(
        &mut self,
        coder: &mut C,
        values: &mut [Vec<i32>; NUMBERS],
        near: Neighbors,
        (at, before): (usize, Option<&Pixels>),
    ) {
        for (number, plane) in [(4, Plane::NormalX), (5, Plane::NormalY)] {
            let axis = &mut values[number];
            let (prediction, kind) = match (before, near.any()) {
                (Some(before), _) => (before.values[number][at], 2),
                (None, Some(neighbor)) => (axis[neighbor], 1),
                (None, None) => (0, 0),
            };
            let context = kind * ACTIVITIES + activity(&self.residuals[number], near);
            code_number(coder, (plane, context), prediction, &mut axis[at], &mut self.residuals[number][at]);
        }
    }
}

#[inline(always)]
fn code_number<C: Coder>(
    coder: &mut C,
    (plane, context): (Plane, usize),
    prediction: i32,
    value: &mut i32,
    residual: &mut u32,
) {
    if C::PREDICTS {
        *residual = coder.code(plane, context, zigzag(value.wrapping_sub(prediction)));
        *value = prediction.wrapping_add(unzigzag(*residual));
    } else {
        *value = coder.code(plane, 0, *value as u32) as i32;
    }
}

#[inline(always)]
fn bit_length(value: u32) -> usize {
    (32 - value.leading_zeros()) as usize
}

/// How badly the neighbors were predicted: the length of four times the mean of their residuals, nearer ones twice.
#[inline(always)]
fn activity(residuals: &[u32], near: Neighbors) -> usize {
    let (mut sum, mut weight) = (0_u64, 0);
    for (neighbor, of) in [(near.w, 2), (near.n, 2), (near.nw, 1), (near.ne, 1)] {
        if let Some(neighbor) = neighbor {
            sum += of * u64::from(residuals[neighbor]);
            weight += of;
        }
    }
    let four = sum * 4;
    let mean = match weight {
        0 => return ACTIVITIES - 1,
        1 => four,
        2 => four / 2,
        3 => four / 3,
        4 => four / 4,
        5 => four / 5,
        _ => four / 6,
    };
    ((u64::BITS - mean.leading_zeros()) as usize).min(ACTIVITIES - 2)
}

/// Bits of an inverse depth of 1/8 per unit of length: what is predicted where nothing is known.
const NO_DEPTH: i32 = 0x3E00_0000;

/// The depth at a pixel if its neighbors lie on one plane, and from how much that was concluded: 3 a plane, 2 a neighbor, 1 nothing.
#[inline(always)]
fn plane_prediction(depths: &[i32], shift: u32, near: Neighbors) -> (i32, usize) {
    let depth = |cell: usize| f64::from(f32::from_bits((depths[cell] as u32) << shift));
    let mut planes = [0.0; 4];
    let mut count = 0;
    let mut add = |plane: f64| {
        planes[count] = plane;
        count += 1;
    };
    if let (Some(w), Some(n), Some(nw)) = (near.w, near.n, near.nw) {
        add(depth(w) + depth(n) - depth(nw));
    }
    if let (Some(w), Some(ww)) = (near.w, near.ww) {
        add(2.0 * depth(w) - depth(ww));
    }
    if let (Some(n), Some(nn)) = (near.n, near.nn) {
        add(2.0 * depth(n) - depth(nn));
    }
    if let (Some(w), Some(n), Some(ne)) = (near.w, near.n, near.ne) {
        add(depth(w) + depth(ne) - depth(n));
    }
    if count == 0 {
        return near.any().map_or((NO_DEPTH >> shift, 1), |neighbor| (depths[neighbor], 2));
    }
    let planes = &mut planes[..count];
    planes.sort_unstable_by(f64::total_cmp);
    let median = f64::midpoint(planes[(count - 1) / 2], planes[count / 2]);
    let bits = (median as f32).max(0.0).to_bits();
    // Rounded to the numbers that the store has.
    let half = if shift == 0 { 0 } else { 1 << (shift - 1) };
    ((bits.wrapping_add(half) >> shift) as i32, 3)
}

/// The color at a pixel from its neighbors, and from how much that was concluded: 0 two or three of them, 1 one, 2 none.
#[inline(always)]
fn median_prediction(channel: &[i32], near: Neighbors, colors: usize) -> (i32, usize) {
    match (near.w, near.n, near.nw) {
        (Some(w), Some(n), Some(nw)) => {
            let (w, n, nw) = (channel[w], channel[n], channel[nw]);
            let (low, high) = (w.min(n), w.max(n));
            let prediction = if nw >= high {
                low
            } else if nw <= low {
                high
            } else {
                w.wrapping_add(n).wrapping_sub(nw)
            };
            (prediction, 0)
        }
        (Some(w), Some(n), None) => (i32::midpoint(channel[w], channel[n]), 0),
        _ => near.any().map_or((colors as i32 / 2, 2), |neighbor| (channel[neighbor], 1)),
    }
}
