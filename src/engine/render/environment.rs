//! The sky, continued into directions that no camera saw.
//!
//! What is at infinity depends on direction alone. Its colors are summed up in the cells of grids over the cube around the unit
//! sphere, each grid half as fine as the one before. Where a grid knows little, its cells are filled from the coarser one, so that a
//! direction is looked up in the finest grid alone. Grids in space have no seams, unlike the faces of a cube or the poles of a map. Only
//! cells that the sphere goes through are kept.
//!
//! Source: pull and push with weights that saturate, Gortler et al., *The Lumigraph*, SIGGRAPH 1996, §3.4. What differs: the grids are
//! three-dimensional.

use std::ops::Range;
use std::sync::{Arc, LazyLock};

use glam::Vec3;
use half::f16;
use rayon::prelude::*;

use super::geometry::rays_in_world;
use super::input::{DenseTile, FrameSamples};
use super::vantage::{NO_IMAGE, Picture, Vantage};
use crate::capture::Camera;
use crate::error::Result;
use crate::samples::{SampleSet, TILE};

/// Grids, from the coarsest, of one cell, to the finest, whose cells are some two degrees wide each.
const LEVELS: usize = 7;

/// The level of the finest grid.
const FINEST: usize = LEVELS - 1;

/// Cells count as touched by the sphere within this distance of it: directions are rounded.
const ROUNDING: f32 = 1e-5;

/// The grids, coarsest first.
static GRIDS: LazyLock<[SphereGrid; LEVELS]> = LazyLock::new(|| std::array::from_fn(SphereGrid::new));

/// A grid over the cube around the unit sphere: which of its cells the sphere touches.
struct SphereGrid {
    /// Cells along each side.
    side: usize,
    /// The number of each cell that is touched, by z, y and x; their count for all others.
    numbers: Vec<u32>,
    /// The touched cells, by number: column, row and layer.
    cells: Vec<[usize; 3]>,
}

/// A cell with fewer samples than this takes the missing share from the coarser grid: a few samples at the rim of what was seen may be
/// blended with a surface.
const FULL_COUNT: f32 = 16.0;

/// Weight of a sample with a missing neighbor. Pruning may have dropped the neighbor from a surface whose color this sample is blended
/// with.
const BESIDE_MISSING: f32 = 1.0 / 64.0;

/// Surfaces in one direction count where they are at least this share as far off as the farthest.
const FAR_SHARE: f64 = 0.8;

/// Weight of all surfaces in a cell: so small that the sky wins within some sixteen degrees of where it was seen.
const WEIGHT_OF_SURFACES: f32 = FULL_COUNT / 64.0;

/// Weighted sums of red, green and blue, and the sum of weights.
type CellSum = [f32; 4];

/// The colors of samples at infinity, by direction.
#[derive(Clone, Debug)]
pub(crate) struct SkySums {
    /// The touched cells of the finest grid; empty if no sample counts.
    cells: Vec<CellSum>,
}

/// Red, green, blue and 1; zeros in cells that only rounding lets the sphere touch.
type CellColor = [f32; 4];

/// The color at infinity in every direction.
#[derive(Clone, Debug)]
pub(crate) struct Environment {
    /// The touched cells of the finest grid, and zeros for all others.
    cells: Vec<CellColor>,
}

