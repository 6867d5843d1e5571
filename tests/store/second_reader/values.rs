//! The scalar values of FORMAT.md, sentence by sentence.

use std::collections::BTreeMap;

use super::reader::{Bits, Bytes, Model, Numbers, signed, tables};

const CONTEXTS: usize = 153;

struct Channel {
    step: f32,
    start: f32,
    predictor: u64,
}

/// A `VALU` chunk.
pub(crate) struct ValueTable {
    channels: Vec<Channel>,
    is_plain: bool,
    model: Model,
    /// By image, the place of its `VALI` chunk and the bytes of its payload.
    places: Vec<(usize, usize)>,
}

/// The numbers of a block's values by pixel, one a channel.
pub(crate) type ValueBlock = BTreeMap<(i64, i64), Vec<i32>>;

/// A sum of pixels: how far each is to the left and up, and its factor.
type Sum = &'static [(i64, i64, f64)];

const PLANES: [Sum; 4] = [
    &[(1, 0, 1.0), (0, 1, 1.0), (1, 1, -1.0)],
    &[(1, 0, 2.0), (2, 0, -1.0)],
    &[(0, 1, 2.0), (0, 2, -1.0)],
    &[(1, 0, 1.0), (-1, 1, 1.0), (0, 1, -1.0)],
];
const CURVES: [Sum; 4] = [
    &[(1, 0, 3.0), (2, 0, -3.0), (3, 0, 1.0)],
    &[(1, 0, 1.0), (0, 1, 2.0), (1, 1, -2.0), (0, 2, -1.0), (1, 2, 1.0)],
    &[(0, 1, 3.0), (0, 2, -3.0), (0, 3, 1.0)],
    &[(0, 1, 1.0), (1, 0, 2.0), (1, 1, -2.0), (2, 0, -1.0), (2, 1, 1.0)],
];

impl Channel {
    fn number(&self, value: f64) -> i32 {
        match self.step {
            0.0 => {
                let bits = (value as f32).to_bits();
                (if bits >> 31 == 0 { bits } else { 1 << 31 | (!bits & 0x7FFF_FFFF) }) as i32
            }
            step => (value / f64::from(step)).round() as i32,
        }
    }

    fn value(&self, number: i32) -> f32 {
        let bits = number as u32;
        match self.step {
            0.0 => f32::from_bits(if bits >> 31 == 0 { bits } else { 1 << 31 | (!bits & 0x7FFF_FFFF) }),
            _ if number == i32::MAX => f32::NAN,
            step => (f64::from(number) * f64::from(step)) as f32,
        }
    }
}

impl ValueTable {
    pub(crate) fn read(payload: &[u8], images: usize) -> Self {
        let mut bytes = Bytes(payload);
        let (count, flags) = (bytes.number(1), bytes.number(1));
        let number = |bytes: &mut Bytes<'_>| f32::from_bits(bytes.number(4) as u32);
        let channels: Vec<Channel> = (0..count)
            .map(|_| {
                bytes.text();
                bytes.text();
                bytes.take(12);
                let (step, start) = (number(&mut bytes), number(&mut bytes));
                let predictor = bytes.number(1);
                bytes.take(9);
                Channel { step, start, predictor }
            })
            .collect();
        let model = (0..count).map(|_| tables(&mut bytes, CONTEXTS)).collect();
        let places = (0..images).map(|_| (bytes.number(8) as usize, bytes.number(4) as usize)).collect();
        assert!(bytes.0.is_empty());
        Self { channels, is_plain: flags & 1 == 1, model, places }
    }

    /// The blocks of an image, given the inverse depths of each, and the blocks of its reference, by their places.
    pub(crate) fn image(
        &self,
        file: &[u8],
        image: usize,
        depths: &BTreeMap<usize, BTreeMap<(i64, i64), f32>>,
        reference: Option<&BTreeMap<usize, ValueBlock>>,
    ) -> BTreeMap<usize, ValueBlock> {
        let (offset, length) = self.places[image];
        assert_eq!(&file[offset..offset + 4], b"VALI");
        let mut bytes = Bytes(&file[offset + 8..offset + 8 + length]);
        let heads: Vec<_> = depths.keys().map(|_| (bytes.varint(), bytes.number(4) as u32)).collect();
        let blocks = depths.iter().zip(heads).map(|((place, depths), (length, checksum))| {
            let code = bytes.take(length);
            assert_eq!(crc32fast::hash(code), checksum);
            (*place, self.block(code, depths, reference.and_then(|reference| reference.get(place))))
        });
        let blocks = blocks.collect();
        assert!(bytes.0.is_empty());
        blocks
    }

