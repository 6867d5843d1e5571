//! Entropy coding with fixed frequencies: range asymmetric numeral systems.
//!
//! Source: Duda, *Asymmetric numeral systems: entropy coding combining speed of Huffman coding with compression rate of
//! arithmetic coding*, 2013, in the word-wise form of Giesen, *Interleaved entropy coders*, 2014: four states share one row of
//! words, so that a token need not wait for the one before it. A state `x` of 32 bits is always at least 2¹⁶; a token of frequency
//! `f` (of 4096) that begins at `b` is coded by
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
pub(super) const SCALE_BITS: u32 = 12;

/// Sum of a table's frequencies.
pub(super) const SCALE: u32 = 1 << SCALE_BITS;

/// Tokens that a table may have.
pub(super) const TOKENS: usize = 128;

/// The smallest state, and the one that encoding begins with.
const LOWEST: u32 = 1 << 16;

/// Interleaved streams, each with a state of its own.
pub(super) const STREAMS: usize = 4;

/// Slots that share one entry of [`FrequencyTable::first`], as a power of 2.
const COARSE_BITS: u32 = 4;

/// Entries of [`FrequencyTable::starts`]: more than there are tokens, so that none that fits into a byte lies beyond.
const STARTS: usize = 258;

/// Frequencies of the tokens in one context.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct FrequencyTable {
    /// Where the slots of each token begin; all that follow the last token are [`SCALE`].
    starts: [u16; STARTS],
    /// The token of every 16th slot: where to begin to look.
    first: [u8; (SCALE >> COARSE_BITS) as usize],
}

/// The slots of a token.
#[derive(Clone, Copy)]
pub(crate) struct SlotRange {
    pub(crate) start: u32,
    /// How many there are.
    pub(crate) frequency: u32,
}

impl FrequencyTable {
    /// From one frequency a token; those that are not listed are 0.
    ///
    /// # Errors
    /// Where they do not add up to [`SCALE`], or are more than [`TOKENS`].
    pub(crate) fn new(frequencies: &[u16]) -> Result<Self, String> {
        let sum: u32 = frequencies.iter().map(|frequency| u32::from(*frequency)).sum();
        if sum != SCALE || frequencies.len() > TOKENS {
            return Err(format!("frequencies add up to {sum}, not {SCALE}"));
        }
        let mut starts = [SCALE as u16; STARTS];
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

    /// The slots of a token.
    #[inline(always)]
    pub(crate) fn range(&self, token: usize) -> SlotRange {
        let start = u32::from(self.starts[token]);
        SlotRange { start, frequency: u32::from(self.starts[token + 1]) - start }
    }

    /// The frequency of a token.
    pub(crate) fn frequency(&self, token: usize) -> u32 {
        self.range(token).frequency
    }
}

/// Codes tokens in reverse: the last one first. Each of some interleaved streams has a state of its own.
pub(super) struct RansEncoder<const STATES: usize = STREAMS> {
    states: [u32; STATES],
    /// Last word first.
    words: Vec<u16>,
}

impl<const STATES: usize> Default for RansEncoder<STATES> {
    /// An encoder before its first token.
    fn default() -> Self {
        Self { states: [LOWEST; STATES], words: Vec::new() }
    }
}

impl<const STATES: usize> RansEncoder<STATES> {
    /// Codes the token before all those coded so far, given its slots: at least one.
    pub(super) fn push(&mut self, stream: usize, slots: SlotRange) {
        let SlotRange { start, frequency } = slots;
        debug_assert!(frequency > 0, "a token that cannot be coded");
        let state = &mut self.states[stream];
        if u64::from(*state) >= u64::from(frequency) << (32 - SCALE_BITS) {
            self.words.push(*state as u16);
            *state >>= 16;
        }
        *state = ((*state / frequency) << SCALE_BITS) + start + *state % frequency;
    }

    /// The words in the order a [`Decoder`] reads them.
    pub(super) fn finish(mut self) -> Vec<u16> {
        for state in self.states.into_iter().rev() {
            self.words.extend([state as u16, (state >> 16) as u16]);
        }
        self.words.reverse();
        self.words
    }
}

/// Decodes tokens, first to last. Damaged code gives wrong tokens, never a panic; [`Decoder::is_whole`] detects it.
pub(super) struct Decoder<'a, const STATES: usize = STREAMS> {
    states: [u32; STATES],
    /// Big-endian words.
    words: &'a [[u8; 2]],
    /// Words read; more than there are where the code is cut short.
    position: usize,
}

impl<'a, const STATES: usize> Decoder<'a, STATES> {
    /// Over all of `words`, big-endian.
    pub(super) fn new(words: &'a [[u8; 2]]) -> Self {
        let word = |nth: usize| words.get(nth).map_or(0, |word| u32::from(u16::from_be_bytes(*word)));
        let states = std::array::from_fn(|stream| word(2 * stream) << 16 | word(2 * stream + 1));
        Self { states, words, position: 2 * STATES }
    }

