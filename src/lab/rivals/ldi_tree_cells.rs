//! The cells of an LDI tree, and how an LDI is filled.

use glam::{DVec3, UVec3};

/// Columns and rows of each LDI.
pub(super) const SIDE: usize = 64;

/// Levels below the root at most, so that a cell's place fits into [`Key`].
pub(super) const MAX_LEVEL: u32 = 19;

/// Depths of one LDI pixel that are less than this apart are one, in its pixels.
const SAME_DEPTH: f32 = 1.0;

/// Level and place of a cell, the level in the highest bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Key(pub(super) u64);

impl Key {
    pub(super) fn new(level: u32, place: UVec3) -> Self {
        let [x, y, z] = place.to_array().map(u64::from);
        Self(u64::from(level) << 57 | x << 38 | y << 19 | z)
    }

    pub(super) fn level(self) -> u32 {
        (self.0 >> 57) as u32
    }

    pub(super) fn place(self) -> UVec3 {
        let part = |shift: u32| (self.0 >> shift & 0x7_FFFF) as u32;
        UVec3::new(part(38), part(19), part(0))
    }

    pub(super) fn parent(self) -> Option<Self> {
        Some(Self::new(self.level().checked_sub(1)?, self.place() / 2))
    }
}

/// The cube of the root.
#[derive(Clone, Copy, Debug)]
pub(super) struct Root {
    pub(super) low: DVec3,
    pub(super) width: f64,
}

impl Root {
    pub(super) fn cell_width(&self, level: u32) -> f64 {
        self.width / f64::from(1_u32 << level)
    }

    /// Distance of the LDI pixels of a level.
    pub(super) fn spacing(&self, level: u32) -> f64 {
        self.cell_width(level) / SIDE as f64
    }

    pub(super) fn corner(&self, key: Key) -> DVec3 {
        self.low + key.place().as_dvec3() * self.cell_width(key.level())
    }

    /// The cell of a point whose pixel is as wide as `stamp`: that of the level whose LDI pixels are most nearly as wide.
    pub(super) fn cell_of(&self, point: DVec3, stamp: f64) -> Key {
        let level = (self.spacing(0) / stamp).log2().round().clamp(0.0, f64::from(MAX_LEVEL)) as u32;
        let last = f64::from((1_u32 << level) - 1);
        let place =
            ((point - self.low) / self.cell_width(level)).floor().clamp(DVec3::ZERO, DVec3::splat(last));
        Key::new(level, place.as_uvec3())
    }
}

/// A depth pixel of an LDI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DepthPixel {
    /// Row by row.
    pub(super) pixel: u16,
    /// Distance from the face, in LDI pixels.
    pub(super) depth: f32,
    /// Encoded; the mean of all that was spread here.
    pub(super) color: [f32; 3],
    /// How much was, in pixels.
    pub(super) weight: f32,
}

/// An LDI that is being filled.
pub(super) struct Ldi {
    corner: DVec3,
    spacing: f64,
    axis: usize,
    pub(super) pixels: Vec<Vec<DepthPixel>>,
}

impl Ldi {
    pub(super) fn new(root: Root, key: Key, axis: usize) -> Self {
        let (corner, spacing) = (root.corner(key), root.spacing(key.level()));
        Self { corner, spacing, axis, pixels: vec![Vec::new(); SIDE * SIDE] }
    }

    /// Spreads a point over the four LDI pixels around it.
    pub(super) fn add(&mut self, point: DVec3, color: [f32; 3], weight: f32) {
        let local = (point - self.corner) / self.spacing;
        let (x, y) = (local[(self.axis + 1) % 3] - 0.5, local[(self.axis + 2) % 3] - 0.5);
        let depth = local[self.axis] as f32;
        let (left, top) = (x.floor(), y.floor());
        for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let share = (1.0 - (x - left - dx).abs()) * (1.0 - (y - top - dy).abs());
            if share > 0.0 {
                let inside = |at: f64| at.clamp(0.0, (SIDE - 1) as f64) as usize;
                let pixel = inside(top + dy) * SIDE + inside(left + dx);
                let weight = weight * share as f32;
                merge(&mut self.pixels[pixel], DepthPixel { pixel: pixel as u16, depth, color, weight });
            }
        }
    }

    pub(super) fn finish(self) -> Vec<DepthPixel> {
        self.pixels.into_iter().flatten().collect()
    }
}

/// Adds a depth pixel to those of its place: to the mean of the one that is at its depth, or as another.
fn merge(pixels: &mut Vec<DepthPixel>, new: DepthPixel) {
    let Some(known) = pixels.iter_mut().find(|known| (known.depth - new.depth).abs() < SAME_DEPTH) else {
        pixels.push(new);
        return;
    };
    known.weight += new.weight;
    let share = new.weight / known.weight;
    known.depth += share * (new.depth - known.depth);
    for (mean, value) in known.color.iter_mut().zip(new.color) {
        *mean += share * (value - *mean);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_has_its_parent_twice_as_wide() {
        let key = Key::new(7, UVec3::new(5, 100, 3));
        assert_eq!((key.level(), key.place()), (7, UVec3::new(5, 100, 3)));
        assert_eq!(key.parent(), Some(Key::new(6, UVec3::new(2, 50, 1))));
        assert_eq!(Key::new(0, UVec3::ZERO).parent(), None);
    }
}
