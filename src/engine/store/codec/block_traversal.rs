//! The traversal of a block that counting, encoding and decoding share: what each number is predicted from, and in which context
//! its residual is coded.
//!
//! Prediction of colors is the median of Weinberger, Seroussi and Sapiro, *The LOCO-I lossless image compression algorithm*
//! (JPEG-LS), 2000; red and blue take over what green was mispredicted by. Surfaces are planes in inverse depth, so that it is
//! continued from two or three neighbors as a plane, and the median of up to four such planes is taken: one of them across a
//! silhouette does no harm. What differs: where the *reference*, the image of the frames just before, has a sample at the pixel,
//! that sample is the prediction. Its depth is believed only while a neighbor's depth equalled its reference's: things move.

use super::integers::{unzigzag, zigzag};
use super::model::{ACTIVITIES, CodedPlane};
use super::neighborhood::{
    AROUND, BLOCK, BlockPixels, CELLS, CodingContext, N, NE, NN, NUMBERS, NW, Neighbors, PerPixel, R, STRIDE,
    W, WW, activity, bit_length, cell, median_prediction, plane_prediction,
};
use super::rans::STREAMS;

/// What is known of a block before its samples.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BlockShape {
    /// Columns of the block that are in the picture.
    pub(crate) width: usize,
    /// Rows of the block that are in the picture.
    pub(crate) height: usize,
    /// Bit `4 y + x`: whether the tile in column `x`, row `y` of the block holds a sample.
    pub(crate) tiles: u16,
    /// Lowest bits that no inverse depth of the store has.
    pub(crate) depth_shift: u32,
    /// Colors of the palette.
    pub(crate) colors: usize,
    /// Whether samples have normals.
    pub(crate) normals: bool,
}

/// Codes, decodes or counts the numbers of a block.
pub(crate) trait Coder {
    /// Whether numbers are predicted; without, they come as they are.
    const PREDICTS: bool = true;

    /// Codes whether a pixel holds a sample, or ignores `value` and decodes it. `stream` is that of the entropy coder.
    fn has_sample(&mut self, stream: usize, context: usize, value: bool) -> bool;

    /// Codes `value`, or ignores it and decodes one.
    fn code(&mut self, plane: CodedPlane, context: usize, value: u32) -> u32;
}

/// A pixel that holds a sample.
#[derive(Clone, Copy, Default)]
struct SamplePixel {
    at: u16,
    near: Neighbors,
}

/// One of the numbers of a sample, and the plane that it is coded in.
#[derive(Clone, Copy)]
struct CodedNumber {
    number: usize,
    plane: CodedPlane,
}

impl CodedNumber {
    const GREEN: Self = Self { number: 1, plane: CodedPlane::Green };
    const RED: Self = Self { number: 2, plane: CodedPlane::Red };
    const BLUE: Self = Self { number: 3, plane: CodedPlane::Blue };
    const NORMAL_X: Self = Self { number: 4, plane: CodedPlane::NormalX };
    const NORMAL_Y: Self = Self { number: 5, plane: CodedPlane::NormalY };
}

/// Working memory of traversing a block, reused from block to block.
pub(crate) struct BlockTraversal {
    /// Zigzag residuals of each number, by [`cell`].
    residuals: Box<[PerPixel<u32>; NUMBERS]>,
    /// 1 where the depth equalled the reference's, by [`cell`].
    as_before: Box<PerPixel<u8>>,
    /// Pixels that hold a sample, in order.
    held: Box<[SamplePixel; BLOCK * BLOCK]>,
}

impl Default for BlockTraversal {
    /// Ready for any block.
    #[expect(clippy::large_stack_arrays, reason = "once a thread, on its way to the heap")]
    fn default() -> Self {
        Self {
            residuals: Box::new([[0; CELLS]; NUMBERS]),
            as_before: Box::new([0; CELLS]),
            held: Box::new([SamplePixel::default(); BLOCK * BLOCK]),
        }
    }
}

