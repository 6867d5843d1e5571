//! Samples at half the resolution: one of each surface for every 2×2 pixels of a camera.
//!
//! Purpose: the cost of a picture coarser than the recording depends on the picture alone. Each level of a pyramid is made of the next
//! finer one.
//!
//! Source: Lance Williams, *Pyramidal Parametrics*, SIGGRAPH 1983. What differs: samples of different surfaces are kept apart, so that no
//! level has depths in the air between them. The surface that most samples of a square show stays, the nearer of two with as many.

use std::collections::BTreeMap;

use half::f16;

use super::depth_plane::{DepthPlane, TILE_SAMPLES};
use super::sample_set::SampleImage;
use super::tile::{SampleTile, TILE, TileMask};
use crate::capture::{Camera, Intrinsics, Values};

/// Columns and rows of the four tiles that one coarser tile is made of.
const SIDE: usize = 2 * TILE;

/// Inverse depths in a square that differ by at most this many footprints are of one surface, however slanted it is.
const SAME_FOOTPRINTS: f32 = 8.0;

/// The camera with pixels twice as wide and high. The last of an odd number of columns or rows is joined with nothing.
pub(crate) fn halved_camera(camera: &Camera) -> Camera {
    let Intrinsics { width, height, fx, fy, cx, cy, projection } = camera.intrinsics;
    let intrinsics = Intrinsics {
        width: width.div_ceil(2),
        height: height.div_ceil(2),
        fx: 0.5 * fx,
        fy: 0.5 * fy,
        cx: 0.5 * cx,
        cy: 0.5 * cy,
        projection,
    };
    Camera { intrinsics, ..camera.clone() }
}

/// How far inverse depths of one surface may differ.
#[derive(Clone, Copy)]
struct SameDepth {
    /// In perspective a share of the depth, else a distance in world units.
    size: f32,
    is_orthographic: bool,
}

impl SameDepth {
    fn between(self, a: f32, b: f32) -> f32 {
        self.size * if self.is_orthographic { a * b } else { a.max(b) }
    }
}

/// The sample of one pixel.
#[derive(Clone, Copy)]
struct PixelSample {
    color: [f32; 3],
    inverse_depth: f32,
    is_doubtful: bool,
}

/// The samples of four tiles, row-major.
struct Square {
    parts: Vec<Option<PixelSample>>,
}

impl Square {
    /// Adds the samples of one of the four tiles, the index of a tile of `image`.
    fn add(&mut self, image: &SampleImage, index: usize) {
        let tile = &image.tiles[index];
        let mut depths = [0.0; TILE_SAMPLES];
        image.depth.tile(index, tile.first, tile.count()).unpack(&mut depths);
        let doubtful = image.doubtful_rows(index);
        let (left, top) = (usize::from(tile.tile_x) % 2 * TILE, usize::from(tile.tile_y) % 2 * TILE);
        let mut nth = 0;
        for (row, columns) in tile.rows.iter().enumerate() {
            for column in (0..TILE).filter(|column| columns >> column & 1 == 1) {
                self.parts[(top + row) * SIDE + left + column] = Some(PixelSample {
                    color: image.color[tile.first as usize + nth].map(f16::to_f32),
                    inverse_depth: depths[nth],
                    is_doubtful: doubtful.is_some_and(|rows| rows[row] >> column & 1 == 1),
                });
                nth += 1;
            }
        }
    }

    /// The sample of the 2×2 pixels at a column and row of the coarser tile.
    fn joined(&self, (column, row): (usize, usize), tolerance: SameDepth) -> Option<PixelSample> {
        let first = 2 * row * SIDE + 2 * column;
        let parts = [first, first + 1, first + SIDE, first + SIDE + 1].map(|at| self.parts[at]);
        let same_as = |own: f32| {
            let is_same = move |part: &&PixelSample| {
                (part.inverse_depth - own).abs() <= tolerance.between(part.inverse_depth, own)
            };
            parts.iter().flatten().filter(is_same)
        };
        let own = parts
            .iter()
            .flatten()
            .map(|part| part.inverse_depth)
            .max_by(|a, b| same_as(*a).count().cmp(&same_as(*b).count()).then(a.total_cmp(b)))?;
        let count = same_as(own).count() as f32;
        let mut mean = PixelSample { color: [0.0; 3], inverse_depth: 0.0, is_doubtful: true };
        for part in same_as(own) {
            (0..3).for_each(|channel| mean.color[channel] += part.color[channel] / count);
            mean.inverse_depth += part.inverse_depth / count;
            mean.is_doubtful &= part.is_doubtful;
        }
        Some(mean)
    }
}

