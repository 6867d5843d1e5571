//! The traversal of a block's scalar values that counting, encoding and decoding share: what each value is predicted from, and in which
//! context its residual is coded.
//!
//! Values are whole numbers here: the bits of floats, put into the order of the floats, or multiples of a step. A triangle whose corners
//! have values shows them so that value × inverse depth is a plane in the picture, which is one of the predictions to choose from;
//! indices and labels are those of a neighbor. What is known of the reference is used as for depth.

use super::integers::{unzigzag, zigzag};
use super::model::ACTIVITIES;
use super::neighborhood::{
    BLOCK, CELLS, CodingContext, N, NE, NW, Neighbors, PerPixel, STRIDE, W, activity, cell,
};
use super::rans::TOKENS;

/// Contexts of a channel.
pub(crate) const VALUE_CONTEXTS: usize = 9 * ACTIVITIES;

/// Tokens of a channel.
pub(crate) const VALUE_TOKENS: usize = TOKENS;

/// What the values of a channel are predicted by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ValuePredictor {
    /// The first neighbor.
    Neighbor,
    /// The plane through neighbors.
    Plane,
    /// The same of value × inverse depth.
    PlaneInPicture,
    /// The surface of second order through neighbors.
    Curved,
    /// The same of value × inverse depth.
    CurvedInPicture,
}

impl ValuePredictor {
    /// All of them; their places are their numbers in the store.
    pub(crate) const ALL: [Self; 5] =
        [Self::Neighbor, Self::Plane, Self::PlaneInPicture, Self::Curved, Self::CurvedInPicture];

    /// Whether values count times inverse depth.
    fn is_in_picture(self) -> bool {
        matches!(self, Self::PlaneInPicture | Self::CurvedInPicture)
    }

    /// The sums that are tried, the better ones first; the median of the first list that has any counts.
    fn sums(self) -> &'static [[Sum; 4]] {
        match self {
            Self::Neighbor => &[],
            Self::Plane | Self::PlaneInPicture => &[PLANES],
            Self::Curved | Self::CurvedInPicture => &[CURVES, PLANES],
        }
    }
}

/// Pixels to the left (to the right where negative) and up of one, and by what their values are multiplied.
type Sum = &'static [(isize, usize, f64)];

const PLANES: [Sum; 4] = [
    &[(1, 0, 1.0), (0, 1, 1.0), (1, 1, -1.0)],
    &[(1, 0, 2.0), (2, 0, -1.0)],
    &[(0, 1, 2.0), (0, 2, -1.0)],
    &[(1, 0, 1.0), (-1, 1, 1.0), (0, 1, -1.0)],
];

const CURVES: [Sum; 4] = [
    &[(1, 0, 3.0), (2, 0, -3.0), (3, 0, 1.0)],
    &[(0, 1, 3.0), (0, 2, -3.0), (0, 3, 1.0)],
    &[(1, 0, 1.0), (0, 1, 2.0), (1, 1, -2.0), (0, 2, -1.0), (1, 2, 1.0)],
    &[(0, 1, 1.0), (1, 0, 2.0), (1, 1, -2.0), (2, 0, -1.0), (2, 1, 1.0)],
];

/// How values become whole numbers: exactly, or as multiples of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ValueScale {
    /// 0 for exactly.
    pub(crate) step: f32,
}

/// The bits of a float in the order of the floats, and back.
fn ordered(bits: i32) -> i32 {
    bits ^ (((bits >> 31) as u32 >> 1) as i32)
}

/// No value, among multiples of a step.
const NO_MULTIPLE: i32 = i32::MAX;

impl ValueScale {
    /// The number of a value.
    pub(crate) fn code(self, value: f32) -> i32 {
        if self.step == 0.0 {
            ordered(value.to_bits() as i32)
        } else if value.is_nan() {
            NO_MULTIPLE
        } else {
            self.nearest(f64::from(value))
        }
    }

