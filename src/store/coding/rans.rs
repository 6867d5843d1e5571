//! Entropy coding with fixed frequencies: range asymmetric numeral systems.
//!
//! Source: Duda, *Asymmetric numeral systems: entropy coding combining speed of Huffman coding with compression rate of
//! arithmetic coding*, 2013, in the word-wise form of Giesen, *Interleaved entropy coders*, 2014. A state `x` of 32 bits is
//! always at least 2¹⁶; a token of frequency `f` (of 4096) that begins at `b` is coded by
//!
//! ```text
//! encode   while x ≥ f · 2²⁰: put out x mod 2¹⁶, x ← x / 2¹⁶          x ← (x / f) · 4096 + b + x mod f
//! decode   slot = x mod 4096; the token is the one with b ≤ slot < b + f
//!          x ← f · (x / 4096) + slot − b                              while x < 2¹⁶: x ← x · 2¹⁶ + next word
//! ```
//!
//! The encoder works from the last token to the first and its words are read backwards, so that the decoder works forwards. A
//! decoder that ends in another state than the encoder began with has read damaged code.

/// Bits of the sum of a table's frequencies.
pub const SCALE_BITS: u32 = 12;

/// Sum of a table's frequencies.
pub const SCALE: u32 = 1 << SCALE_BITS;

/// Tokens that a table may tell apart.
pub const TOKENS: usize = 128;

/// The smallest state, and the one that encoding begins with.
const LOWEST: u32 = 1 << 16;

/// Slots that one entry of [`Table::first`] stands for.
const COARSE_BITS: u32 = 6;

/// Frequencies of the tokens in one context.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    /// Where the slots of each token begin; one more than there are tokens.
    starts: [u16; TOKENS + 1],
    /// The token of every 64th slot: where to begin to look.
    first: [u8; (SCALE >> COARSE_BITS) as usize],
}

impl Table {
    /// From one frequency a token; those that are not listed are 0.
    ///
    /// # Errors
    /// Where they do not add up to [`SCALE`], or are more than [`TOKENS`].
    pub fn new(frequencies: &[u16]) -> Result<Self, String> {
        let sum: u32 = frequencies.iter().map(|frequency| u32::from(*frequency)).sum();
        if sum != SCALE || frequencies.len() > TOKENS {
            return Err(format!("frequencies add up to {sum}, not {SCALE}"));
        }
        let mut starts = [SCALE as u16; TOKENS + 1];
        let mut start = 0;
        for (token, frequency) in frequencies.iter().enumerate() {
            starts[token] = start;
            start += frequency;
        }
        let mut first = [0; _];
        let mut token = 0;
        for (coarse, first) in first.iter_mut().enumerate() {
            while u32::from(starts[token + 1]) <= (coarse as u32) << COARSE_BITS {
                token += 1;
            }
            *first = token as u8;
        }
        Ok(Self { starts, first })
    }

    /// Where a token's slots begin, and how many it has.
    #[inline(always)]
    fn range(&self, token: usize) -> (u32, u32) {
        let start = u32::from(self.starts[token]);
        (start, u32::from(self.starts[token + 1]) - start)
    }

    /// The frequency of a token.
    #[must_use]
    pub fn frequency(&self, token: usize) -> u32 {
        self.range(token).1
    }
}

/// Codes tokens in reverse: the last one first.
pub struct Encoder {
    state: u32,
    /// Last word first.
    words: Vec<u16>,
}

impl Default for Encoder {
    /// An encoder before its first token.
    fn default() -> Self {
        Self { state: LOWEST, words: Vec::new() }
    }
}

impl Encoder {
    /// Codes the token that stands before all those coded so far. Its frequency must not be 0.
    pub fn push(&mut self, table: &Table, token: usize) {
        let (start, frequency) = table.range(token);
        debug_assert!(frequency > 0, "a token that cannot be coded");
        if u64::from(self.state) >= u64::from(frequency) << (32 - SCALE_BITS) {
            self.words.push(self.state as u16);
            self.state >>= 16;
        }
        self.state = ((self.state / frequency) << SCALE_BITS) + start + self.state % frequency;
    }