    /// The next token.
    #[inline(always)]
    pub(super) fn next(&mut self, stream: usize, table: &FrequencyTable) -> usize {
        let before = self.states[stream];
        let slot = before & (SCALE - 1);
        let mut token = table.first[(slot >> COARSE_BITS) as usize] as usize;
        // Mostly one step at most: no branch for that one.
        token += usize::from(u32::from(table.starts[token + 1]) <= slot);
        while u32::from(table.starts[token + 1]) <= slot {
            token += 1;
        }
        let SlotRange { start, frequency } = table.range(token);
        self.advance(stream, frequency * (before >> SCALE_BITS) + slot - start);
        token
    }

    /// The next token where there are two: whether it is the second, whose slots begin at `split`.
    #[inline(always)]
    pub(super) fn next_of_two(&mut self, stream: usize, split: u16) -> bool {
        let (before, split) = (self.states[stream], u32::from(split));
        let slot = before & (SCALE - 1);
        let second = slot >= split;
        let (start, frequency) = if second { (split, SCALE - split) } else { (0, split) };
        self.advance(stream, frequency * (before >> SCALE_BITS) + slot - start);
        second
    }

    /// Takes a word where the state has become too small. A damaged state may be anything: products below 2¹² · 2²⁰ do not overflow.
    #[inline(always)]
    fn advance(&mut self, stream: usize, state: u32) {
        // A branch would be mispredicted as often as not.
        let short = state < LOWEST;
        let word = self.words.get(self.position).map_or(0, |word| u32::from(u16::from_be_bytes(*word)));
        self.states[stream] = if short { state << 16 | word } else { state };
        self.position += usize::from(short);
    }

    /// Whether the code ended exactly where the encoder began.
    pub(super) fn is_whole(&self) -> bool {
        self.position == self.words.len() && self.states == [LOWEST; STATES]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn tables() -> [FrequencyTable; 3] {
        let mut skewed = [1_u16; TOKENS];
        skewed[0] = (SCALE - TOKENS as u32 + 1) as u16;
        [&[1, 4095_u16][..], &[0, 0, 4096], &skewed].map(|f| FrequencyTable::new(f).unwrap())
    }

    fn words(encoder: RansEncoder) -> Vec<[u8; 2]> {
        encoder.finish().into_iter().map(u16::to_be_bytes).collect()
    }

    proptest! {
        #[test]
        fn tokens_come_back_in_their_order(tokens in prop::collection::vec(0..TOKENS, 0..500)) {
            let tables = tables();
            let coded: Vec<(usize, usize)> =
                tokens.iter().map(|&t| match t % 3 { 0 => (0, t / 3 % 2), 1 => (1, 2), _ => (2, t) }).collect();
            let mut encoder: RansEncoder = RansEncoder::default();
            for (nth, &(table, token)) in coded.iter().enumerate().rev() {
                encoder.push(nth % STREAMS, tables[table].range(token));
            }
            let words = words(encoder);
            let mut decoder: Decoder<'_> = Decoder::new(&words);
            for (nth, &(table, token)) in coded.iter().enumerate() {
                if table == 0 {
                    let second = decoder.next_of_two(nth % STREAMS, tables[0].range(1).start as u16);
                    prop_assert_eq!(usize::from(second), token);
                } else {
                    prop_assert_eq!(decoder.next(nth % STREAMS, &tables[table]), token);
                }
            }
            prop_assert!(decoder.is_whole());
        }

        #[test]
        fn damaged_words_never_panic(words in prop::collection::vec(any::<[u8; 2]>(), 0..40)) {
            let tables = tables();
            let mut decoder: Decoder<'_> = Decoder::new(&words);
            for nth in 0..200 {
                decoder.next(nth % STREAMS, &tables[nth % 3]);
            }
            prop_assert!(!decoder.is_whole() || words.len() >= 2 * STREAMS);
        }
    }

    #[test]
    fn a_likely_token_takes_next_to_nothing() {
        let [skewed, certain, _] = tables();
        let mut encoder: RansEncoder = RansEncoder::default();
        (0..4000).for_each(|_| encoder.push(1, skewed.range(1)));
        (0..4000).for_each(|_| encoder.push(1, certain.range(2)));
        assert_eq!(encoder.finish().len(), 2 * STREAMS);
    }

    #[test]
    fn frequencies_that_do_not_fill_the_slots_are_refused() {
        assert!(FrequencyTable::new(&[]).is_err());
        assert!(FrequencyTable::new(&[4095]).is_err());
        assert!(FrequencyTable::new(&[4096, 1]).is_err());
        assert!(FrequencyTable::new(&[32; 129]).is_err());
    }
}
