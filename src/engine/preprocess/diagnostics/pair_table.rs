//! A number for each pair of cameras, or for some pairs where there are too many cameras for all.
//!
//! Purpose: what is known of all pairs grows with the square of the number of cameras. Up to [`MOST_PAIRS`] pairs are kept, whole; of
//! more cameras each is paired with a few others, so that memory and reports grow as the number of cameras does.

use serde::{Deserialize, Serialize};

use crate::capture::overlap::OverlapGraph;

/// Up to this many pairs of cameras all are kept.
const MOST_PAIRS: usize = 1000;

/// Beyond, each camera is paired with at least this many others.
const FEWEST_OTHERS: usize = 4;

/// Whether of so many cameras all pairs are kept.
pub(super) fn keeps_all_pairs(cameras: usize) -> bool {
    cameras * cameras.saturating_sub(1) <= MOST_PAIRS
}

/// With how many others a camera is paired where not all pairs are kept.
pub(super) fn others_kept(cameras: usize) -> usize {
    (MOST_PAIRS / cameras.max(1)).max(FEWEST_OTHERS)
}

/// Which pairs are compared, `[source * cameras + target]`: all, or of many cameras each with a few of those that may see the same,
/// spread over them, both ways.
pub(super) fn compared_pairs(pairs: &OverlapGraph<'_>) -> Vec<bool> {
    let cameras = pairs.cameras().len();
    let mut is_compared = vec![false; cameras * cameras];
    for source in 0..cameras {
        let targets: Vec<usize> = if keeps_all_pairs(cameras) {
            (0..cameras).filter(|target| *target != source).collect()
        } else {
            pairs.few_others(source, others_kept(cameras).div_ceil(2)).collect()
        };
        for target in targets {
            is_compared[source * cameras + target] = true;
            is_compared[target * cameras + source] = true;
        }
    }
    is_compared
}

/// A table of pairs of cameras, `(row, column)`. A pair that is left out has no value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct PairTable<T> {
    rows: Vec<Row<T>>,
}

/// The pairs of one camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
enum Row<T> {
    /// With every camera, in order.
    All(Vec<T>),
    /// With some cameras, ascending; never empty, because an empty one reads as the other kind.
    Some(Vec<(u32, T)>),
}

impl<T> Row<T> {
    fn of_some(pairs: Vec<(u32, T)>) -> Self {
        if pairs.is_empty() { Self::All(Vec::new()) } else { Self::Some(pairs) }
    }
}

impl<T> Default for PairTable<T> {
    fn default() -> Self {
        Self { rows: Vec::new() }
    }
}

impl<T> From<Vec<Vec<T>>> for PairTable<T> {
    fn from(rows: Vec<Vec<T>>) -> Self {
        Self { rows: rows.into_iter().map(Row::All).collect() }
    }
}

impl<T> PairTable<T> {
    /// A table of so many cameras with some pairs, which ascend by row and column.
    pub(crate) fn of_some(cameras: usize, pairs: impl IntoIterator<Item = (usize, usize, T)>) -> Self {
        let mut rows: Vec<Vec<(u32, T)>> = (0..cameras).map(|_| Vec::new()).collect();
        for (row, column, value) in pairs {
            if let Some(row) = rows.get_mut(row) {
                row.push((column as u32, value));
            }
        }
        Self { rows: rows.into_iter().map(Row::of_some).collect() }
    }

    /// Rows: the number of cameras, or 0 where nothing is known.
    #[must_use]
    pub fn cameras(&self) -> usize {
        self.rows.len()
    }

    /// The value of a pair; `None` where it is left out.
    #[must_use]
    pub fn get(&self, row: usize, column: usize) -> Option<&T> {
        match self.rows.get(row)? {
            Row::All(values) => values.get(column),
            Row::Some(pairs) => {
                let at = pairs.binary_search_by_key(&column, |(column, _)| *column as usize).ok()?;
                Some(&pairs[at].1)
            }
        }
    }

