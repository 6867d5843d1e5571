//! From dense layers with verdicts to sparse sample images.

use std::sync::atomic::{AtomicU8, Ordering};

use super::decision::LevelVerdicts;
use super::pass::KEPT;
use crate::capture::Values;
use crate::preprocess::agreement::{AgreedSample, Consensus};
use crate::preprocess::layers::CameraLayer;
use crate::preprocess::temporal::SpanLevel;
use crate::samples::{DepthPlane, OctNormal, SampleImage, SampleTile, Span, TILE, TileMask};

/// Which pixels of a picture are kept: for each tile, a mask of columns per row.
#[derive(Clone, Debug)]
pub struct Masks {
    tiles_across: usize,
    rows: Vec<[u16; TILE]>,
}

impl Masks {
    fn none(layer: &CameraLayer) -> Self {
        let tiles_across = layer.width.div_ceil(TILE);
        Self { tiles_across, rows: vec![[0; TILE]; tiles_across * layer.height().div_ceil(TILE)] }
    }

    /// The samples of `layer` that were decided to be kept.
    pub(crate) fn decided(layer: &CameraLayer, decided: &LevelVerdicts) -> Self {
        let mut masks = Self::none(layer);
        for (&pixel, verdict) in decided.pixels.iter().zip(&decided.verdicts) {
            if verdict.is_kept() {
                let (x, y) = (pixel as usize % layer.width, pixel as usize / layer.width);
                masks.rows[(y / TILE) * masks.tiles_across + x / TILE][y % TILE] |= 1 << (x % TILE);
            }
        }
        masks
    }

    /// The samples of one level of `layer` whose status is that they are kept.
    pub(crate) fn at_level(layer: &CameraLayer, level: SpanLevel, statuses: &[AtomicU8]) -> Self {
        let mut masks = Self::none(layer);
        for (y, rows) in
            layer.level.chunks(layer.width.max(1)).zip(statuses.chunks(layer.width.max(1))).enumerate()
        {
            let tiles = &mut masks.rows[y / TILE * masks.tiles_across..][..masks.tiles_across];
            for ((tile, levels), statuses) in
                tiles.iter_mut().zip(rows.0.chunks(TILE)).zip(rows.1.chunks(TILE))
            {
                let mut mask = 0;
                for (x, (&found, status)) in levels.iter().zip(statuses).enumerate() {
                    let is_kept = (found == level) & (status.load(Ordering::Relaxed) == KEPT);
                    mask |= u16::from(is_kept) << x;
                }
                tile[y % TILE] = mask;
            }
        }
        masks
    }

    fn count(&self) -> usize {
        self.rows.as_flattened().iter().map(|mask| mask.count_ones() as usize).sum()
    }
}

/// The pixels of a tile's samples in a picture with `width` columns, in their order.
fn pixels_of(tile: &SampleTile, width: usize) -> Vec<u32> {
    let mut pixels = Vec::with_capacity(tile.count());
    for (row, &mask) in tile.rows.iter().enumerate() {
        let start = (tile.tile_y as usize * TILE + row) * width + tile.tile_x as usize * TILE;
        let columns = (0..TILE).filter(|column| mask >> column & 1 == 1);
        pixels.extend(columns.map(|column| (start + column) as u32));
    }
    pixels
}

/// The kept samples of one camera over one span, with what the cameras agree on where there is any; `None` where nothing was kept.
#[must_use]
pub fn pack(
    camera: usize,
    span: Span,
    layer: &CameraLayer,
    masks: Masks,
    consensus: Option<&Consensus<'_>>,
    normals: bool,
) -> Option<SampleImage> {
    let count = masks.count();
    if count == 0 {
        return None;
    }
    let (mut tiles, mut doubtful) = (Vec::new(), Vec::new());
    let (mut color, mut inverse_depth) = (Vec::with_capacity(count), Vec::with_capacity(count));
    let mut normal = normals.then(|| Vec::with_capacity(count));
    let mut values = Values::default();
    for (index, rows) in masks.rows.into_iter().enumerate() {
        if rows == [0; TILE] {
            continue;
        }
        let tile = SampleTile {
            tile_x: (index % masks.tiles_across) as u16,
            tile_y: (index / masks.tiles_across) as u16,
            first: inverse_depth.len() as u32,
            rows,
        };
        let pixels = pixels_of(&tile, layer.width);
        let samples = match consensus {
            Some(consensus) => consensus.samples(camera, &pixels),
            None => pixels.iter().map(|pixel| AgreedSample::recorded(layer, *pixel as usize)).collect(),
        };
        let mut doubtful_rows = [0; TILE];
        for (&pixel, sample) in pixels.iter().zip(samples) {
            color.push(sample.color);
            inverse_depth.push(sample.inverse_depth);
            values.push(layer.values.of(pixel as usize));
            if sample.is_doubtful {
                let (x, y) = (pixel as usize % layer.width, pixel as usize / layer.width);
                doubtful_rows[y % TILE] |= 1 << (x % TILE);
            }
            if let Some(normal) = &mut normal {
                normal.push(OctNormal::encode(layer.normal[pixel as usize]));
            }
        }
        if doubtful_rows != [0; TILE] {
            doubtful.push(TileMask { tile: tiles.len() as u32, rows: doubtful_rows });
        }
        tiles.push(tile);
    }
    let depth = DepthPlane::pack(&tiles, &inverse_depth);
    Some(SampleImage { camera: camera as u32, span, tiles, color, depth, normal, doubtful, values })
}
