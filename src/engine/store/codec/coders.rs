//! The purposes of traversing a block: counting tokens, writing them, reading them. Each is a [`Coder`].

use super::block_traversal::Coder;
use super::integers::{BitReader, BitWriter, join, split};
use super::model::{CodedPlane, Counts, FrequencyTables, MASK_CONTEXTS, MaskSplits};
use super::plane_model::PlaneModel;
use super::rans::{Decoder, RansEncoder, SlotRange, TOKENS};
use super::table_fit::TokenCounts;
use super::value_traversal::{VALUE_CONTEXTS, ValueCoder};
use crate::store::container::{ByteReader, push_varint};

/// Counts tokens, so that a model can be fitted.
pub(crate) struct TokenCounter<'a>(pub &'a mut Counts);

impl Coder for TokenCounter<'_> {
    fn has_sample(&mut self, _: usize, context: usize, value: bool) -> bool {
        self.0.add(CodedPlane::Mask, context, u32::from(value));
        value
    }

    fn code(&mut self, plane: CodedPlane, context: usize, value: u32) -> u32 {
        self.0.add(plane, context, value);
        value
    }
}

/// Writes a block by a model.
///
/// ```text
/// u16 number of words | words, big-endian | plain bits
/// ```
pub(crate) struct ModelWriter<'a> {
    model: &'a FrequencyTables,
    /// Each token's stream, where its slots begin and how many it has.
    tokens: Vec<(u8, u16, u16)>,
    bits: BitWriter,
}

impl<'a> ModelWriter<'a> {
    /// For one block.
    pub(crate) fn new(model: &'a FrequencyTables) -> Self {
        Self { model, tokens: Vec::new(), bits: BitWriter::default() }
    }

    fn push(&mut self, stream: usize, plane: CodedPlane, context: usize, token: usize) {
        let SlotRange { start, frequency } = self.model.table(plane, context).range(token);
        self.tokens.push((stream as u8, start as u16, frequency as u16));
    }

    /// The block's code.
    pub(crate) fn finish(self) -> Vec<u8> {
        let mut encoder: RansEncoder = RansEncoder::default();
        for (stream, start, frequency) in self.tokens.into_iter().rev() {
            let slots = SlotRange { start: u32::from(start), frequency: u32::from(frequency) };
            encoder.push(usize::from(stream), slots);
        }
        let words = encoder.finish();
        let mut code = Vec::from((words.len() as u16).to_be_bytes());
        code.extend(words.into_iter().flat_map(u16::to_be_bytes));
        code.extend(self.bits.finish());
        code
    }
}

impl Coder for ModelWriter<'_> {
    fn has_sample(&mut self, stream: usize, context: usize, value: bool) -> bool {
        self.push(stream, CodedPlane::Mask, context, usize::from(value));
        value
    }

    fn code(&mut self, plane: CodedPlane, context: usize, value: u32) -> u32 {
        let (token, bits) = split(value);
        self.push(plane.stream(), plane, context, token);
        self.bits.push(value, bits);
        value
    }
}

/// Reads what [`ModelWriter`] wrote.
pub(crate) struct ModelReader<'a> {
    model: &'a FrequencyTables,
    mask: &'a MaskSplits,
    tokens: Decoder<'a>,
    bits: BitReader<'a>,
}

impl<'a> ModelReader<'a> {
    /// Over all of `code`; `None` where it is cut short.
    pub(crate) fn new(model: &'a FrequencyTables, code: &'a [u8]) -> Option<Self> {
        let (count, rest) = code.split_first_chunk()?;
        let (words, bits) = rest.split_at_checked(2 * usize::from(u16::from_be_bytes(*count)))?;
        let tokens = Decoder::new(words.as_chunks().0);
        Some(Self { model, mask: &model.mask, tokens, bits: BitReader::new(bits) })
    }

    /// Whether all of the code was read, and made sense.
    pub(crate) fn is_whole(&self) -> bool {
        self.tokens.is_whole() && self.bits.is_whole()
    }
}

impl Coder for ModelReader<'_> {
    #[inline(always)]
    fn has_sample(&mut self, stream: usize, context: usize, _: bool) -> bool {
        self.tokens.next_of_two(stream, self.mask[context % MASK_CONTEXTS])
    }

    #[inline(always)]
    fn code(&mut self, plane: CodedPlane, context: usize, _: u32) -> u32 {
        let token = self.tokens.next(plane.stream(), self.model.table(plane, context));
        let (base, bits) = join(token);
        base | self.bits.next(bits)
    }
}

/// Bits of a number of each plane that is written as it is.
const fn plain_bits(plane: CodedPlane) -> u32 {
    match plane {
        CodedPlane::Mask => 1,
        CodedPlane::Depth => 32,
        CodedPlane::Green | CodedPlane::Red | CodedPlane::Blue => 16,
        CodedPlane::NormalX | CodedPlane::NormalY => 8,
    }
}

/// Writes numbers as they are: the off form.
#[derive(Default)]
pub(crate) struct PlainWriter(BitWriter);

impl PlainWriter {
    /// The block's code.
    pub(crate) fn finish(self) -> Vec<u8> {
        self.0.finish()
    }
}

impl Coder for PlainWriter {
    const PREDICTS: bool = false;

    fn has_sample(&mut self, _: usize, _: usize, value: bool) -> bool {
        self.0.push(u32::from(value), plain_bits(CodedPlane::Mask));
        value
    }

    fn code(&mut self, plane: CodedPlane, _: usize, value: u32) -> u32 {
        self.0.push(value, plain_bits(plane));
        value
    }
}

/// Reads what [`PlainWriter`] wrote.
pub(crate) struct PlainReader<'a>(BitReader<'a>);

impl<'a> PlainReader<'a> {
    /// Over all of `code`.
    pub(crate) fn new(code: &'a [u8]) -> Self {
        Self(BitReader::new(code))
    }

    /// Whether all of the code was read.
    pub(crate) fn is_whole(&self) -> bool {
        self.0.is_whole()
    }
}

impl Coder for PlainReader<'_> {
    const PREDICTS: bool = false;

    fn has_sample(&mut self, _: usize, _: usize, _: bool) -> bool {
        self.0.next(plain_bits(CodedPlane::Mask)) != 0
    }

    fn code(&mut self, plane: CodedPlane, _: usize, _: u32) -> u32 {
        let value = self.0.next(plain_bits(plane));
        // Coordinates of normals have a sign.
        if matches!(plane, CodedPlane::NormalX | CodedPlane::NormalY) {
            value as u8 as i8 as u32
        } else {
            value
        }
    }
}

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
