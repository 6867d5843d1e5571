//! The halves that the colors of a store are made of, numbered from the darkest.
//!
//! Colors are coded by their rank in this list. Lossless, it is every half between the extremes, or, where a capture was
//! recorded with fewer (as from 8-bit pictures), just those that occur. With a precision it is a coarser list: every half that
//! occurs is within half a display step of one in it.

use half::f16;

use crate::color::steps_from_linear;
use crate::samples::SampleImage;
use crate::store::container::{ByteReader, push_varint};

/// Halves are counted from the most negative: their bits in ascending order.
const CODES: usize = 1 << 16;

/// The place of a half among all halves, ascending. −0 comes just before 0.
#[inline(always)]
fn code_of(half: f16) -> u16 {
    let bits = half.to_bits();
    if bits & 0x8000 == 0 { bits | 0x8000 } else { !bits }
}

#[inline(always)]
fn half_of(code: u16) -> f16 {
    f16::from_bits(if code & 0x8000 == 0 { !code } else { code & 0x7FFF })
}

/// The 8-bit display steps of the half with a code.
fn steps_of(code: u16) -> f32 {
    steps_from_linear(half_of(code))
}

/// Which halves occur in some images, by [`code_of`].
pub(crate) struct UsedColors(Vec<bool>);

impl UsedColors {
    pub(crate) fn new() -> Self {
        Self(vec![false; CODES])
    }

    pub(crate) fn add(&mut self, image: &SampleImage) {
        for channel in image.color.iter().flatten() {
            self.0[code_of(*channel) as usize] = true;
        }
    }

    pub(crate) fn plus(mut self, other: &Self) -> Self {
        self.0.iter_mut().zip(&other.0).for_each(|(used, more)| *used |= more);
        self
    }

    fn codes(&self) -> impl DoubleEndedIterator<Item = u16> {
        (0..=u16::MAX).filter(|code| self.0[*code as usize])
    }
}

/// The list, and the rank of every half that is in it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ColorRanks {
    /// Codes, ascending.
    codes: Vec<u16>,
    /// The halves of these codes.
    halves: Vec<f16>,
    /// Rank of the entry that represents a code, from the first entry's code to the last's.
    ranks: Vec<u16>,
}

impl ColorRanks {
    /// In which every half that is used is found as it is.
    fn lossless(used: &UsedColors) -> Self {
        let (Some(first), Some(last)) = (used.codes().next(), used.codes().next_back()) else {
            return Self::of(vec![code_of(f16::ZERO)]);
        };
        let occurring: Vec<u16> = used.codes().collect();
        let between = usize::from(last - first) + 1;
        Self::of(if occurring.len() * 2 < between { occurring } else { (first..=last).collect() })
    }

    /// In which every half that is used has one within `room`, in 8-bit display steps.
    pub(crate) fn within(used: &UsedColors, room: f32) -> Self {
        if room <= 0.0 {
            return Self::lossless(used);
        }
        let mut codes: Vec<u16> = Vec::new();
        let mut covered_to = f32::NEG_INFINITY;
        for code in used.codes() {
            let steps = steps_of(code);
            if steps <= covered_to && codes.last().is_some_and(|last| steps - steps_of(*last) <= room) {
                continue;
            }
            // The brightest half within reach represents most of the halves that follow.
            let beyond = (code..=code_of(f16::MAX)).find(|code| steps_of(*code) - steps > room);
            let entry = beyond.map_or(code_of(f16::MAX), |beyond| beyond - 1).max(code);
            covered_to = steps_of(entry) + room;
            codes.push(entry);
        }
        if codes.is_empty() { Self::lossless(used) } else { Self::of(codes) }
    }

    /// From codes in ascending order, at least one.
    fn of(codes: Vec<u16>) -> Self {
        let mut ranks = Vec::new();
        for (rank, pair) in codes.windows(2).enumerate() {
            let (below, above) = (pair[0], pair[1]);
            ranks.push(rank as u16);
            // What is between belongs to the nearer of the two, in display steps.
            ranks.extend((below + 1..above).map(|code| {
                let nearer_above = steps_of(above) - steps_of(code) < steps_of(code) - steps_of(below);
                rank as u16 + u16::from(nearer_above)
            }));
        }
        ranks.push((codes.len() - 1) as u16);
        let halves = codes.iter().map(|code| half_of(*code)).collect();
        Self { codes, halves, ranks }
    }

    /// Colors in the list.
    pub(crate) fn len(&self) -> usize {
        self.codes.len()
    }

    /// The rank of the color that represents `half`.
    #[inline(always)]
    pub(crate) fn rank(&self, half: f16) -> i32 {
        let place = code_of(half).saturating_sub(self.codes[0]) as usize;
        i32::from(self.ranks[place.min(self.ranks.len() - 1)])
    }