impl SkySums {
    /// The samples at infinity among some tiles of a frame, and those of `before`, if given; `before` itself where there are none.
    pub(crate) fn new(
        frame: &FrameSamples<'_>,
        tiles: Range<usize>,
        before: Option<&Arc<Self>>,
    ) -> Arc<Self> {
        let rays: Vec<[Vec3; 3]> =
            frame.set.cameras.iter().map(|camera| rays_in_world(camera, 0.5)).collect();
        let mut sums: Option<Vec<CellSum>> = None;
        let mut dense = DenseTile::new();
        for tile in frame.tiles(tiles).iter().filter(|tile| tile.depths.bounds().0 == 0.0) {
            dense.unpack(tile);
            for row in 0..TILE {
                for column in 0..TILE {
                    let weight = weight_of_sky(dense.rows(), column, row);
                    if weight == 0.0 {
                        continue;
                    }
                    let cells = sums.get_or_insert_with(|| {
                        let mut cells = before.map(|before| before.cells.clone()).unwrap_or_default();
                        cells.resize(GRIDS[FINEST].cells.len(), [0.0; 4]);
                        cells
                    });
                    let [first, across, down] = rays[tile.camera as usize];
                    let (x, y) = (tile.origin.0 as f32 + column as f32, tile.origin.1 as f32 + row as f32);
                    let direction = (first + across * x + down * y).normalize_or_zero();
                    let Some(cell) = cell_of(direction).map(|cell| &mut cells[cell]) else { continue };
                    let [red, green, blue] = tile.color(tile.rank(column, row));
                    for (sum, part) in cell.iter_mut().zip([red, green, blue, 1.0]) {
                        *sum += weight * part;
                    }
                }
            }
        }
        match (sums, before) {
            (None, Some(before)) => before.clone(),
            (sums, _) => Arc::new(Self { cells: sums.unwrap_or_default() }),
        }
    }

    /// Memory that it takes, bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self.cells.as_slice())
    }
}

impl Environment {
    /// From samples at infinity; `None` if none of them counts.
    pub(crate) fn new(sums: &SkySums) -> Option<Self> {
        if sums.cells.is_empty() {
            return None;
        }
        Some(Self { cells: filled(&sums.cells, FINEST) })
    }

    /// The color in a direction of length 1, linear Rec.709.
    pub(crate) fn color(&self, direction: Vec3) -> [f32; 3] {
        interpolated(&self.cells, FINEST, direction)
    }

    /// Reads colors of directions that lie close to each other.
    pub(super) fn reader(&self) -> SkyReader<'_> {
        SkyReader::new(&self.cells, FINEST)
    }
}

/// Linear Rec.709 at infinity in some directions of length 1 at a frame of a set; `None` where none of its samples counts.
///
/// # Errors
/// As [`FrameSamples::at`].
pub(crate) fn sky_map(set: &SampleSet, frame: usize, directions: &[Vec3]) -> Result<Option<Vec<[f32; 3]>>> {
    let samples = FrameSamples::at(set, frame)?;
    let environment = Environment::new(&SkySums::new(&samples, 0..samples.tile_count(), None));
    Ok(environment.map(|sky| directions.iter().map(|direction| sky.color(*direction)).collect()))
}

/// As [`sky_map`], but far from where the sky was seen, in the colors of the farthest surfaces that hide it. Those farther off than
/// `farthest`, in world units, do not count.
///
/// # Errors
/// As [`FrameSamples::at`].
pub(crate) fn surroundings(
    set: &SampleSet,
    frame: usize,
    farthest: f64,
    directions: &[Vec3],
) -> Result<Option<Vec<[f32; 3]>>> {
    let samples = FrameSamples::at(set, frame)?;
    let sky = SkySums::new(&samples, 0..samples.tile_count(), None);
    if sky.cells.is_empty() {
        return Ok(None);
    }
    // By the direction from the camera, as the sky's.
    let surfaces = || {
        set.images_at(frame).filter(|image| !image.is_empty()).flat_map(|image| {
            let camera = &set.cameras[image.camera as usize];
            let near = image.placed(camera).filter(|placed| placed.depth < farthest);
            near.filter_map(move |placed| {
                let sight = placed.point_in_world - camera.position_in_world();
                let cell = cell_of(sight.as_vec3().normalize_or_zero())?;
                Some((cell, sight.length(), image.color[placed.sample.index]))
            })
        })
    };
    let mut distances = vec![0.0_f64; sky.cells.len()];
    for (cell, distance, _) in surfaces() {
        distances[cell] = distances[cell].max(distance);
    }
    let mut sums = vec![[0.0; 4]; sky.cells.len()];
    for (cell, _, color) in surfaces().filter(|(cell, distance, _)| *distance > FAR_SHARE * distances[*cell])
    {
        let [red, green, blue] = color.map(f16::to_f32);
        sums[cell].iter_mut().zip([red, green, blue, 1.0]).for_each(|(sum, part)| *sum += part);
    }
    let joined = |(sky, of_surfaces): (&CellSum, &CellSum)| {
        let weight = WEIGHT_OF_SURFACES / of_surfaces[3].max(1.0);
        std::array::from_fn(|channel| sky[channel] + weight * of_surfaces[channel])
    };
    let cells: Vec<CellSum> = sky.cells.iter().zip(&sums).map(joined).collect();
    let environment = Environment { cells: filled(&cells, FINEST) };
    Ok(Some(directions.iter().map(|direction| environment.color(*direction)).collect()))
}

