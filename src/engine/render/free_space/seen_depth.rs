//! What each camera saw, put together again from the kept samples of all of them.
//!
//! Pruning leaves a camera only the samples that no other camera has better. To know up to where its lines of sight are free,
//! the samples of all cameras are carried into it. A sample that was dropped has a witness that is no coarser, so that cells of
//! 2×2 pixels close the cracks between samples of one surface.

use std::ops::Range;

use rayon::prelude::*;

use crate::capture::Camera;
use crate::render::geometry::{FootprintReach, Projector, TileBounds, bounds};
use crate::render::input::{DenseTile, FrameSamples, FrameTile};
use crate::samples::{TILE, halved_camera};
use crate::simd::{self, VectorLoop, whole};

/// One of this many rows of samples is carried: a cell still gets two samples of each surface.
const ROW_STEP: usize = 2;

/// Empty cells around those of a camera, so that points beside its picture are looked up like all others.
pub(crate) const BORDER: usize = 2;

/// Marks corners around which a camera saw nothing: no line of sight is free there, and none is blocked.
pub(super) const UNSEEN: f32 = f32::INFINITY;

/// What one camera saw.
#[derive(Clone, Debug)]
struct CellDepths {
    /// Columns of cells with the border.
    across: usize,
    /// The nearest surface in each cell: the bits of the inverse depth plus one, whose order is that of nearness; 0 where the camera
    /// saw nothing. Empty once nothing is to be added.
    nearest: Vec<u32>,
    free: FreeDepths,
}

/// How far the lines of sight of a camera are free at the corners between its cells: the least inverse depth that was seen in the
/// four cells at each corner.
///
/// The farthest of the four counts, because cells widen surfaces: otherwise the space right beside a silhouette would count as blocked.
#[derive(Clone, Debug)]
pub(super) struct FreeDepths {
    /// Columns of corners, one less than those of cells with the border.
    pub(super) across: usize,
    /// Rows of corners.
    pub(super) down: usize,
    /// Row-major; [`UNSEEN`] where nothing was seen.
    pub(super) farthest: Vec<f32>,
}

/// What each camera saw; `None` for cameras that were not needed yet.
#[derive(Clone, Debug, Default)]
pub(crate) struct SeenDepths {
    cameras: Vec<Option<CellDepths>>,
}

impl SeenDepths {
    /// Whether it is known what these cameras saw.
    pub(crate) fn has(&self, wanted: &[usize]) -> bool {
        wanted.iter().all(|camera| matches!(self.cameras.get(*camera), Some(Some(_))))
    }

    /// Forgets what is needed only to add samples.
    pub(crate) fn finish(&mut self) {
        self.cameras.iter_mut().flatten().for_each(|seen| seen.nearest = Vec::new());
    }

    /// Memory that it takes, bytes.
    pub(crate) fn bytes(&self) -> usize {
        let of = |seen: &CellDepths| 4 * (seen.nearest.len() + seen.free.farthest.len());
        self.cameras.iter().flatten().map(of).sum()
    }

    /// Forgets what all but the wanted cameras saw.
    pub(crate) fn keep(&mut self, wanted: &[usize]) {
        for (camera, seen) in self.cameras.iter_mut().enumerate() {
            *seen = seen.take().filter(|_| wanted.contains(&camera));
        }
    }

    /// Adds what the wanted cameras saw according to some tiles of a frame, and to what was seen `before`, if given.
    pub(crate) fn complete(
        &mut self,
        frame: &FrameSamples<'_>,
        tiles: &Range<usize>,
        before: Option<&Self>,
        wanted: &[usize],
    ) {
        let cameras = &frame.set.cameras;
        self.cameras.resize_with(cameras.len(), || None);
        let missing: Vec<usize> =
            wanted.iter().copied().filter(|camera| self.cameras[*camera].is_none()).collect();
        let share = missing.len().div_ceil(rayon::current_num_threads()).max(1);
        let found: Vec<(usize, CellDepths)> = missing
            .par_chunks(share)
            .flat_map_iter(|missing| {
                let cells: Vec<Camera> =
                    missing.iter().map(|camera| halved_camera(&cameras[*camera])).collect();
                let already = |camera: &usize| before.and_then(|before| before.cameras[*camera].as_ref());
                let seen = missing.iter().zip(&cells);
                let mut seen: Vec<CellDepths> = seen
                    .map(|(camera, cells)| {
                        CellDepths::new(cells, already(camera).map(|seen| &seen.nearest[..]))
                    })
                    .collect();
                carry(frame, tiles, &cells, &mut seen);
                missing.iter().copied().zip(seen).collect::<Vec<_>>()
            })
            .collect();
        for (camera, seen) in found {
            self.cameras[camera] = Some(seen);
        }
    }

    /// How far the lines of sight of a camera are free; `None` if the camera was not needed yet.
    #[inline(always)]
    pub(super) fn free_depths(&self, camera: usize) -> Option<&FreeDepths> {
        self.cameras.get(camera)?.as_ref().map(|seen| &seen.free)
    }
}

