//! Integers of any size as a token and a few plain bits.
//!
//! Source: the hybrid integers of ISO/IEC 18181-1 (JPEG XL), 2022, with four direct bits and two after the leading one: the
//! token carries what a frequency table can learn, the plain bits what is noise anyway.
//!
//! ```text
//! zigzag    0, −1, 1, −2, 2 … ─▶ 0, 1, 2, 3, 4 …
//! v < 16    token v, no plain bits
//! v ≥ 16    v = 1 a b [rest: m − 2 bits], m the place of its leading one
//!           token 16 + 4 (m − 4) + 2a + b
//! ```

/// A signed number as an unsigned one, small magnitudes first.
#[inline(always)]
pub(super) fn zigzag(value: i32) -> u32 {
    ((value << 1) ^ (value >> 31)) as u32
}

/// Undoes [`zigzag`].
#[inline(always)]
pub(super) fn unzigzag(value: u32) -> i32 {
    (value >> 1) as i32 ^ -((value & 1) as i32)
}

/// The token of a number, and how many plain bits, its lowest, follow it.
#[inline(always)]
pub(super) fn split(value: u32) -> (usize, u32) {
    if value < 16 {
        return (value as usize, 0);
    }
    let leading = value.ilog2();
    ((16 + (leading - 4) * 4 + (value >> (leading - 2) & 3)) as usize, leading - 2)
}

/// Undoes [`split`]: the number without its plain bits, and how many of them follow.
#[inline(always)]
pub(super) fn join(token: usize) -> (u32, u32) {
    const JOINED: [(u32, u32); 128] = {
        let mut joined = [(0, 0); 128];
        let mut token = 0;
        while token < 128 {
            joined[token as usize] = if token < 16 {
                (token, 0)
            } else {
                let leading = (token - 16) / 4 + 4;
                ((4 | token & 3) << (leading - 2), leading - 2)
            };
            token += 1;
        }
        joined
    };
    JOINED[token & 127]
}

/// Bits one after another, the lowest of a byte first.
#[derive(Default)]
pub(super) struct BitWriter {
    bytes: Vec<u8>,
    pending: u64,
    count: u32,
}

impl BitWriter {
    /// Appends the lowest `bits` (at most 32) of `value`.
    pub(super) fn push(&mut self, value: u32, bits: u32) {
        let kept = u64::from(value) & ((1_u64 << bits) - 1);
        self.pending |= kept << self.count;
        self.count += bits;
        while self.count >= 8 {
            self.bytes.push(self.pending as u8);
            self.pending >>= 8;
            self.count -= 8;
        }
    }

    /// All bytes; the bits left over are 0.
    pub(super) fn finish(mut self) -> Vec<u8> {
        if self.count > 0 {
            self.bytes.push(self.pending as u8);
        }
        self.bytes
    }
}

/// Reads what [`BitWriter`] wrote; beyond the end there are zeros, which [`BitReader::is_whole`] detects.
pub(super) struct BitReader<'a> {
    rest: &'a [u8],
    pending: u64,
    /// Bits pending that count: at most 63.
    count: u32,
    starved: bool,
}

impl<'a> BitReader<'a> {
    /// Over all of `bytes`.
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes, pending: 0, count: 0, starved: false }
    }

    /// The next `bits`, at most 32.
    #[inline(always)]
    pub(super) fn next(&mut self, bits: u32) -> u32 {
        if let Some(eight) = self.rest.first_chunk::<8>() {
            // To at least 56 bits, without a branch on how many are there; what is above `count` already is put there again.
            self.pending |= u64::from_le_bytes(*eight) << self.count;
            self.rest = &self.rest[(63 - self.count as usize) / 8..];
            self.count |= 0b11_1000;
        } else {
            self.fill_last(bits);
        }
        let value = self.pending & ((1_u64 << bits) - 1);
        self.pending >>= bits;
        self.count -= bits;
        value as u32
    }

    /// Takes the last few bytes one by one.
    #[cold]
    #[inline(never)]
    fn fill_last(&mut self, bits: u32) {
        // Bits above `count` have not been counted.
        self.pending &= (1 << self.count) - 1;
        while self.count < 56
            && let Some((&byte, rest)) = self.rest.split_first()
        {
            self.pending |= u64::from(byte) << self.count;
            self.count += 8;
            self.rest = rest;
        }
        if self.count < bits {
            self.starved = true;
            self.count = 63;
        }
    }

    /// Whether everything was read, and nothing beyond it.
    pub(super) fn is_whole(&self) -> bool {
        // Bytes that are left may have been looked at beforehand.
        !self.starved && self.rest.is_empty() && self.count < 8 && self.pending == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::codec::rans::TOKENS;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_integer_comes_back(values in prop::collection::vec((any::<i32>(), 0..32_u32), 0..60)) {
            let values: Vec<i32> = values.into_iter().map(|(value, shift)| value >> shift).collect();
            let mut bits = BitWriter::default();
            let tokens: Vec<usize> = values.iter().map(|&value| {
                let (token, count) = split(zigzag(value));
                bits.push(zigzag(value), count);
                token
            }).collect();
            prop_assert!(tokens.iter().all(|token| *token < TOKENS));
            let bytes = bits.finish();
            let mut bits = BitReader::new(&bytes);
            for (token, value) in tokens.into_iter().zip(values) {
                let (base, count) = join(token);
                prop_assert_eq!(unzigzag(base | bits.next(count)), value);
            }
            prop_assert!(bits.is_whole());
        }
    }

    #[test]
    fn small_magnitudes_have_small_tokens() {
        assert_eq!(
            [0, -1, 1, 7, -8].map(|value| split(zigzag(value))),
            [(0, 0), (1, 0), (2, 0), (14, 0), (15, 0)]
        );
        assert_eq!(split(16), (16, 2));
        assert_eq!(split(u32::MAX), (127, 29));
    }

    #[test]
    fn bits_beyond_the_end_and_bits_left_over_are_noticed() {
        let mut bits = BitReader::new(&[0xFF]);
        assert_eq!(bits.next(12), 0xFF);
        assert!(!bits.is_whole());
        assert!(!BitReader::new(&[0]).is_whole());
        let mut bits = BitReader::new(&[0b110]);
        assert_eq!(bits.next(1), 0);
        assert!(!bits.is_whole());
    }
}
