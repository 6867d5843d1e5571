//! Fillings that hold together: neighboring pixels of a hole show the mean of what they were filled with.
//!
//! ```text
//!     hole   a b a a b a       each pixel chose its surface, and its share of the sky, by itself
//!            ◀── r ─▶          the mean along the row, then along the column, over pixels of holes alone
//! ```
//!
//! Beside what is shown a pixel keeps its color: what it is next to is sure.
//!
//! Purpose: rays in eight directions meet now one surface, now another, and lines of sight are seen free or not by a cell's breadth: what
//! single pixels choose is shreds and lace. Where the truth is not known, the mean of what is likely errs least.
//!
//! Source: Tomasi and Manduchi, *Bilateral Filtering for Gray and Color Images*, ICCV 1998. What differs: a box, and either all or nothing
//! of a pixel counts: all where a hole was filled.

use rayon::prelude::*;

use super::surface::WeightedMean;

/// Means reach this share of the picture's width to each side.
const REACH: f32 = 1.0 / 128.0;

/// What fills a pixel of a hole.
#[derive(Clone, Copy, Debug)]
pub(super) struct Filling {
    /// Column of the pixel.
    pub(super) x: usize,
    /// The surface behind; `None` where the line of sight was seen free, so that only the sky is shown.
    pub(super) surface: Option<WeightedMean>,
    /// The share of the sky, 0 to 1.
    pub(super) sky_share: f32,
}

/// Sums over fillings: of colors and their number, and of shares of the sky and their number.
type Sums = [f32; 6];

/// Sums along the rows of a picture.
#[derive(Debug, Default)]
pub(super) struct FillingsAround {
    /// Only those of rows with fillings are of this picture.
    sums: Vec<Sums>,
    /// Whether each row has fillings.
    has_fillings: Vec<bool>,
    width: usize,
    reach_px: usize,
}

/// How far means reach in a picture of this width, pixels.
fn reach_px(width: usize) -> usize {
    ((width as f32 * REACH) as usize).max(1)
}

impl FillingsAround {
    /// Sums the fillings of each row of a picture of `width`, their columns ascending.
    pub(super) fn set(&mut self, rows: &[Vec<Filling>], width: usize) {
        let reach_px = reach_px(width);
        self.sums.resize(rows.len() * width, [0.0; 6]);
        let filled = self.sums.par_chunks_mut(width).zip(rows).filter(|(_, row)| !row.is_empty());
        filled.for_each(|(sums, row)| {
            sums.fill([0.0; 6]);
            sum_row(row, reach_px, sums);
        });
        self.has_fillings.clear();
        self.has_fillings.extend(rows.iter().map(|row| !row.is_empty()));
        (self.width, self.reach_px) = (width, reach_px);
    }

    /// Mean color of the surfaces and mean share of the sky around a pixel of a hole that is filled from a surface.
    pub(super) fn mean(&self, (x, y): (usize, usize)) -> ([f32; 3], f32) {
        let last = (y + self.reach_px).min(self.has_fillings.len() - 1);
        let mut all: Sums = [0.0; 6];
        for row in (y.saturating_sub(self.reach_px)..=last).filter(|row| self.has_fillings[*row]) {
            let part = &self.sums[row * self.width + x];
            (0..all.len()).for_each(|nth| all[nth] += part[nth]);
        }
        let [red, green, blue, colors, sky, shares] = all;
        ([red, green, blue].map(|sum| sum / colors), sky / shares)
    }
}

/// Sets the sums of the fillings of a row over `reach_px` to each side; zeros remain where nothing is filled.
fn sum_row(row: &[Filling], reach_px: usize, sums: &mut [Sums]) {
    let of = |filling: &Filling| -> Sums {
        let [red, green, blue] = filling.surface.map_or([0.0; 3], |surface| surface.color);
        [red, green, blue, f32::from(u8::from(filling.surface.is_some())), filling.sky_share, 1.0]
    };
    // Doubles, so that what is added and taken away again leaves nothing behind.
    let (mut within, mut first, mut next) = ([0.0_f64; 6], 0, 0);
    for filling in row {
        while next < row.len() && row[next].x <= filling.x + reach_px {
            (0..6).for_each(|nth| within[nth] += f64::from(of(&row[next])[nth]));
            next += 1;
        }
        while row[first].x + reach_px < filling.x {
            (0..6).for_each(|nth| within[nth] -= f64::from(of(&row[first])[nth]));
            first += 1;
        }
        sums[filling.x] = within.map(|sum| sum as f32);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filling(x: usize, color: f32, sky_share: f32) -> Filling {
        let surface = WeightedMean { color: [color; 3], inverse_depth: 1.0, weight: 1.0 };
        Filling { x, surface: Some(surface), sky_share }
    }

    /// Of the fillings of some rows, in the memory of others.
    fn around_of(rows: &[Vec<Filling>], width: usize) -> FillingsAround {
        let mut around = FillingsAround::default();
        around.set(&vec![vec![filling(0, 7.0, 0.5), filling(3, 9.0, 1.0)]; 50], 4);
        around.set(rows, width);
        around
    }

    #[test]
    fn a_mean_counts_fillings_alone_and_only_as_far_as_it_reaches() {
        // Two pixels to each side.
        let width = 256;
        let row = vec![filling(4, 1.0, 0.0), filling(6, 3.0, 0.5), filling(7, 100.0, 1.0)];
        let below = vec![filling(4, 5.0, 1.0)];
        let around = around_of(&[row, below, Vec::new()], width);
        assert_eq!(around.reach_px, 2);
        // 1 and 3 in the row, and 5 below.
        assert_eq!(around.mean((4, 0)), ([3.0; 3], 0.5));
        assert_eq!(around.mean((7, 0)), ([51.5; 3], 0.75));
    }

    #[test]
    fn where_the_sky_is_known_its_share_counts_and_its_color_does_not() {
        let sky = Filling { x: 1, surface: None, sky_share: 1.0 };
        let around = around_of(&[vec![filling(0, 0.25, 0.0), sky]], 2);
        assert_eq!(around.mean((0, 0)), ([0.25; 3], 0.5));
    }

    #[test]
    fn fillings_that_agree_stay_as_they_are() {
        let row = |_| (0..300).map(|x| filling(x, 0.125, 0.25)).collect();
        let around = around_of(&(0..40).map(row).collect::<Vec<_>>(), 300);
        for pixel in [(0, 0), (299, 39), (150, 20)] {
            assert_eq!(around.mean(pixel), ([0.125; 3], 0.25));
        }
    }
}
