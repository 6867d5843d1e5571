//! A picture out of levels that are coarser than it.
//!
//! Source: R. G. Keys, *Cubic Convolution Interpolation for Digital Image Processing*, 1981. What differs: interpolation is in square roots
//! of linear color, which are close to how bright colors look, stays within the range of the pixels around, and keeps away from holes.

use std::sync::Arc;

use rayon::prelude::*;

use super::levels::LevelMap;
use crate::render::vantage::{NO_IMAGE, Picture};
use crate::simd::{self, VectorLoop};

/// Inverse depths that differ by no more than this share are interpolated.
const ONE_SURFACE: f32 = 0.02;

/// A picture blended from its levels by the map. A pixel is a hole where the level that it shows most of has a hole.
pub(super) fn blended(
    levels: &[(usize, Arc<Picture>)],
    map: &LevelMap,
    (width, height): (usize, usize),
) -> Picture {
    let mut picture = Picture::empty(width, height);
    let shown: Vec<ShownLevel> =
        levels.iter().map(|(level, picture)| ShownLevel::new(*level, picture, width)).collect();
    let across = Taps::row(map.coarsest, width, map.levels.width());
    let rows = picture.color.as_mut_slice().par_chunks_mut(width);
    let rows = rows.zip(picture.inverse_depth.as_mut_slice().par_chunks_mut(width));
    let rows = rows.zip(picture.image.as_mut_slice().par_chunks_mut(width)).enumerate();
    rows.for_each_init(RowScratch::default, |scratch, (y, ((color, inverse_depth), image))| {
        scratch.set_levels(map, y, &across);
        scratch.clear(width);
        scratch.down.clear();
        scratch.down.extend(shown.iter().map(|level| level.rows_at(y)));
        simd::run(BlendRow { shown: &shown, scratch, color, inverse_depth, image });
    });
    picture
}

/// Blends a row of the picture.
struct BlendRow<'a> {
    shown: &'a [ShownLevel<'a>],
    /// With the levels and taps of the row.
    scratch: &'a mut RowScratch,
    color: &'a mut [[f32; 3]],
    inverse_depth: &'a mut [f32],
    image: &'a mut [u32],
}

impl VectorLoop for BlendRow<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { shown, scratch, color, inverse_depth, image } = self;
        for (nth, level) in shown.iter().enumerate() {
            level.add_row(nth, scratch);
        }
        let pixels = color.iter_mut().zip(inverse_depth).zip(image);
        for (x, ((color, inverse_depth), image)) in pixels.enumerate() {
            let nth = scratch.most[x].1;
            (*inverse_depth, *image) = shown[nth].surface_at(&shown[nth].across[x], &scratch.down[nth]);
            let [red, green, blue, share] = scratch.sums[x];
            if share > 0.0 && (*image != NO_IMAGE || *inverse_depth >= 0.0) {
                *color = [red, green, blue].map(|sum| squared(sum / share));
            }
        }
    }
}

/// What the rows of a thread are made in.
#[derive(Default)]
struct RowScratch {
    /// The level that each pixel shows.
    levels: Vec<f32>,
    /// Roots of color and share of what is no hole, weighted.
    sums: Vec<ColorRoots>,
    /// The largest weight of a level, and which it is.
    most: Vec<(f32, usize)>,
    /// Between which rows of each level the row lies.
    down: Vec<Taps>,
    /// The row between those of a level.
    between: Vec<ColorRoots>,
}

impl RowScratch {
    /// Empties the sums of a row.
    fn clear(&mut self, width: usize) {
        self.sums.clear();
        self.sums.resize(width, [0.0; 4]);
        self.most.clear();
        self.most.resize(width, (0.0, 0));
    }

