//! A piece of work that is cut into parts of about the same size, so that several machines can share it.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// Parts that a piece of work may be cut into, at most.
pub const MOST_PARTS: u32 = 9999;

/// One part of a piece of work, written `2/6`: the second of six.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Part {
    /// From 1 to `of`.
    number: u32,
    /// From 1 to [`MOST_PARTS`].
    of: u32,
}

impl Part {
    /// The only part of a piece of work that is not cut.
    pub const WHOLE: Self = Self { number: 1, of: 1 };

    /// The part with this number of `of` parts; `None` where there is no such part, or `of` exceeds [`MOST_PARTS`].
    #[must_use]
    pub fn new(number: u32, of: u32) -> Option<Self> {
        ((1..=of).contains(&number) && of <= MOST_PARTS).then_some(Self { number, of })
    }

    /// All parts of a piece of work that is cut into `of`, in order; none where `of` exceeds [`MOST_PARTS`].
    pub fn all(of: u32) -> impl Iterator<Item = Self> {
        (1..=of).filter_map(move |number| Self::new(number, of))
    }

    /// Its number, from 1.
    #[must_use]
    pub fn number(self) -> u32 {
        self.number
    }

    /// How many parts there are.
    #[must_use]
    pub fn of(self) -> u32 {
        self.of
    }

    /// Name of the file that holds this part of a piece of work with a name, as in `scan.part-2-of-6`.
    #[must_use]
    pub fn file_name(self, name: &str) -> String {
        format!("{name}.part-{}-of-{}", self.number, self.of)
    }

    /// Which of `total` units of work belong to the part: units that follow one another. All parts together hold each unit once;
    /// where there are fewer units than parts, some parts are empty.
    #[must_use]
    pub fn range(self, total: usize) -> Range<usize> {
        let end_of = |number: u32| (total as u128 * u128::from(number) / u128::from(self.of)) as usize;
        end_of(self.number - 1)..end_of(self.number)
    }
}

impl fmt::Display for Part {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}/{}", self.number, self.of)
    }
}

impl FromStr for Part {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text
            .split_once('/')
            .and_then(|(number, of)| Some((number.trim().parse().ok()?, of.trim().parse().ok()?)));
        numbers.and_then(|(number, of)| Self::new(number, of)).ok_or_else(|| {
            format!(
                "write it as the number of the part and that of all parts, as in 2/6; at most {MOST_PARTS}"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_hold_each_unit_once_and_differ_by_one_at_most() {
        for (total, of) in [(0, 3), (2, 3), (60, 6), (61, 7), (3000, 256)] {
            let ranges: Vec<_> = Part::all(of).map(|part| part.range(total)).collect();
            assert_eq!(ranges.iter().cloned().flatten().collect::<Vec<_>>(), (0..total).collect::<Vec<_>>());
            let sizes = || ranges.iter().map(ExactSizeIterator::len);
            assert!(sizes().max().unwrap() - sizes().min().unwrap() <= 1, "{total} in {of}");
        }
    }

    #[test]
    fn a_part_is_read_as_it_is_written_and_nonsense_is_refused() {
        let part: Part = "2/6".parse().unwrap();
        assert_eq!((part.number(), part.of(), part.to_string().as_str()), (2, 6, "2/6"));
        for text in ["", "2", "0/6", "7/6", "1/0", "-1/2", "a/b", "1/10000"] {
            assert!(text.parse::<Part>().unwrap_err().contains("2/6"), "{text}");
        }
    }
}