impl BlockTraversal {
    /// Hands every number of `pixels` to `coder` and takes what it gives back.
    #[inline(always)]
    pub(crate) fn traverse<C: Coder>(
        &mut self,
        coder: &mut C,
        shape: &BlockShape,
        pixels: &mut BlockPixels,
        reference: Option<&BlockPixels>,
    ) {
        let count = self.mask(coder, shape, &mut pixels.rows, reference.map(|reference| &reference.rows));
        for nth in 0..count.min(BLOCK * BLOCK) {
            let SamplePixel { at, near } = self.held[nth];
            let at = usize::from(at);
            let before = reference.filter(|_| near.has(R));
            // Compiled twice: within a surface all neighbors are there, and no checks are needed.
            if near.has(AROUND) && before.is_none() {
                self.sample(
                    coder,
                    shape,
                    &mut pixels.values,
                    CodingContext { at, near: Neighbors(AROUND), before: None },
                );
            } else {
                self.sample(coder, shape, &mut pixels.values, CodingContext { at, near, before });
            }
        }
    }

    /// Which pixels hold a sample; gives how many.
    #[inline(always)]
    fn mask<C: Coder>(
        &mut self,
        coder: &mut C,
        shape: &BlockShape,
        rows: &mut [u64; BLOCK],
        reference: Option<&[u64; BLOCK]>,
    ) -> usize {
        let mut count = 0;
        for y in 0..shape.height.min(BLOCK) {
            let above = |by: usize| y.checked_sub(by).map_or(0, |y| rows[y]);
            let (north, north_2) = (above(1), above(2));
            let (here, below) =
                reference.map_or((0, 0), |rows| (rows[y], rows.get(y + 1).copied().unwrap_or(0)));
            let always = u32::from(reference.is_some()) << 9;
            let (known, mut row) = (rows[y], 0_u64);
            for left in (0..shape.width).step_by(8) {
                if shape.tiles >> (y / 16 * 4 + left / 16) & 1 == 0 {
                    continue;
                }
                // What the contexts of eight pixels have of other rows, a byte each.
                let mut others = (eight(north >> left) * u64::from(N))
                    | (eight(north << 1 >> left) * u64::from(NW))
                    | (eight(north >> 1 >> left) * u64::from(NE))
                    | (eight(north_2 >> left) * u64::from(NN))
                    | (eight(here >> left) * u64::from(R))
                    | eight(here >> 1 >> left) << 7;
                let mut below = below >> left;
                // W and WW.
                let mut west = (row << 2 >> left) as u32;
                for x in left..shape.width.min(left + 8) {
                    let context = (others & 0xFF) as u32
                        | ((west >> 1 & 1) * u32::from(W))
                        | ((west & 1) * u32::from(WW))
                        | (below as u32 & 1) << 8
                        | always;
                    let held = coder.has_sample(x % STREAMS, context as usize, known >> x & 1 == 1);
                    (others, below) = (others >> 8, below >> 1);
                    west = west >> 1 | u32::from(held) << 1;
                    row |= u64::from(held) << x;
                    // Written in any case and counted if it is one: no branch.
                    self.held[count % (BLOCK * BLOCK)] =
                        SamplePixel { at: cell(x, y) as u16, near: Neighbors(context as u8 & (AROUND | R)) };
                    count += usize::from(held);
                }
            }
            rows[y] = row;
        }
        count
    }

    #[inline(always)]
    fn sample<C: Coder>(
        &mut self,
        coder: &mut C,
        shape: &BlockShape,
        values: &mut [PerPixel<i32>; NUMBERS],
        place: CodingContext<'_>,
    ) {
        // True of every pixel's cell; the check spares those of the accesses below.
        if !(cell(0, 0)..CELLS).contains(&place.at) {
            return;
        }
        self.depth(coder, shape.depth_shift, &mut values[0], place);
        let green = self.channel(coder, CodedNumber::GREEN, shape.colors, 0, values, place);
        self.channel(coder, CodedNumber::RED, shape.colors, green, values, place);
        self.channel(coder, CodedNumber::BLUE, shape.colors, green, values, place);
        if shape.normals {
            self.coordinate(coder, CodedNumber::NORMAL_X, values, place);
            self.coordinate(coder, CodedNumber::NORMAL_Y, values, place);
        }
    }