/// How many pixels of a picture that no sample of `set` reached show what cameras saw at infinity in that direction. It is decided by
/// the scene and the direction, whatever else the picture shows: what only looks like a background counts as unseen.
///
/// # Errors
/// Those of reading the samples of the frame.
pub fn background_holes(picture: &Picture, set: &SampleSet, vantage: &Vantage) -> Result<u64> {
    let pixels = picture.image.as_slice().iter().zip(picture.inverse_depth.as_slice()).enumerate();
    let mut shown = pixels.filter(|(_, (image, depth))| **image == NO_IMAGE && **depth == 0.0).peekable();
    // Most pictures show none, and every live picture asks.
    if shown.peek().is_none() {
        return Ok(0);
    }
    let samples = FrameSamples::at(set, vantage.frame)?;
    let sums = SkySums::new(&samples, 0..samples.tile_count(), None);
    if sums.cells.is_empty() {
        return Ok(0);
    }
    let (directions, width) = (PixelDirections::new(&vantage.camera), picture.image.width().max(1));
    let is_seen = |at: usize| {
        let cell = cell_of(directions.at((at % width, at / width)));
        cell.is_some_and(|cell| sums.cells[cell][3] > 0.0)
    };
    let seen = shown.filter(|(at, _)| is_seen(*at));
    Ok(seen.count() as u64)
}

/// World-space directions of a camera's pixels.
#[derive(Debug, Default)]
pub(crate) struct PixelDirections([Vec3; 3]);

impl PixelDirections {
    pub(crate) fn new(camera: &Camera) -> Self {
        Self(rays_in_world(camera, 0.5))
    }

    /// The direction of a pixel's center, of length 1.
    pub(crate) fn at(&self, (x, y): (usize, usize)) -> Vec3 {
        self.to_depth_1((x, y)).normalize_or_zero()
    }

    /// The same, as long as it is to planar depth 1.
    pub(crate) fn to_depth_1(&self, (x, y): (usize, usize)) -> Vec3 {
        let [first, across, down] = self.0;
        first + across * x as f32 + down * y as f32
    }
}

/// Weight of a sample, given the inverse depths of its tile: zero unless it is at infinity with no surface beside it, else its
/// color may be blended with one.
fn weight_of_sky(rows: &[[f32; TILE]], column: usize, row: usize) -> f32 {
    if rows[row][column] != 0.0 {
        return 0.0;
    }
    let columns = column.saturating_sub(1)..(column + 2).min(TILE);
    let around =
        rows[row.saturating_sub(1)..(row + 2).min(TILE)].iter().flat_map(|row| &row[columns.clone()]);
    let (mut nearest, mut farthest) = (0.0_f32, 0.0_f32);
    for w in around {
        (nearest, farthest) = (nearest.max(*w), farthest.min(*w));
    }
    if nearest > 0.0 {
        0.0
    } else if farthest < 0.0 {
        BESIDE_MISSING
    } else {
        1.0
    }
}

/// The number of the cell of the finest grid that a direction of length 1 is in; `None` for what has another length.
fn cell_of(direction: Vec3) -> Option<usize> {
    let grid = &GRIDS[FINEST];
    let index = |part: f32| (((part + 1.0) * (0.5 * grid.side as f32)) as usize).min(grid.side - 1);
    let number = grid.number([index(direction.x), index(direction.y), index(direction.z)]);
    (number < grid.cells.len()).then_some(number)
}