    /// The words in the order a [`Decoder`] reads them.
    #[must_use]
    pub fn finish(mut self) -> Vec<u16> {
        self.words.extend([self.state as u16, (self.state >> 16) as u16]);
        self.words.reverse();
        self.words
    }
}

/// Decodes tokens, first to last. Damaged code gives wrong tokens, never a panic; [`Decoder::is_whole`] tells.
pub struct Decoder<'a> {
    state: u32,
    /// Big-endian words.
    words: &'a [[u8; 2]],
    /// Whether more words were asked for than there are.
    starved: bool,
}

impl<'a> Decoder<'a> {
    /// Over all of `words`, big-endian.
    #[must_use]
    pub fn new(words: &'a [[u8; 2]]) -> Self {
        let mut decoder = Self { state: 0, words, starved: false };
        let high = decoder.word();
        decoder.state = high << 16 | decoder.word();
        decoder
    }

    #[inline(always)]
    fn word(&mut self) -> u32 {
        if let Some((word, rest)) = self.words.split_first() {
            self.words = rest;
            u32::from(u16::from_be_bytes(*word))
        } else {
            self.starved = true;
            0
        }
    }

    /// The next token.
    #[inline(always)]
    pub fn next(&mut self, table: &Table) -> usize {
        let slot = self.state & (SCALE - 1);
        let mut token = table.first[(slot >> COARSE_BITS) as usize] as usize;
        while u32::from(table.starts[token + 1]) <= slot {
            token += 1;
        }
        let (start, frequency) = table.range(token);
        // A damaged state may be anything: products below 2^12 · 2^20 cannot overflow.
        self.state = frequency * (self.state >> SCALE_BITS) + slot - start;
        if self.state < LOWEST {
            self.state = self.state << 16 | self.word();
        }
        token
    }

    /// Whether the code ended exactly where the encoder began.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        !self.starved && self.words.is_empty() && self.state == LOWEST
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn tables() -> [Table; 3] {
        let mut skewed = [1_u16; TOKENS];
        skewed[0] = (SCALE - TOKENS as u32 + 1) as u16;
        [&[1, 4095_u16][..], &[0, 0, 4096], &skewed].map(|f| Table::new(f).unwrap())
    }

    fn words(encoder: Encoder) -> Vec<[u8; 2]> {
        encoder.finish().into_iter().map(u16::to_be_bytes).collect()
    }

    proptest! {
        #[test]
        fn tokens_come_back_in_their_order(tokens in prop::collection::vec(0..TOKENS, 0..500)) {
            let tables = tables();
            let coded: Vec<(usize, usize)> =
                tokens.iter().map(|&t| match t % 3 { 0 => (0, t / 3 % 2), 1 => (1, 2), _ => (2, t) }).collect();
            let mut encoder = Encoder::default();
            for &(table, token) in coded.iter().rev() {
                encoder.push(&tables[table], token);
            }
            let words = words(encoder);
            let mut decoder = Decoder::new(&words);
            for &(table, token) in &coded {
                prop_assert_eq!(decoder.next(&tables[table]), token);
            }
            prop_assert!(decoder.is_whole());
        }

        #[test]
        fn damaged_words_never_panic(words in prop::collection::vec(any::<[u8; 2]>(), 0..40)) {
            let tables = tables();
            let mut decoder = Decoder::new(&words);
            for nth in 0..200 {
                decoder.next(&tables[nth % 3]);
            }
            prop_assert!(!decoder.is_whole() || words.len() > 1);
        }
    }

    #[test]
    fn a_likely_token_takes_next_to_nothing() {
        let [skewed, certain, _] = tables();
        let mut encoder = Encoder::default();
        (0..4000).for_each(|_| encoder.push(&skewed, 1));
        (0..4000).for_each(|_| encoder.push(&certain, 2));
        assert_eq!(encoder.finish().len(), 2);
    }

    #[test]
    fn frequencies_that_do_not_fill_the_slots_are_refused() {
        assert!(Table::new(&[]).is_err());
        assert!(Table::new(&[4095]).is_err());
        assert!(Table::new(&[4096, 1]).is_err());
        assert!(Table::new(&[32; 129]).is_err());
    }
}