    #[inline(always)]
    fn depth<C: Coder>(
        &mut self,
        coder: &mut C,
        shift: u32,
        depths: &mut PerPixel<i32>,
        place: CodingContext<'_>,
    ) {
        let CodingContext { at, near, before } = place;
        let before = before.map(|before| before.values[0][at]);
        let (prediction, kind) = match before {
            None => plane_prediction(depths, shift, place),
            Some(before) => {
                let rests = |back: usize, pixel| u32::from(self.as_before[at - back]) & near.count(pixel);
                let resting = rests(1, W) + rests(STRIDE, N);
                if near.0 & (W | N) == 0 || resting > 0 {
                    (before, 4 + resting as usize)
                } else {
                    let (spatial, kind) = plane_prediction(depths, shift, place);
                    (spatial, 7 + kind)
                }
            }
        };
        let context = kind * ACTIVITIES + activity(&self.residuals[0], place);
        code_number(
            coder,
            CodedPlane::Depth,
            context,
            prediction,
            &mut depths[at],
            &mut self.residuals[0][at],
        );
        self.as_before[at] = u8::from(before == Some(depths[at]));
    }

    /// Codes a color, given by what green was mispredicted; gives by what this one was.
    #[inline(always)]
    fn channel<C: Coder>(
        &mut self,
        coder: &mut C,
        coded: CodedNumber,
        colors: usize,
        green: i32,
        values: &mut [PerPixel<i32>; NUMBERS],
        place: CodingContext<'_>,
    ) -> i32 {
        let CodedNumber { number, plane } = coded;
        let CodingContext { at, near, before } = place;
        let channel = &mut values[number];
        let kind = if near.has(W | N) {
            0
        } else if near.first(at).is_some() {
            1
        } else {
            2
        };
        let (prediction, kind) = match before {
            Some(before) => (before.values[number][at], kind + 3),
            None => (median_prediction(channel, place, colors), kind),
        };
        let mut context = kind * ACTIVITIES + activity(&self.residuals[number], place);
        if number > 1 {
            context = context * 8 + bit_length(zigzag(green)).min(14) / 2;
        }
        let residual = &mut self.residuals[number][at];
        code_number(coder, plane, context, prediction.wrapping_add(green), &mut channel[at], residual);
        unzigzag(*residual)
    }

    #[inline(always)]
    fn coordinate<C: Coder>(
        &mut self,
        coder: &mut C,
        coded: CodedNumber,
        values: &mut [PerPixel<i32>; NUMBERS],
        place: CodingContext<'_>,
    ) {
        let CodedNumber { number, plane } = coded;
        let CodingContext { at, near, before } = place;
        let axis = &mut values[number];
        let (prediction, kind) = match (before, near.first(at)) {
            (Some(before), _) => (before.values[number][at], 2),
            (None, Some(neighbor)) => (axis[neighbor % CELLS], 1),
            (None, None) => (0, 0),
        };
        let context = kind * ACTIVITIES + activity(&self.residuals[number], place);
        code_number(coder, plane, context, prediction, &mut axis[at], &mut self.residuals[number][at]);
    }
}

/// The lowest eight bits, one in each byte.
#[inline(always)]
fn eight(bits: u64) -> u64 {
    let apart = ((bits & 0xFF) * 0x0101_0101_0101_0101) & 0x8040_2010_0804_0201;
    (apart + 0x7F7F_7F7F_7F7F_7F7F) >> 7 & 0x0101_0101_0101_0101
}

#[inline(always)]
fn code_number<C: Coder>(
    coder: &mut C,
    plane: CodedPlane,
    context: usize,
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