    /// The value of a number.
    pub(crate) fn value(self, code: i32) -> f32 {
        if self.step == 0.0 {
            f32::from_bits(ordered(code) as u32)
        } else if code == NO_MULTIPLE {
            f32::NAN
        } else {
            (f64::from(code) * f64::from(self.step)) as f32
        }
    }

    /// The number of the value nearest to a prediction, which is finite.
    fn nearest(self, value: f64) -> i32 {
        if self.step == 0.0 {
            ordered((value as f32).to_bits() as i32)
        } else {
            (value / f64::from(self.step)).round() as i32
        }
    }
}

/// How a channel is coded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ChannelCoding {
    pub(crate) scale: ValueScale,
    pub(crate) predictor: ValuePredictor,
    /// What is predicted where nothing is known.
    pub(crate) start: f32,
}

/// Codes, decodes or counts the numbers of a channel.
pub(crate) trait ValueCoder {
    /// Codes `value`, or ignores it and decodes one.
    fn code(&mut self, channel: usize, context: usize, value: u32) -> u32;
}

/// The values of a block, by [`cell`]. Only those of samples mean something.
pub(crate) struct ValuePixels {
    /// Per row, bit `x`: whether there is a sample in column `x`.
    pub(crate) rows: [u64; BLOCK],
    /// Inverse depths.
    pub(crate) inverse_depths: Vec<f32>,
    /// Channel by channel, as [`ValueScale::code`] gives them.
    pub(crate) codes: Vec<Vec<i32>>,
}

impl ValuePixels {
    /// A block without samples.
    pub(crate) fn new(channels: usize) -> Self {
        Self {
            rows: [0; BLOCK],
            inverse_depths: vec![0.0; CELLS],
            codes: (0..channels).map(|_| vec![0; CELLS]).collect(),
        }
    }

    /// Whether the pixel so far to the left and up of one holds a sample.
    fn has(&self, (x, y): (usize, usize), left: isize, up: usize) -> bool {
        let row = y.checked_sub(up).map_or(0, |y| self.rows[y]);
        x.checked_add_signed(-left).is_some_and(|x| x < BLOCK && row >> x & 1 == 1)
    }

    /// Which pixels around one hold a sample.
    fn near(&self, place: (usize, usize)) -> Neighbors {
        let around = [(W, 1, 0), (N, 0, 1), (NW, 1, 1), (NE, -1, 1)];
        let there = around.into_iter().filter(|(_, left, up)| self.has(place, *left, *up));
        Neighbors(there.fold(0, |near, (pixel, ..)| near | pixel))
    }
}

#[expect(clippy::large_stack_arrays, reason = "on its way to the heap")]
fn no_residuals() -> Box<PerPixel<u32>> {
    Box::new([0; CELLS])
}

/// Hands every value of `pixels` to `coder` and takes what it gives back, channel by channel.
pub(crate) fn traverse_values(
    coder: &mut impl ValueCoder,
    channels: &[ChannelCoding],
    pixels: &mut ValuePixels,
    reference: Option<&ValuePixels>,
) {
    for (channel, coding) in channels.iter().enumerate() {
        let mut residuals = no_residuals();
        let mut as_before = vec![false; CELLS];
        for y in 0..BLOCK {
            let mut columns = pixels.rows[y];
            while columns != 0 {
                let x = columns.trailing_zeros() as usize;
                columns &= columns - 1;
                let (at, near) = (cell(x, y), pixels.near((x, y)));
                let before = reference
                    .filter(|reference| reference.rows[y] >> x & 1 == 1)
                    .map(|reference| reference.codes[channel][at]);
                let (prediction, kind) = predict(coding, channel, pixels, ((x, y), near), before, &as_before);
                let place = CodingContext { at, near, before: None };
                let context = kind * ACTIVITIES + activity(&residuals, place);
                let own = &mut pixels.codes[channel][at];
                residuals[at] = coder.code(channel, context, zigzag(own.wrapping_sub(prediction)));
                *own = prediction.wrapping_add(unzigzag(residuals[at]));
                as_before[at] = before == Some(*own);
            }
        }
    }
}