    fn set_levels(&mut self, map: &LevelMap, y: usize, across: &[Taps]) {
        let (width, height) = map.levels.size();
        let down = Taps::new(map.coarsest, y, height);
        let row = |row: usize| &map.levels.as_slice()[row * width..][..width];
        let (above, below) = (row(down.at[1]), row(down.at[2]));
        let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
        self.levels.clear();
        self.levels.extend(across.iter().map(|taps| {
            let [left, right] = [taps.at[1], taps.at[2]].map(|x| mix(above[x], below[x], down.along));
            mix(left, right, taps.along)
        }));
    }
}

/// Square roots of red, green and blue, and 1; zeros in holes.
type ColorRoots = [f32; 4];

/// The root of a color, of either sign.
fn root(color: f32) -> f32 {
    color.abs().sqrt().copysign(color)
}

fn squared(root: f32) -> f32 {
    root * root.abs()
}

/// A level, prepared for interpolation.
struct ShownLevel<'a> {
    level: usize,
    picture: &'a Picture,
    shown: Vec<ColorRoots>,
    /// Taps of the pixels of a row.
    across: Vec<Taps>,
}

impl<'a> ShownLevel<'a> {
    /// For a picture of this width, pixels.
    fn new(level: usize, picture: &'a Picture, width: usize) -> Self {
        let pixel = |((color, w), image): ((&[f32; 3], &f32), &u32)| {
            let [red, green, blue] = color.map(root);
            if *image != NO_IMAGE || *w >= 0.0 { [red, green, blue, 1.0] } else { [0.0; 4] }
        };
        let depths = picture.inverse_depth.as_slice().par_iter();
        let pixels = picture.color.as_slice().par_iter().zip(depths).zip(picture.image.as_slice());
        let across = Taps::row(level, width, picture.image.width());
        Self { level, picture, shown: pixels.map(pixel).collect(), across }
    }

    /// Between which rows of this level a row of the picture lies.
    fn rows_at(&self, y: usize) -> Taps {
        Taps::new(self.level, y, self.picture.image.height())
    }

    /// Adds what a row of the picture shows of this level, which is the `nth`.
    #[inline(always)]
    fn add_row(&self, nth: usize, scratch: &mut RowScratch) {
        let RowScratch { levels, sums, most, down, between } = scratch;
        let weight_at = |shown: f32| (1.0 - (shown - self.level as f32).abs()).max(0.0);
        if levels.iter().all(|shown| weight_at(*shown) == 0.0) {
            return;
        }
        let (width, down) = (self.picture.image.width(), &down[nth]);
        let rows = down.at.map(|row| &self.shown[row * width..][..width]);
        between.clear();
        between.extend((0..width).map(|x| down.interpolated(rows.map(|row| row[x]))));
        for (x, shown) in levels.iter().enumerate() {
            let weight = weight_at(*shown);
            if weight == 0.0 {
                continue;
            }
            let across = &self.across[x];
            let value = across.interpolated(across.at.map(|x| between[x]));
            for channel in 0..4 {
                sums[x][channel] += weight * value[channel];
            }
            if weight > most[x].0 {
                most[x] = (weight, nth);
            }
        }
    }

    /// Inverse depth and image at a pixel of the picture: of the nearest pixel, its depth interpolated on the same surface.
    #[inline(always)]
    fn surface_at(&self, across: &Taps, down: &Taps) -> (f32, u32) {
        let nearest = |taps: &Taps| taps.at[if taps.along < 0.5 { 1 } else { 2 }];
        let (depths, width) = (self.picture.inverse_depth.as_slice(), self.picture.image.width());
        let at = nearest(down) * width + nearest(across);
        let (own, image) = (depths[at], self.picture.image.as_slice()[at]);
        let corner = |right: usize, below: usize| {
            let w = depths[down.at[1 + below] * width + across.at[1 + right]];
            let is_same = w >= 0.0 && own >= 0.0 && (w - own).abs() <= ONE_SURFACE * own;
            if is_same { w } else { own }
        };
        let row = |below: usize| {
            let (left, right) = (corner(0, below), corner(1, below));
            left + (right - left) * across.along
        };
        let (above, below) = (row(0), row(1));
        (above + (below - above) * down.along, image)
    }
}