impl SphereGrid {
    /// The grid of a level.
    fn new(level: usize) -> Self {
        let side = 1 << level;
        let index_of = |cell: usize| [cell % side, cell / side % side, cell / side / side];
        let is_touched = |cell: &usize| touches_sphere(index_of(*cell), side, ROUNDING);
        let touched: Vec<usize> = (0..side * side * side).filter(is_touched).collect();
        let mut numbers = vec![touched.len() as u32; side * side * side];
        for (number, cell) in touched.iter().enumerate() {
            numbers[*cell] = number as u32;
        }
        Self { side, numbers, cells: touched.into_iter().map(index_of).collect() }
    }

    /// The number of the cell in a column, row and layer; the count of touched cells if it is none of them.
    #[inline(always)]
    fn number(&self, [x, y, z]: [usize; 3]) -> usize {
        self.numbers[(z * self.side + y) * self.side + x] as usize
    }
}

/// The sums of the grid of a level, from those of the next finer one.
fn halved(finer: &[CellSum], level: usize) -> Vec<CellSum> {
    let below = &GRIDS[level + 1];
    let sum_of = |[x, y, z]: &[usize; 3]| {
        let mut sum = [0.0; 4];
        for corner in 0..8 {
            let part = below.number([2 * x + (corner & 1), 2 * y + (corner >> 1 & 1), 2 * z + (corner >> 2)]);
            if let Some(part) = finer.get(part) {
                (0..4).for_each(|channel| sum[channel] += part[channel]);
            }
        }
        sum
    };
    GRIDS[level].cells.par_iter().with_min_len(512).map(sum_of).collect()
}

/// The colors of the grid of a level, and zeros at the end: those of its samples where it has enough, else filled from the coarser grid.
fn filled(sums: &[CellSum], level: usize) -> Vec<CellColor> {
    let coarser = level.checked_sub(1).map(|coarser| (filled(&halved(sums, coarser), coarser), coarser));
    let side = GRIDS[level].side;
    let color_of = |(index, sum): (&[usize; 3], &CellSum)| {
        let [red, green, blue, count] = *sum;
        if count == 0.0 && !touches_sphere(*index, side, 0.0) {
            return [0.0; 4];
        }
        let full = if coarser.is_none() { 1.0 } else { (count / FULL_COUNT).min(1.0) };
        let own = if count > 0.0 { [red, green, blue].map(|sum| sum / count) } else { [0.0; 3] };
        let around = match &coarser {
            Some((cells, level)) if full < 1.0 => {
                interpolated(cells, *level, center_of(*index, side).normalize_or_zero())
            }
            _ => [0.0; 3],
        };
        let [red, green, blue] =
            [0, 1, 2].map(|channel| full * own[channel] + (1.0 - full) * around[channel]);
        [red, green, blue, 1.0]
    };
    let mut colors = Vec::with_capacity(sums.len() + 1);
    GRIDS[level].cells.par_iter().zip(sums).with_min_len(512).map(color_of).collect_into_vec(&mut colors);
    colors.push([0.0; 4]);
    colors
}

/// The center of a cell of a grid with `side` cells along each side.
fn center_of(index: [usize; 3], side: usize) -> Vec3 {
    let half_width = 1.0 / side as f32;
    Vec3::from(index.map(|index| (2 * index + 1) as f32 * half_width - 1.0))
}

/// Whether the unit sphere goes through a cell of such a grid, or passes it within `distance`.
fn touches_sphere(index: [usize; 3], side: usize, distance: f32) -> bool {
    let (center, half_width) = (center_of(index, side), 1.0 / side as f32);
    let nearest = (center.abs() - half_width).max(Vec3::ZERO).length();
    let farthest = (center.abs() + half_width).length();
    nearest <= 1.0 + distance && 1.0 - distance <= farthest
}

/// The color in a direction of length 1, in the grid of a level.
fn interpolated(cells: &[CellColor], level: usize, direction: Vec3) -> [f32; 3] {
    SkyReader::new(cells, level).color(direction)
}