    fn block(
        &self,
        code: &[u8],
        depths: &BTreeMap<(i64, i64), f32>,
        reference: Option<&ValueBlock>,
    ) -> ValueBlock {
        let mut held: Vec<(i64, i64)> = depths.keys().copied().collect();
        held.sort_by_key(|(x, y)| (*y, *x));
        let mut block: ValueBlock = held.iter().map(|pixel| (*pixel, Vec::new())).collect();
        let mut bytes = Bytes(code);
        if self.is_plain {
            for _ in &self.channels {
                for pixel in &held {
                    block.get_mut(pixel).unwrap().push(bytes.number(4) as u32 as i32);
                }
            }
            assert!(bytes.0.is_empty());
            return block;
        }
        let count = bytes.varint();
        let mut words = Bytes(bytes.take(2 * count));
        let states = [words.number(4) as u32, 0, 0, 0];
        let bits = Bits { bytes: bytes.0, position: 0 };
        let mut numbers = Numbers { model: &self.model, states, words, bits };
        for nth in 0..self.channels.len() {
            let mut coded = BTreeMap::<(i64, i64), u32>::new();
            for &(x, y) in &held {
                let (mut sum, mut weights) = (0, 0);
                for (dx, dy, weight) in [(-1, 0, 2), (0, -1, 2), (-1, -1, 1), (1, -1, 1)] {
                    if let Some(residual) = coded.get(&(x + dx, y + dy)) {
                        sum += weight * u64::from(*residual);
                        weights += weight;
                    }
                }
                let activity =
                    (4 * sum).checked_div(weights).map_or(16, |a| 15.min(64 - a.leading_zeros() as usize));
                let (prediction, kind) = self.predicted(nth, (x, y), &block, depths, reference);
                let residual = numbers.take(0, nth, 17 * kind + activity);
                coded.insert((x, y), residual);
                block.get_mut(&(x, y)).unwrap().push(prediction.wrapping_add(signed(residual)));
            }
        }
        assert!(numbers.words.0.is_empty() && numbers.states == [1 << 16, 0, 0, 0]);
        assert_eq!(numbers.bits.position.div_ceil(8), numbers.bits.bytes.len());
        block
    }

    fn predicted(
        &self,
        nth: usize,
        (x, y): (i64, i64),
        block: &ValueBlock,
        depths: &BTreeMap<(i64, i64), f32>,
        reference: Option<&ValueBlock>,
    ) -> (i32, usize) {
        let channel = &self.channels[nth];
        let at = |left: i64, up: i64| block.get(&(x - left, y - up)).map(|numbers| numbers[nth]);
        let first = at(1, 0).or(at(0, 1)).or(at(1, 1)).or(at(-1, 1));
        let spatial = || {
            let Some(first) = first else { return (channel.number(f64::from(channel.start)), 0) };
            if channel.value(first).is_nan() {
                return (first, 1);
            }
            let lists: &[[Sum; 4]] = match channel.predictor {
                0 => &[],
                1 | 2 => &[PLANES],
                _ => &[CURVES, PLANES],
            };
            let own = f64::from(depths[&(x, y)]);
            let is_weighted = matches!(channel.predictor, 2 | 4) && own != 0.0;
            let weight = |left: i64, up: i64| {
                if is_weighted { f64::from(depths[&(x - left, y - up)]) } else { 1.0 }
            };
            for list in lists {
                let sum = |sum: &Sum| {
                    sum.iter().try_fold(0.0, |total, (left, up, factor)| {
                        let value = f64::from(channel.value(at(*left, *up)?));
                        Some(total + factor * (value * weight(*left, *up)))
                    })
                };
                let mut sums: Vec<f64> = list.iter().filter_map(sum).filter(|sum| sum.is_finite()).collect();
                sums.sort_by(f64::total_cmp);
                if let Some(last) = sums.len().checked_sub(1) {
                    let median = f64::midpoint(sums[last / 2], sums[sums.len() / 2]);
                    return (channel.number(median / if is_weighted { own } else { 1.0 }), 2);
                }
            }
            (first, 1)
        };
        let before = |left: i64, up: i64| {
            reference.and_then(|reference| reference.get(&(x - left, y - up))).map(|numbers| numbers[nth])
        };
        let same = |left, up| usize::from(at(left, up).is_some() && at(left, up) == before(left, up));
        let resting = same(1, 0) + same(0, 1);
        match before(0, 0) {
            Some(before) if resting > 0 || (at(1, 0).is_none() && at(0, 1).is_none()) => {
                (before, 3 + resting)
            }
            Some(_) => (spatial().0, spatial().1 + 6),
            None => spatial(),
        }
    }

    /// The values of numbers, channel by channel.
    pub(crate) fn values(&self, numbers: &[i32]) -> Vec<f32> {
        self.channels.iter().zip(numbers).map(|(channel, number)| channel.value(*number)).collect()
    }
}
