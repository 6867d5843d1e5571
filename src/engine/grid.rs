//! `Grid<T>`: a row-major image, `[height][width]`, one value per pixel.

use std::ops::{Index, IndexMut};

/// A row-major image of `width × height` values.
///
/// Pixel `(x, y)` is column `x` from the left and row `y` from the top; its center is at `(x + 0.5, y + 0.5)`.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Grid<T> {
    width: usize,
    height: usize,
    values: Vec<T>,
}

impl<T> Grid<T> {
    /// Takes `values` in row-major order.
    ///
    /// # Panics
    /// If there are not exactly `width * height` values: the caller's arithmetic is wrong, whatever the input.
    #[must_use]
    pub fn from_vec(width: usize, height: usize, values: Vec<T>) -> Self {
        assert_eq!(values.len(), width * height, "a grid of {width}×{height}");
        Self { width, height, values }
    }

    /// Fills a grid by calling `value(x, y)` for each pixel, row by row.
    pub fn from_fn(width: usize, height: usize, mut value: impl FnMut(usize, usize) -> T) -> Self {
        let mut values = Vec::with_capacity(width * height);
        for y in 0..height {
            for x in 0..width {
                values.push(value(x, y));
            }
        }
        Self { width, height, values }
    }

    /// Columns.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// `(width, height)`.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// Pixels, `width * height`.
    #[must_use]
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether the grid has no pixel.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The value at `(x, y)`, or `None` outside the grid.
    #[must_use]
    pub fn get(&self, x: usize, y: usize) -> Option<&T> {
        (x < self.width && y < self.height).then(|| &self.values[y * self.width + x])
    }

    /// All values, row-major.
    #[must_use]
    pub fn as_slice(&self) -> &[T] {
        &self.values
    }

    /// All values, row-major, to be changed.
    pub fn as_mut_slice(&mut self) -> &mut [T] {
        &mut self.values
    }

    /// Gives the values back, row-major.
    #[must_use]
    pub fn into_vec(self) -> Vec<T> {
        self.values
    }

    /// Row `y`, left to right.
    #[must_use]
    pub fn row(&self, y: usize) -> &[T] {
        &self.values[y * self.width..(y + 1) * self.width]
    }

    /// A grid of the same size with `f` applied to every value.
    pub fn map<U>(&self, f: impl FnMut(&T) -> U) -> Grid<U> {
        Grid { width: self.width, height: self.height, values: self.values.iter().map(f).collect() }
    }
}

impl<T: Clone> Grid<T> {
    /// A grid with `value` at every pixel.
    #[must_use]
    pub fn filled(width: usize, height: usize, value: T) -> Self {
        Self { width, height, values: vec![value; width * height] }
    }
}

impl<T> Index<(usize, usize)> for Grid<T> {
    type Output = T;

    fn index(&self, (x, y): (usize, usize)) -> &T {
        debug_assert!(x < self.width);
        &self.values[y * self.width + x]
    }
}

impl<T> IndexMut<(usize, usize)> for Grid<T> {
    fn index_mut(&mut self, (x, y): (usize, usize)) -> &mut T {
        debug_assert!(x < self.width);
        &mut self.values[y * self.width + x]
    }
}

#[cfg(test)]
mod tests {
    use super::Grid;

    #[test]
    fn a_grid_is_row_major() {
        let grid = Grid::from_fn(3, 2, |x, y| 10 * y + x);
        assert_eq!(grid.as_slice(), [0, 1, 2, 10, 11, 12]);
        assert_eq!(grid[(2, 1)], 12);
        assert_eq!(grid.row(1), [10, 11, 12]);
        assert_eq!(grid.get(3, 0), None);
    }
}