    /// The color of a rank, or `None` if there is no such rank.
    #[inline(always)]
    pub(crate) fn color(&self, rank: i32) -> Option<f16> {
        self.halves.get(usize::try_from(rank).ok()?).copied()
    }

    /// As FORMAT.md describes `PALT`: runs of neighboring halves.
    pub(crate) fn encode(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut next = 0_u32;
        let mut start = 0;
        while start < self.codes.len() {
            let first = self.codes[start];
            let run = (start..self.codes.len())
                .take_while(|at| usize::from(self.codes[*at] - first) == at - start)
                .count();
            push_varint(&mut bytes, u64::from(u32::from(first) - next));
            push_varint(&mut bytes, run as u64);
            next = u32::from(first) + run as u32;
            start += run;
        }
        bytes
    }

    /// Reads what [`ColorRanks::encode`] wrote.
    pub(crate) fn decode(bytes: &[u8]) -> Result<Self, String> {
        let mut reader = ByteReader::new(bytes);
        let mut codes = Vec::new();
        let mut next = 0_u64;
        while !reader.rest.is_empty() {
            let (gap, run) = (reader.varint()?, reader.varint()?);
            let first = next.saturating_add(gap);
            next = first.saturating_add(run);
            if run == 0 || next > CODES as u64 {
                return Err("a run of colors that do not exist".to_owned());
            }
            codes.extend((first..next).map(|code| code as u16));
        }
        if codes.is_empty() || codes.iter().any(|code| !half_of(*code).is_finite()) {
            return Err("a color is not finite, or no color is listed".to_owned());
        }
        Ok(Self::of(codes))
    }
}

/// Half a step of a display of `bits` bits, in 8-bit steps.
pub(crate) fn half_step(bits: u32) -> f32 {
    127.5 / ((1_u32 << bits) - 1) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn used(halves: impl IntoIterator<Item = f32>) -> UsedColors {
        let mut used = UsedColors::new();
        halves.into_iter().for_each(|half| used.0[code_of(f16::from_f32(half)) as usize] = true);
        used
    }

    #[test]
    fn codes_ascend_with_the_halves_and_come_back() {
        let halves: Vec<f16> = (0..=u16::MAX).map(half_of).filter(|half| half.is_finite()).collect();
        assert!(halves.is_sorted_by(|a, b| a <= b));
        assert!(halves.iter().all(|half| half_of(code_of(*half)) == *half));
        assert_eq!(half_of(code_of(f16::NEG_ZERO)).to_bits(), 0x8000);
    }

    #[test]
    fn a_lossless_palette_has_every_color_that_occurs_and_few_others() {
        let colors = [-0.5, 0.0, 0.1, 0.75, 12.0];
        let palette = ColorRanks::lossless(&used(colors));
        assert_eq!(palette.len(), 5);
        for color in colors.map(f16::from_f32) {
            assert_eq!(palette.color(palette.rank(color)), Some(color));
        }
        assert_eq!(palette.color(5), None);
        assert_eq!(palette.color(-1), None);
        // Every half from 0 to 1 follows the one before it, so that two numbers describe them all.
        let dense = ColorRanks::lossless(&used((0..=0x3C00).map(|bits| f16::from_bits(bits).to_f32())));
        assert!(dense.encode().len() < 12);
        assert_eq!(ColorRanks::decode(&dense.encode()).unwrap(), dense);
        assert_eq!(ColorRanks::decode(&palette.encode()).unwrap(), palette);
    }

    #[test]
    fn a_coarse_palette_keeps_within_half_a_step() {
        let steps = steps_from_linear;
        for bits in [8, 10, 12, 16] {
            let halves = || (0..31_000_u16).map(f16::from_bits).chain([f16::from_f32(-2.0)]);
            let palette = ColorRanks::within(&used(halves().map(f16::to_f32)), half_step(bits));
            for half in halves() {
                let shown = palette.color(palette.rank(half)).unwrap();
                assert!((steps(shown) - steps(half)).abs() <= half_step(bits), "{half} as {shown}");
            }
            assert_eq!(ColorRanks::decode(&palette.encode()).unwrap(), palette);
        }
        let displayed = ColorRanks::within(&used((0..=1000).map(|i| i as f32 / 1000.0)), half_step(8));
        assert!(displayed.len() <= 256, "{}", displayed.len());
    }

    #[test]
    fn damaged_palettes_are_refused() {
        for bytes in [&[][..], &[0], &[0, 0], &[0, 1], &[0x80], &[0xFF, 0xFF, 0x03, 2], &[0xFF; 20]] {
            assert!(ColorRanks::decode(bytes).is_err(), "{bytes:?}");
        }
    }
}