impl SampleImage {
    /// The image at half the resolution, as [`halved_camera`] of its camera sees it, without normals and scalar values. `lens` is its own camera's.
    #[must_use]
    pub(crate) fn halved(&self, lens: &Intrinsics) -> Self {
        let focal_px = (lens.fx * lens.fy).sqrt() as f32;
        let same = SameDepth { size: SAME_FOOTPRINTS / focal_px, is_orthographic: lens.is_orthographic() };
        let mut squares: BTreeMap<(u16, u16), Vec<usize>> = BTreeMap::new();
        for (index, tile) in self.tiles.iter().enumerate() {
            squares.entry((tile.tile_y / 2, tile.tile_x / 2)).or_default().push(index);
        }
        let mut half = Self {
            camera: self.camera,
            span: self.span,
            tiles: Vec::with_capacity(squares.len()),
            color: Vec::with_capacity(self.color.len() / 3),
            depth: DepthPlane::default(),
            normal: None,
            doubtful: Vec::new(),
            values: Values::default(),
        };
        let mut depths = Vec::with_capacity(TILE_SAMPLES);
        let mut square = Square { parts: vec![None; SIDE * SIDE] };
        for ((tile_y, tile_x), tiles) in squares {
            square.parts.fill(None);
            for index in tiles {
                square.add(self, index);
            }
            let mut tile = SampleTile { tile_x, tile_y, first: half.color.len() as u32, rows: [0; TILE] };
            let mut doubtful = TileMask { tile: half.tiles.len() as u32, rows: [0; TILE] };
            depths.clear();
            for row in 0..TILE {
                for column in 0..TILE {
                    let Some(part) = square.joined((column, row), same) else {
                        continue;
                    };
                    tile.rows[row] |= 1 << column;
                    doubtful.rows[row] |= u16::from(part.is_doubtful) << column;
                    half.color.push(part.color.map(f16::from_f32));
                    depths.push(part.inverse_depth);
                }
            }
            half.depth.push_tile(&depths);
            half.tiles.push(tile);
            if doubtful.rows != [0; TILE] {
                half.doubtful.push(doubtful);
            }
        }
        half
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::Span;
    use glam::DAffine3;

    const LENS: Intrinsics = Intrinsics::centered(64, 64, 1000.0);

    /// Column, row, color and inverse depth of a sample.
    type Listed = (usize, usize, f32, f32);

    /// An image of samples.
    fn image(samples: &[Listed]) -> SampleImage {
        let mut by_tile: BTreeMap<(u16, u16), Vec<Listed>> = BTreeMap::new();
        for &(x, y, color, w) in samples {
            by_tile.entry(((y / TILE) as u16, (x / TILE) as u16)).or_default().push((
                y % TILE,
                x % TILE,
                color,
                w,
            ));
        }
        let (mut tiles, mut color, mut depth) = (Vec::new(), Vec::new(), Vec::new());
        for ((tile_y, tile_x), mut parts) in by_tile {
            parts.sort_by_key(|part| (part.0, part.1));
            let mut tile = SampleTile { tile_x, tile_y, first: color.len() as u32, rows: [0; TILE] };
            for (y, x, gray, w) in parts {
                tile.rows[y] |= 1 << x;
                color.push([f16::from_f32(gray); 3]);
                depth.push(w);
            }
            tiles.push(tile);
        }
        let depth = DepthPlane::pack(&tiles, &depth);
        let span = Span { start: 0, end: 1 };
        SampleImage {
            camera: 0,
            span,
            tiles,
            color,
            depth,
            normal: None,
            doubtful: Vec::new(),
            values: Values::default(),
        }
    }

    /// Every sample of an image.
    fn listed(image: &SampleImage) -> Vec<Listed> {
        let depths = image.inverse_depths();
        let of = |sample: crate::samples::Sample| {
            (sample.x, sample.y, image.color[sample.index][0].to_f32(), depths[sample.index])
        };
        image.samples().map(of).collect()
    }

    #[test]
    fn four_samples_of_one_surface_become_their_mean_across_the_borders_of_tiles() {
        let (nearer, mean) = (1.0 + 1.0 / 512.0, 1.0 + 1.0 / 1024.0);
        let fine = image(&[
            (14, 16, 0.0, 1.0),
            (15, 16, 0.5, 1.0),
            (14, 17, 0.25, nearer),
            (15, 17, 0.25, nearer),
            (33, 5, 0.75, 0.25),
        ]);
        assert_eq!(listed(&fine.halved(&LENS)), [(7, 8, 0.25, mean), (16, 2, 0.75, 0.25)]);
    }

    #[test]
    fn surfaces_are_not_mixed_the_larger_stays_and_of_two_as_large_the_nearer() {
        let fine = image(&[
            (0, 0, 0.0, 1.0),
            (1, 0, 1.0, 0.5),
            (0, 1, 0.5, 0.5),
            (4, 4, 0.125, 0.0),
            (5, 4, 0.5, 2.0),
        ]);
        assert_eq!(listed(&fine.halved(&LENS)), [(0, 0, 0.75, 0.5), (2, 2, 0.5, 2.0)]);
    }

    #[test]
    fn a_sample_is_doubtful_only_if_all_that_it_is_made_of_are() {
        let mut fine = image(&[(0, 0, 0.5, 1.0), (1, 0, 0.5, 1.0), (2, 0, 0.5, 1.0)]);
        let mut rows = [0; TILE];
        rows[0] = 0b101;
        fine.doubtful = vec![TileMask { tile: 0, rows }];
        let half = fine.halved(&LENS);
        assert_eq!([0, 1].map(|x| half.is_doubtful(x, 0)), [false, true]);
    }

    #[test]
    fn a_halved_camera_sees_every_point_at_half_its_column_and_row() {
        let intrinsics = Intrinsics { fy: 44.0, cx: 15.0, cy: 9.0, ..Intrinsics::centered(31, 20, 40.0) };
        let camera = Camera { name: "c".into(), intrinsics, world_from_camera: DAffine3::IDENTITY };
        let half = halved_camera(&camera);
        assert_eq!(half.intrinsics.size(), (16, 10));
        let point = glam::DVec3::new(0.3, -0.2, 1.5);
        let [(fine, _), (coarse, _)] = [&camera, &half].map(|camera| camera.project(point).unwrap());
        assert!((coarse * 2.0 - fine).length() < 1e-12);
    }
}
