//! From dense layers with verdicts to sparse sample images.

use super::depth_plane::DepthPlane;
use super::layer::Layer;
use super::pruning::Decided;
use super::{OctNormal, SampleImage, SampleTile, Span, TILE};

/// The kept samples of one camera over one span; `None` where nothing was kept.
#[must_use]
pub fn pack(
    camera: usize,
    span: Span,
    layer: &Layer,
    decided: &Decided,
    normals: bool,
) -> Option<SampleImage> {
    let tiles_across = layer.width.div_ceil(TILE);
    let tiles_down = layer.height().div_ceil(TILE);
    let mut masks = vec![[0_u16; TILE]; tiles_across * tiles_down];
    for (&pixel, verdict) in decided.pixels.iter().zip(&decided.verdicts) {
        if verdict.is_kept() {
            let (x, y) = (pixel as usize % layer.width, pixel as usize / layer.width);
            masks[(y / TILE) * tiles_across + x / TILE][y % TILE] |= 1 << (x % TILE);
        }
    }
    let (mut tiles, mut color, mut inverse_depth) = (Vec::new(), Vec::new(), Vec::new());
    let mut normal = normals.then(Vec::new);
    for (index, rows) in masks.into_iter().enumerate() {
        if rows == [0; TILE] {
            continue;
        }
        let tile = SampleTile {
            tile_x: (index % tiles_across) as u16,
            tile_y: (index / tiles_across) as u16,
            first: inverse_depth.len() as u32,
            rows,
        };
        tiles.push(tile);
        for (row, &mask) in rows.iter().enumerate() {
            for column in (0..TILE).filter(|column| mask >> column & 1 == 1) {
                let x = tile.tile_x as usize * TILE + column;
                let pixel = (tile.tile_y as usize * TILE + row) * layer.width + x;
                color.push(layer.color[pixel]);
                inverse_depth.push(layer.inverse_depth[pixel]);
                if let Some(normal) = &mut normal {
                    normal.push(OctNormal::encode(layer.normal[pixel]));
                }
            }
        }
    }
    color.shrink_to_fit();
    let depth = DepthPlane::pack(&tiles, &inverse_depth);
    let image = SampleImage { camera: camera as u32, span, tiles, color, depth, normal };
    (!image.is_empty()).then_some(image)
}