/// The number that is expected at a pixel, and what it was concluded from.
fn predict(
    coding: &ChannelCoding,
    channel: usize,
    pixels: &ValuePixels,
    ((x, y), near): ((usize, usize), Neighbors),
    before: Option<i32>,
    as_before: &[bool],
) -> (i32, usize) {
    let Some(before) = before else { return spatial(coding, channel, pixels, (x, y), near) };
    let at = cell(x, y);
    let rests = |back: usize, pixel: u8| usize::from(as_before[at - back] && near.has(pixel));
    let resting = rests(1, W) + rests(STRIDE, N);
    if near.0 & (W | N) == 0 || resting > 0 {
        return (before, 3 + resting);
    }
    let (prediction, kind) = spatial(coding, channel, pixels, (x, y), near);
    (prediction, 6 + kind)
}

/// The number that the pixels around let expect: 2 a sum, 1 a neighbor, 0 nothing.
fn spatial(
    coding: &ChannelCoding,
    channel: usize,
    pixels: &ValuePixels,
    place: (usize, usize),
    near: Neighbors,
) -> (i32, usize) {
    let (codes, at) = (&pixels.codes[channel], cell(place.0, place.1));
    let Some(first) = near.first(at).map(|first| codes[first]) else {
        return (coding.scale.code(coding.start), 0);
    };
    if coding.scale.value(first).is_nan() {
        return (first, 1);
    }
    let own_weight = f64::from(pixels.inverse_depths[at]);
    let in_picture = coding.predictor.is_in_picture() && own_weight > 0.0;
    let of_term = |&(left, up, factor): &(isize, usize, f64)| {
        let there = at.wrapping_add_signed(-left) - up * STRIDE;
        let weight = if in_picture { f64::from(pixels.inverse_depths[there]) } else { 1.0 };
        factor * (f64::from(coding.scale.value(codes[there])) * weight)
    };
    for sums in coding.predictor.sums() {
        let mut known = [f64::INFINITY; 4];
        let mut count = 0;
        for sum in sums {
            if sum.iter().all(|(left, up, _)| pixels.has(place, *left, *up)) {
                let sum = sum.iter().map(of_term).fold(0.0, |sum, term| sum + term);
                if sum.is_finite() {
                    known[count] = sum;
                    count += 1;
                }
            }
        }
        if count > 0 {
            known.sort_unstable_by(f64::total_cmp);
            let median = (known[(count - 1) / 2] + known[count / 2]) * 0.5;
            return (coding.scale.nearest(median / if in_picture { own_weight } else { 1.0 }), 2);
        }
    }
    (first, 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_exact_values_are_in_their_order_and_give_the_same_bits_back() {
        let exact = ValueScale { step: 0.0 };
        let values = [f32::NEG_INFINITY, -2.0, -1e-40, -0.0, 0.0, 1e-40, 2.0, f32::INFINITY, f32::NAN];
        let codes = values.map(|value| exact.code(value));
        assert!(codes.is_sorted_by(|a, b| a < b));
        assert_eq!(codes.map(|code| exact.value(code).to_bits()), values.map(f32::to_bits));
    }

    #[test]
    fn multiples_of_a_step_are_at_most_half_of_it_away_and_stay_when_they_are_rounded_again() {
        let bounded = ValueScale { step: 0.1 };
        for value in [0.0, 0.04, -12.37, 1e6, 5.05] {
            let rounded = bounded.value(bounded.code(value));
            assert!((rounded - value).abs() <= 0.050_001 + value.abs() * 1e-7, "{value} {rounded}");
            assert_eq!(bounded.value(bounded.code(rounded)).to_bits(), rounded.to_bits());
        }
        assert!(bounded.value(bounded.code(f32::NAN)).is_nan());
    }
}