/// Reads the colors of one direction after the other. Where they lie between the same cells as the last, these are not looked up again.
pub(super) struct SkyReader<'a> {
    cells: &'a [CellColor],
    grid: &'static SphereGrid,
    /// Column, row and layer of the first of the cells that the last direction was between.
    first: Vec3,
    /// Their colors.
    corners: [CellColor; 8],
}

impl<'a> SkyReader<'a> {
    fn new(cells: &'a [CellColor], level: usize) -> Self {
        Self { cells, grid: &GRIDS[level], first: Vec3::NAN, corners: [[0.0; 4]; 8] }
    }

    /// The color in a direction of length 1: trilinear, among the cells that touch the sphere.
    #[inline]
    pub(super) fn color(&mut self, direction: Vec3) -> [f32; 3] {
        let at = (direction + Vec3::ONE) * (0.5 * self.grid.side as f32) - Vec3::splat(0.5);
        let first = at.floor();
        if first != self.first {
            self.look_up(first);
        }
        let share = at - first;
        let [a, b, c] = [share.x, share.y, share.z].map(|share| [1.0 - share, share]);
        let mut sum = [0.0; 4];
        for (corner, cell) in self.corners.iter().enumerate() {
            let weight = a[corner & 1] * b[corner >> 1 & 1] * c[corner >> 2];
            for channel in 0..4 {
                sum[channel] += weight * cell[channel];
            }
        }
        [sum[0] / sum[3], sum[1] / sum[3], sum[2] / sum[3]]
    }