/// The four pixels of a level, along one axis, between whose middle two a pixel of the picture lies.
struct Taps {
    at: [usize; 4],
    /// How far it lies from the second toward the third, 0 to 1.
    along: f32,
    /// How much each counts for a cubic.
    weights: [f32; 4],
}

impl Taps {
    /// Taps of the pixel at a position of the picture; the level has `size` pixels, and the outermost go on beyond it.
    fn new(level: usize, position: usize, size: usize) -> Self {
        let scale = (1_usize << level) as f32;
        let there = (position as f32 + 0.5) / scale - 0.5;
        let first = there.floor();
        let at = |step: i64| (first as i64 + step).clamp(0, size as i64 - 1) as usize;
        Self::between([at(-1), at(0), at(1), at(2)], there - first)
    }

    /// Between the second and the third of four pixels.
    fn between(at: [usize; 4], along: f32) -> Self {
        let (t, t2, t3) = (along, along * along, along * along * along);
        let weights = [
            -0.5 * t3 + t2 - 0.5 * t,
            1.5 * t3 - 2.5 * t2 + 1.0,
            -1.5 * t3 + 2.0 * t2 + 0.5 * t,
            0.5 * t3 - 0.5 * t2,
        ];
        Self { at, along, weights }
    }

    /// Taps of a whole row.
    fn row(level: usize, width: usize, size: usize) -> Vec<Self> {
        (0..width).map(|x| Self::new(level, x, size)).collect()
    }

    /// Between four values: cubic within their range, linear beside holes.
    #[inline(always)]
    fn interpolated(&self, [a, b, c, d]: [ColorRoots; 4]) -> ColorRoots {
        let (t, weights) = (self.along, self.weights);
        if a[3].min(b[3]).min(c[3]).min(d[3]) < 1.0 {
            return std::array::from_fn(|i| b[i] + (c[i] - b[i]) * t);
        }
        let mut value = [1.0; 4];
        for i in 0..4 {
            let cubic = a[i] * weights[0] + b[i] * weights[1] + c[i] * weights[2] + d[i] * weights[3];
            let low = a[i].min(b[i]).min(c[i]).min(d[i]);
            let high = a[i].max(b[i]).max(c[i]).max(d[i]);
            value[i] = cubic.max(low).min(high);
        }
        value[3] = 1.0;
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_lies_between_the_pixels_of_a_level_where_both_have_their_centers() {
        let taps = |level, position| {
            let taps = Taps::new(level, position, 5);
            (taps.at, taps.along)
        };
        assert_eq!(taps(0, 3), ([2, 3, 4, 4], 0.0));
        assert_eq!(taps(1, 0), ([0, 0, 0, 1], 0.75), "beyond the first pixel it goes on");
        assert_eq!(taps(1, 5), ([1, 2, 3, 4], 0.25));
        assert_eq!(taps(2, 10), ([1, 2, 3, 4], 0.125));
    }

    #[test]
    fn interpolation_keeps_ramps_stays_within_the_range_around_and_is_linear_beside_holes() {
        let gray = |value: f32| [value, value, value, 1.0];
        let taps = Taps::between([0, 1, 2, 3], 0.25);
        assert!((taps.interpolated([0.1, 0.2, 0.3, 0.4].map(gray))[0] - 0.225).abs() < 1e-6);
        assert_eq!(taps.interpolated([0.0, 0.0, 1.0, 1.0].map(gray))[3], 1.0);
        for values in [[0.0, 0.0, 1.0, 1.0], [1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 1.0, 0.0]] {
            assert!((0.0..=1.0).contains(&taps.interpolated(values.map(gray))[0]), "{values:?}");
        }
        assert_eq!(taps.interpolated([gray(0.4), gray(0.8), [0.0; 4], gray(0.4)]), [0.6, 0.6, 0.6, 0.75]);
    }
}
