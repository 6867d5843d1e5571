//! The purposes of traversing a block's scalar values: counting tokens, writing them, reading them.

use super::integers::{BitReader, BitWriter, join, split};
use super::plane_model::PlaneModel;
use super::rans::{Decoder, RansEncoder, SlotRange, TOKENS};
use super::table_fit::TokenCounts;
use super::value_traversal::{VALUE_CONTEXTS, ValueCoder};
use crate::store::container::{ByteReader, push_varint};

/// How often each token was seen, by channel and context.
#[derive(Clone)]
pub(crate) struct ValueCounts(pub(crate) Vec<Vec<TokenCounts>>);

impl ValueCounts {
    /// Nothing was seen yet.
    pub(crate) fn new(channels: usize) -> Self {
        Self((0..channels).map(|_| vec![[0; TOKENS]; VALUE_CONTEXTS]).collect())
    }

    /// Adds what was counted elsewhere.
    pub(crate) fn plus(mut self, other: &Self) -> Self {
        let counts = self.0.iter_mut().flatten().flatten();
        for (count, more) in counts.zip(other.0.iter().flatten().flatten()) {
            *count = count.saturating_add(*more);
        }
        self
    }
}

/// Counts tokens, so that tables can be fitted.
pub(crate) struct ValueCounter<'a>(pub(crate) &'a mut ValueCounts);

impl ValueCoder for ValueCounter<'_> {
    fn code(&mut self, channel: usize, context: usize, value: u32) -> u32 {
        let count = &mut self.0.0[channel][context][split(value).0];
        *count = count.saturating_add(1);
        value
    }
}

/// Writes the values of a block by the tables of their channels.
///
/// ```text
/// varint number of words | words, big-endian | plain bits
/// ```
pub(crate) struct ValueWriter<'a> {
    tables: &'a [PlaneModel],
    tokens: Vec<SlotRange>,
    bits: BitWriter,
}

impl<'a> ValueWriter<'a> {
    /// For one block.
    pub(crate) fn new(tables: &'a [PlaneModel]) -> Self {
        Self { tables, tokens: Vec::new(), bits: BitWriter::default() }
    }

    /// The code of the block's values.
    pub(crate) fn finish(self) -> Vec<u8> {
        let mut encoder: RansEncoder<1> = RansEncoder::default();
        self.tokens.into_iter().rev().for_each(|slots| encoder.push(0, slots));
        let words = encoder.finish();
        let mut code = Vec::new();
        push_varint(&mut code, words.len() as u64);
        code.extend(words.into_iter().flat_map(u16::to_be_bytes));
        code.extend(self.bits.finish());
        code
    }
}

impl ValueCoder for ValueWriter<'_> {
    fn code(&mut self, channel: usize, context: usize, value: u32) -> u32 {
        let (token, bits) = split(value);
        self.tokens.push(self.tables[channel].table(context).range(token));
        self.bits.push(value, bits);
        value
    }
}

/// Reads what [`ValueWriter`] wrote.
pub(crate) struct ValueReader<'a> {
    tables: &'a [PlaneModel],
    tokens: Decoder<'a, 1>,
    bits: BitReader<'a>,
}

impl<'a> ValueReader<'a> {
    /// Over all of `code`; `None` where it is cut short.
    pub(crate) fn new(tables: &'a [PlaneModel], code: &'a [u8]) -> Option<Self> {
        let mut reader = ByteReader::new(code);
        let count = usize::try_from(reader.varint().ok()?).ok()?;
        let (words, bits) = reader.rest.split_at_checked(count.checked_mul(2)?)?;
        Some(Self { tables, tokens: Decoder::new(words.as_chunks().0), bits: BitReader::new(bits) })
    }

    /// Whether all of the code was read, and made sense.
    pub(crate) fn is_whole(&self) -> bool {
        self.tokens.is_whole() && self.bits.is_whole()
    }
}

impl ValueCoder for ValueReader<'_> {
    fn code(&mut self, channel: usize, context: usize, _: u32) -> u32 {
        let token = self.tokens.next(0, self.tables[channel].table(context));
        let (base, bits) = join(token);
        base | self.bits.next(bits)
    }
}
