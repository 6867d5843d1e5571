//! The doubtful samples of an image in the chunk `DOUB`: runs of pixels, tile by tile.
//!
//! Purpose: one bit a sample that older readers may skip, and that is known of a block before any other is decoded. Source: run
//! lengths, as fax machines code them. What differs: pixels without a sample count as whatever makes runs longer, so that a tile with
//! nothing but doubtful samples costs nothing.
//!
//! ```text
//! of a picture, tiles row by row, in each its 256 pixels row by row:   run, run, run …   first of others, then of doubtful ones, in turn
//! ```

use crate::samples::{SampleImage, SampleTile, TILE, TILE_SAMPLES, TileMask};

/// The runs of one image.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct DoubtfulRuns {
    /// Where each run ends, in pixels; runs at even places are of samples that are not doubtful.
    ends: Vec<u32>,
}

/// The number of a tile in a picture with so many tiles in a row.
fn number_of(tile: &SampleTile, tiles_across: usize) -> usize {
    tile.tile_y as usize * tiles_across + tile.tile_x as usize
}

impl DoubtfulRuns {
    /// Those of an image of a camera with `width` columns; none where no sample is doubtful.
    pub(crate) fn of(image: &SampleImage, width: usize) -> Self {
        let tiles_across = width.div_ceil(TILE);
        let mut runs = Self::default();
        let mut masks = image.doubtful.iter().peekable();
        for (index, tile) in image.tiles.iter().enumerate() {
            let doubtful =
                masks.next_if(|mask| mask.tile as usize == index).map_or([0; TILE], |mask| mask.rows);
            let start = number_of(tile, tiles_across) * TILE_SAMPLES;
            for (row, (&there, &doubtful)) in tile.rows.iter().zip(&doubtful).enumerate() {
                for column in (0..TILE).filter(|column| there >> column & 1 == 1) {
                    let is_doubtful = doubtful >> column & 1 == 1;
                    // The last run is of doubtful samples if there is an odd number of ends.
                    if is_doubtful != (runs.ends.len() % 2 == 1) {
                        runs.ends.push((start + row * TILE + column) as u32);
                    }
                }
            }
        }
        runs
    }

    /// Whether no sample is doubtful.
    pub(crate) fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// The lengths of the runs but the last, which goes on to the end of the picture.
    pub(crate) fn lengths(&self) -> impl ExactSizeIterator<Item = u32> + '_ {
        let mut before = 0;
        self.ends.iter().map(move |&end| end - std::mem::replace(&mut before, end))
    }

    /// Runs of these lengths, in a picture of `pixels` pixels, whole tiles.
    ///
    /// # Errors
    /// Where runs are empty, but for the first, or too long.
    pub(crate) fn from_lengths(
        lengths: impl Iterator<Item = Result<u64, String>>,
        pixels: usize,
    ) -> Result<Self, String> {
        let mut ends = Vec::new();
        let mut end = 0_u64;
        for length in lengths {
            let length = length?;
            if length == 0 && !ends.is_empty() {
                return Err("a run of doubtful samples is empty".to_owned());
            }
            end = end.saturating_add(length);
            if end >= pixels as u64 {
                return Err("runs of doubtful samples go beyond the picture".to_owned());
            }
            ends.push(end as u32);
        }
        Ok(Self { ends })
    }

    /// The doubtful samples of some tiles of a camera with `width` columns.
    pub(crate) fn masks(&self, tiles: &[SampleTile], width: usize) -> Vec<TileMask> {
        if self.is_empty() {
            return Vec::new();
        }
        let tiles_across = width.div_ceil(TILE);
        let mask_of = |(index, tile): (usize, &SampleTile)| {
            let inside = self.rows(number_of(tile, tiles_across));
            let rows = std::array::from_fn(|row| inside[row] & tile.rows[row]);
            (rows != [0; TILE]).then_some(TileMask { tile: index as u32, rows })
        };
        tiles.iter().enumerate().filter_map(mask_of).collect()
    }

    /// The pixels of a tile, given by its number, that are in runs of doubtful samples.
    fn rows(&self, number: usize) -> [u16; TILE] {
        let (first, last) = (number * TILE_SAMPLES, (number + 1) * TILE_SAMPLES);
        let mut rows = [0; TILE];
        let mut run = self.ends.partition_point(|end| *end as usize <= first);
        let mut at = first;
        while at < last {
            let end = self.ends.get(run).map_or(last, |end| (*end as usize).min(last));
            if run % 2 == 1 {
                (at..end)
                    .map(|pixel| pixel - first)
                    .for_each(|pixel| rows[pixel / TILE] |= 1 << (pixel % TILE));
            }
            (at, run) = (end, run + 1);
        }
        rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tile(tile_x: u16, tile_y: u16, rows: [u16; TILE]) -> SampleTile {
        SampleTile { tile_x, tile_y, first: 0, rows }
    }

    fn image(tiles: Vec<SampleTile>, doubtful: Vec<TileMask>) -> SampleImage {
        SampleImage {
            camera: 0,
            span: crate::samples::Span { start: 0, end: 1 },
            color: Vec::new(),
            depth: crate::samples::DepthPlane::default(),
            normal: None,
            tiles,
            doubtful,
            values: crate::capture::Values::default(),
        }
    }

    #[test]
    fn masks_come_back_and_what_lies_between_samples_costs_no_run() {
        let full = [u16::MAX; TILE];
        let sparse = std::array::from_fn(|row| if row % 3 == 0 { 0b1001 } else { 0 });
        let tiles = vec![tile(0, 0, full), tile(2, 0, full), tile(1, 1, sparse), tile(2, 2, full)];
        let some = std::array::from_fn(|row| if row == 7 { 0xff00 } else { 0 });
        let mask = |tile, rows| TileMask { tile, rows };
        for doubtful in [
            Vec::new(),
            vec![mask(0, some)],
            vec![mask(1, full), mask(2, sparse)],
            vec![mask(0, full), mask(1, full), mask(2, sparse), mask(3, full)],
            vec![mask(3, some)],
        ] {
            let image = image(tiles.clone(), doubtful);
            let runs = DoubtfulRuns::of(&image, 40);
            assert_eq!(runs.is_empty(), image.doubtful.is_empty());
            assert_eq!(runs.masks(&image.tiles, 40), image.doubtful);
            let lengths: Vec<u64> = runs.lengths().map(u64::from).collect();
            let again = DoubtfulRuns::from_lengths(lengths.iter().copied().map(Ok), 9 * TILE_SAMPLES);
            assert_eq!(again.as_ref(), Ok(&runs));
        }
        let two_tiles = image(tiles, vec![mask(1, full), mask(2, sparse)]);
        assert_eq!(DoubtfulRuns::of(&two_tiles, 40).ends.len(), 2, "from the second tile to the fourth");
    }

    #[test]
    fn runs_that_are_empty_or_leave_the_picture_are_refused() {
        let runs = |lengths: &[u64]| DoubtfulRuns::from_lengths(lengths.iter().copied().map(Ok), 256);
        assert!(runs(&[0, 255]).is_ok());
        assert!(runs(&[3, 0]).is_err() && runs(&[256]).is_err() && runs(&[1, u64::MAX]).is_err());
    }
}