    /// As [`PairTable::get`], to be changed.
    pub(crate) fn get_mut(&mut self, row: usize, column: usize) -> Option<&mut T> {
        match self.rows.get_mut(row)? {
            Row::All(values) => values.get_mut(column),
            Row::Some(pairs) => {
                let at = pairs.binary_search_by_key(&column, |(column, _)| *column as usize).ok()?;
                Some(&mut pairs[at].1)
            }
        }
    }

    /// The pairs of one camera: column and value, ascending.
    pub fn row(&self, row: usize) -> impl Iterator<Item = (usize, &T)> {
        let (all, some) = match self.rows.get(row) {
            Some(Row::All(values)) => (values.as_slice(), [].as_slice()),
            Some(Row::Some(pairs)) => ([].as_slice(), pairs.as_slice()),
            None => ([].as_slice(), [].as_slice()),
        };
        all.iter().enumerate().chain(some.iter().map(|(column, value)| (*column as usize, value)))
    }

    /// All pairs: row, column and value.
    pub fn iter(&self) -> impl Iterator<Item = (usize, usize, &T)> {
        (0..self.cameras()).flat_map(|row| self.row(row).map(move |(column, value)| (row, column, value)))
    }
}

impl PairTable<u64> {
    /// Keeps the largest counts of each row, so many of them, and gives the sum of the others for each row.
    pub(crate) fn keep_largest(&mut self, kept: usize) -> Vec<u64> {
        let mut left_out = Vec::with_capacity(self.cameras());
        for at in 0..self.cameras() {
            let mut pairs: Vec<(u32, u64)> = self
                .row(at)
                .map(|(column, count)| (column as u32, *count))
                .filter(|pair| pair.1 > 0)
                .collect();
            pairs.sort_by_key(|(column, count)| (std::cmp::Reverse(*count), *column));
            left_out.push(pairs.iter().skip(kept).map(|(_, count)| count).sum());
            pairs.truncate(kept);
            pairs.sort_unstable();
            self.rows[at] = Row::of_some(pairs);
        }
        left_out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_of_all_pairs_and_one_of_some_come_back_from_their_text() {
        let all = PairTable::from(vec![vec![0, 4, 2], vec![1, 0, 7], vec![5, 6, 0]]);
        let some = PairTable::of_some(3, [(0, 1, 4_u64), (2, 0, 5), (2, 1, 6)]);
        for (table, text) in [(&all, "[[0,4,2],[1,0,7],[5,6,0]]"), (&some, "[[[1,4]],[],[[0,5],[1,6]]]")] {
            assert_eq!(serde_json::to_string(table).unwrap(), text);
            assert_eq!(*table, serde_json::from_str(text).unwrap());
        }
        assert_eq!((all.get(1, 2), all.get(1, 3), all.get(3, 0)), (Some(&7), None, None));
        assert_eq!((some.get(2, 1), some.get(2, 2), some.get(1, 0)), (Some(&6), None, None));
        assert_eq!(
            some.iter().map(|(row, column, count)| (row, column, *count)).collect::<Vec<_>>(),
            [(0, 1, 4), (2, 0, 5), (2, 1, 6)]
        );
    }

    #[test]
    fn the_largest_counts_of_a_row_stay_and_the_others_are_summed() {
        let mut table =
            PairTable::from(vec![vec![0, 4, 2, 4], vec![1, 0, 0, 0], vec![0; 4], vec![3, 9, 5, 0]]);
        assert_eq!(table.keep_largest(2), [2, 0, 0, 3]);
        let kept = PairTable::of_some(4, [(0, 1, 4), (0, 3, 4), (1, 0, 1), (3, 1, 9), (3, 2, 5)]);
        assert_eq!(table, kept);
    }

    #[test]
    fn pairs_that_are_kept_grow_as_the_number_of_cameras_does() {
        assert!(keeps_all_pairs(32) && !keeps_all_pairs(33));
        assert_eq!([33, 100, 250, 600, 5000].map(others_kept), [30, 10, 4, 4, 4]);
    }
}