    /// Reads the cells from one on.
    fn look_up(&mut self, first: Vec3) {
        self.first = first;
        let last = self.grid.side as i32 - 1;
        let ends =
            first.to_array().map(|index| [index, index + 1.0].map(|at| (at as i32).clamp(0, last) as usize));
        for (corner, cell) in self.corners.iter_mut().enumerate() {
            let at = [ends[0][corner & 1], ends[1][corner >> 1 & 1], ends[2][corner >> 2]];
            *cell = self.cells[self.grid.number(at)];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The environment of samples with these directions and colors, and the number of each.
    fn environment_of(samples: impl Iterator<Item = (Vec3, [f32; 3], f32)>) -> Environment {
        let mut cells = vec![[0.0; 4]; GRIDS[FINEST].cells.len()];
        for (direction, [red, green, blue], count) in samples {
            let cell = &mut cells[cell_of(direction).unwrap()];
            for (sum, part) in cell.iter_mut().zip([red, green, blue, 1.0]) {
                *sum += count * part;
            }
        }
        Environment::new(&SkySums { cells }).unwrap()
    }

    /// The environment of directions and colors that were seen often.
    fn environment(samples: impl Iterator<Item = (Vec3, [f32; 3])>) -> Environment {
        environment_of(samples.map(|(direction, color)| (direction, color, FULL_COUNT)))
    }

    /// Directions all over the sphere, evenly.
    fn directions(count: usize) -> impl Iterator<Item = Vec3> {
        (0..count).map(move |nth| {
            let z = 1.0 - (2 * nth + 1) as f32 / count as f32;
            let around = nth as f32 * 2.399_963_2;
            let radius = (1.0 - z * z).sqrt();
            Vec3::new(radius * around.cos(), radius * around.sin(), z)
        })
    }

    /// A color that changes smoothly with direction.
    fn smooth(direction: Vec3) -> [f32; 3] {
        (0.5 + 0.3 * direction).to_array()
    }

    fn difference(a: [f32; 3], b: [f32; 3]) -> f32 {
        (0..3).map(|channel| (a[channel] - b[channel]).abs()).fold(0.0, f32::max)
    }

    #[test]
    fn a_patch_of_one_color_goes_on_in_all_directions() {
        let color = [0.25, 0.5, 0.75];
        for toward in [Vec3::X, Vec3::NEG_Y, Vec3::new(0.6, 0.0, 0.8), Vec3::ONE.normalize_or_zero()] {
            let patch = directions(20_000).filter(|direction| direction.dot(toward) > 0.97);
            let sky = environment(patch.map(|direction| (direction, color)));
            for direction in directions(2000).chain([toward, -toward, Vec3::X, Vec3::NEG_X, Vec3::Z]) {
                let found = sky.color(direction);
                assert!(difference(found, color) < 1e-5, "{direction}: {found:?}");
            }
        }
    }

    #[test]
    fn a_few_samples_of_another_color_at_the_rim_of_what_was_seen_do_not_go_on() {
        let (bright, dark, toward) = ([0.5; 3], [0.0; 3], Vec3::new(0.6, 0.0, 0.8));
        let patch = || directions(20_000).filter(|direction| direction.dot(toward) > 0.9);
        let rim = || patch().filter(|direction| direction.dot(toward) < 0.92).step_by(40);
        let seen = || patch().map(|direction| (direction, bright, FULL_COUNT));
        let beyond: Vec<Vec3> =
            rim().map(|direction| (direction - 0.15 * toward).normalize_or_zero()).collect();
        let few = |count: f32| {
            let blended = beyond.iter().map(|direction| (*direction, dark, count));
            let sky = environment_of(seen().chain(blended));
            beyond.iter().map(|direction| difference(sky.color(*direction), bright)).fold(0.0, f32::max)
        };
        assert!(few(1.0) < 0.1 && few(BESIDE_MISSING) < 0.01, "{} {}", few(1.0), few(BESIDE_MISSING));
        assert!(few(FULL_COUNT) > 0.25, "many are believed: {}", few(FULL_COUNT));
    }

    #[test]
    fn samples_of_the_sky_count_little_beside_missing_ones_and_nothing_beside_a_surface() {
        let (surface, missing) = (1.0, -1.0);
        let mut rows = [[0.0_f32; TILE]; TILE];
        (rows[3][3], rows[10][10]) = (surface, missing);
        let weight = |column: usize, row: usize| weight_of_sky(&rows, column, row);
        assert_eq!([weight(3, 3), weight(4, 4), weight(10, 10)], [0.0; 3]);
        assert_eq!([weight(11, 9), weight(9, 10)], [BESIDE_MISSING; 2]);
        assert_eq!([weight(6, 6), weight(0, 0), weight(15, 15)], [1.0; 3]);
    }

    #[test]
    fn a_sky_that_was_seen_everywhere_comes_back() {
        let sky = environment(directions(200_000).map(|direction| (direction, smooth(direction))));
        for direction in directions(3000).chain([Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE.normalize_or_zero()]) {
            let off = difference(sky.color(direction), smooth(direction));
            // A cell is 1/32 wide, and of those around a direction only some hold samples.
            assert!(off < 0.3 / 32.0, "{direction}: off by {off}");
        }
    }

    #[test]
    fn no_seam_runs_along_the_axes_and_the_edges_of_a_cube() {
        // Seen on one side alone, so that coarse grids are used as well.
        let seen = directions(40_000).filter(|direction| direction.x + 0.3 * direction.z > 0.4);
        let sky = environment(seen.map(|direction| (direction, smooth(direction))));
        let step = 1e-4;
        let corners =
            [Vec3::X, Vec3::Y, Vec3::NEG_Z, Vec3::new(1.0, 1.0, 0.0), Vec3::new(0.0, 1.0, -1.0), Vec3::ONE];
        let mut worst = 0.0_f32;
        for middle in corners {
            for across in [Vec3::X, Vec3::Y, Vec3::Z] {
                for nth in -40..40 {
                    let at = |nth: i32| {
                        (middle.normalize_or_zero() + across * (nth as f32 * step)).normalize_or_zero()
                    };
                    worst = worst.max(difference(sky.color(at(nth)), sky.color(at(nth + 1))));
                }
            }
        }
        assert!(worst < 2e-3, "a step of {worst} within {step} radians");
    }

    #[test]
    fn without_samples_there_is_no_environment() {
        assert!(Environment::new(&SkySums { cells: Vec::new() }).is_none());
    }
}