/// Carries tiles into some cameras, whose cells `cells` have as pixels.
fn carry(frame: &FrameSamples<'_>, tiles: &Range<usize>, cells: &[Camera], seen: &mut [CellDepths]) {
    let into_cells = |cells| frame.set.cameras.iter().map(|source| Projector::new(source, cells)).collect();
    let projectors: Vec<Vec<Projector>> = cells.iter().map(into_cells).collect();
    let no_reach = FootprintReach { pixels: 0.0, source_pixels: 0.0 };
    let places = cells.iter().zip(&projectors);
    let places = places.map(|(cells, from)| bounds(frame, tiles.clone(), from, cells, no_reach)).collect();
    simd::run(CarryTiles { tiles: frame.tiles(tiles.clone()), bounds: places, projectors, cells, seen });
}

/// Carries tiles into some cameras.
struct CarryTiles<'a, 'b> {
    tiles: &'a [FrameTile<'b>],
    /// For each camera of `seen`, what carries samples of every camera into its cells.
    projectors: Vec<Vec<Projector>>,
    /// For each camera of `seen`, the cells that each tile may touch.
    bounds: Vec<Vec<TileBounds>>,
    /// The cameras of the cells.
    cells: &'a [Camera],
    seen: &'a mut [CellDepths],
}

impl VectorLoop for CarryTiles<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let mut dense = DenseTile::new();
        for (nth, tile) in self.tiles.iter().enumerate() {
            dense.unpack(tile);
            let views = self.seen.iter_mut().zip(&self.projectors).zip(self.cells).zip(&self.bounds);
            for (((seen, projectors), cells), _) in views.filter(|(_, bounds)| !bounds[nth].is_empty()) {
                let (width, height) = cells.intrinsics.size();
                seen.add(tile, &dense, &projectors[tile.camera as usize], (width as f32, height as f32));
            }
        }
        for seen in self.seen {
            seen.find_free();
        }
    }
}

impl CellDepths {
    /// A camera, by that of its cells, that saw some nearest surfaces or nothing; how far its lines of sight are free is not found yet.
    fn new(cells: &Camera, nearest: Option<&[u32]>) -> Self {
        let (width, height) = cells.intrinsics.size();
        let (across, down) = (width + 2 * BORDER, height + 2 * BORDER);
        let corners = (across - 1) * (down - 1);
        let free = FreeDepths { across: across - 1, down: down - 1, farthest: vec![0.0; corners] };
        Self { across, nearest: nearest.map_or_else(|| vec![0; across * down], <[u32]>::to_vec), free }
    }

    /// Adds the samples of a tile; `size` is that of the picture in cells.
    #[inline(always)]
    fn add(&mut self, tile: &FrameTile<'_>, dense: &DenseTile, projector: &Projector, size: (f32, f32)) {
        let across = self.across as u32;
        for row in (0..TILE).step_by(ROW_STEP).filter(|row| tile.rows[*row] != 0) {
            let w = dense.row(row);
            let ray = projector.ray(tile.origin.0 as f32, (tile.origin.1 as usize + row) as f32);
            let projected = projector.row(ray, w);
            let (mut cells, mut bits) = ([0_u32; TILE], [0_u32; TILE]);
            for i in 0..TILE {
                let (u, v, reciprocal) = (projected.u[i], projected.v[i], projected.reciprocal[i]);
                let inside = (reciprocal > 0.0)
                    & (w[i] >= 0.0)
                    & (u >= 0.0)
                    & (v >= 0.0)
                    & (u < size.0)
                    & (v < size.1);
                let (column, row) = (whole(u.floor()) + BORDER as u32, whole(v.floor()) + BORDER as u32);
                cells[i] = if inside { row.wrapping_mul(across).wrapping_add(column) } else { 0 };
                bits[i] = if inside { (w[i] * reciprocal).to_bits() + 1 } else { 0 };
            }
            for i in 0..TILE {
                let nearest = &mut self.nearest[cells[i] as usize];
                *nearest = (*nearest).max(bits[i]);
            }
        }
    }

    /// Sets the free depths from the nearest surfaces.
    #[inline(always)]
    fn find_free(&mut self) {
        let Self { across, nearest, free } = self;
        let corners = free.across;
        for (row, farthest) in free.farthest.chunks_exact_mut(corners).enumerate() {
            let above = &nearest[row * *across..][..=corners];
            let below = &nearest[(row + 1) * *across..][..=corners];
            let left = above.iter().zip(below);
            let right = above[1..].iter().zip(&below[1..]);
            for ((farthest, left), right) in farthest.iter_mut().zip(left).zip(right) {
                let left = seen_at(*left.0).min(seen_at(*left.1));
                let right = seen_at(*right.0).min(seen_at(*right.1));
                *farthest = left.min(right);
            }
        }
    }
}

/// The inverse depth of a cell; [`UNSEEN`] where nothing was seen.
#[inline(always)]
fn seen_at(bits: u32) -> f32 {
    if bits == 0 { UNSEEN } else { f32::from_bits(bits - 1) }
}
