//! The static model of the entropy coder: how often each token occurs in each context.
//!
//! The tables are counted over the whole store, which holds them once. Blocks then need no time to learn, however small they
//! are, and each is read without any other. Contexts are numbered so that neighbors resemble each other; those that are not
//! worth a table of their own share one.

use super::integers::split;
use super::plane_model::PlaneModel;
use super::rans::{FrequencyTable, TOKENS};
use super::table_fit::TokenCounts;
use crate::store::container::ByteReader;

/// Levels of activity that contexts distinguish; the last is *no neighbor*.
pub(super) const ACTIVITIES: usize = 17;

/// The planes of an image, each with contexts of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CodedPlane {
    /// Which pixels hold a sample.
    Mask,
    /// Inverse depth.
    Depth,
    /// Green, coded before red and blue.
    Green,
    /// Red.
    Red,
    /// Blue.
    Blue,
    /// First octahedral coordinate.
    NormalX,
    /// Second octahedral coordinate.
    NormalY,
}

impl CodedPlane {
    /// Every plane, in the order of its tables in the store.
    pub(crate) const ALL: [Self; 7] =
        [Self::Mask, Self::Depth, Self::Green, Self::Red, Self::Blue, Self::NormalX, Self::NormalY];

    /// Contexts of the plane.
    pub(crate) const fn contexts(self) -> usize {
        match self {
            Self::Mask => 1 << 10,
            Self::Depth => 11 * ACTIVITIES,
            Self::Green => 6 * ACTIVITIES,
            Self::Red | Self::Blue => 6 * ACTIVITIES * 8,
            Self::NormalX | Self::NormalY => 3 * ACTIVITIES,
        }
    }

    /// Tokens that the plane has at most: a pixel holds a sample or does not.
    const fn tokens(self) -> usize {
        if matches!(self, Self::Mask) { 2 } else { TOKENS }
    }

    /// The stream that the plane's tokens are coded in, except the mask's: of a sample, each color has a stream of its own.
    pub(crate) const fn stream(self) -> usize {
        match self {
            Self::Mask | Self::Depth | Self::NormalX | Self::NormalY => 0,
            Self::Green => 1,
            Self::Red => 2,
            Self::Blue => 3,
        }
    }
}

/// How often each token was seen in each context of each plane.
#[derive(Clone)]
pub(crate) struct Counts([Vec<TokenCounts>; 7]);

impl Default for Counts {
    /// Nothing seen yet.
    fn default() -> Self {
        Self(CodedPlane::ALL.map(|plane| vec![[0; TOKENS]; plane.contexts()]))
    }
}

impl Counts {
    /// Counts a token.
    #[inline(always)]
    pub(crate) fn add(&mut self, plane: CodedPlane, context: usize, value: u32) {
        let count = &mut self.0[plane as usize][context][split(value).0];
        *count = count.saturating_add(1);
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

/// Contexts of the mask.
pub(super) const MASK_CONTEXTS: usize = CodedPlane::Mask.contexts();

/// Per context of the mask, the slot from which on a pixel holds a sample.
pub(super) type MaskSplits = [u16; MASK_CONTEXTS];

/// The tables of every plane.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct FrequencyTables {
    planes: [PlaneModel; 7],
    /// A compact form of the mask's tables, since most tokens are the mask's.
    pub(super) mask: Box<MaskSplits>,
}

impl FrequencyTables {
    /// The table of a context.
    #[inline(always)]
    pub(crate) fn table(&self, plane: CodedPlane, context: usize) -> &FrequencyTable {
        self.planes[plane as usize].table(context)
    }

    /// From the planes in their order.
    fn of(planes: Vec<PlaneModel>) -> Result<Self, String> {
        let planes: [PlaneModel; 7] = planes.try_into().map_err(|_| "planes are missing")?;
        let mut mask = Box::new([0; MASK_CONTEXTS]);
        for (context, split) in mask.iter_mut().enumerate() {
            *split = planes[CodedPlane::Mask as usize].table(context).frequency(0) as u16;
        }
        Ok(Self { planes, mask })
    }

    /// Tables with which what was counted is coded shortly.
    pub(crate) fn fit(counts: &Counts) -> Result<Self, String> {
        Self::of(counts.0.iter().map(|contexts| PlaneModel::fit(contexts)).collect::<Result<_, _>>()?)
    }

    /// Bits that what was counted takes by these tables, plane by plane.
    pub(crate) fn bits(&self, counts: &Counts) -> [f64; 7] {
        CodedPlane::ALL.map(|plane| self.planes[plane as usize].bits(&counts.0[plane as usize]))
    }

    /// As FORMAT.md describes `MODL`.
    pub(crate) fn encode(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.planes.iter().for_each(|plane| plane.encode(&mut bytes));
        bytes
    }

    /// Reads what [`FrequencyTables::encode`] wrote.
    pub(crate) fn decode(bytes: &[u8]) -> Result<Self, String> {
        let mut reader = ByteReader::new(bytes);
        let decode = |plane: CodedPlane| PlaneModel::decode(&mut reader, plane.contexts(), plane.tokens());
        let models = CodedPlane::ALL.map(decode).into_iter().collect::<Result<_, _>>()?;
        reader.finish()?;
        Self::of(models)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counted() -> Counts {
        let mut counts = Counts::default();
        for nth in 0..3000_u32 {
            counts.add(CodedPlane::Depth, (nth % 187) as usize, nth * nth % 97);
            counts.add(CodedPlane::Mask, (nth % 5) as usize, u32::from(nth % 7 == 0));
            counts.add(CodedPlane::Red, 800, if nth == 9 { u32::MAX } else { 0 });
        }
        counts
    }

    #[test]
    fn whatever_was_counted_can_be_coded_and_tables_come_back() {
        let counts = counted();
        let model = FrequencyTables::fit(&counts).unwrap();
        for plane in CodedPlane::ALL {
            for (context, histogram) in counts.0[plane as usize].iter().enumerate() {
                for (token, count) in histogram.iter().enumerate() {
                    assert!(*count == 0 || model.table(plane, context).frequency(token) > 0);
                }
            }
        }
        assert_eq!(FrequencyTables::decode(&model.encode()).unwrap(), model);
    }

    #[test]
    fn contexts_share_tables_until_they_are_worth_their_own() {
        let mut counts = Counts::default();
        assert!(FrequencyTables::fit(&counts).unwrap().encode().len() < 60);
        for nth in 0..20_000 {
            counts.add(CodedPlane::Depth, 3, nth % 4);
            counts.add(CodedPlane::Depth, 4, 12 + nth % 4);
            counts.add(CodedPlane::Green, 3, nth % 4);
            counts.add(CodedPlane::Green, 4, nth % 4);
        }
        let model = FrequencyTables::fit(&counts).unwrap();
        assert_ne!(model.table(CodedPlane::Depth, 3), model.table(CodedPlane::Depth, 4));
        assert_eq!(model.planes[CodedPlane::Green as usize].table_count(), 1);
    }

    #[test]
    fn damaged_tables_are_refused() {
        let bytes = FrequencyTables::fit(&counted()).unwrap().encode();
        for length in 0..bytes.len() {
            assert!(FrequencyTables::decode(&bytes[..length]).is_err());
        }
        assert!(FrequencyTables::decode(&[bytes.as_slice(), &[0]].concat()).is_err());
        for position in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[position] ^= 0x55;
            let _ = FrequencyTables::decode(&damaged);
        }
    }
}
