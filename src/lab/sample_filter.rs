//! Part of a sample image.

use overlook_engine::samples::{DepthPlane, Sample, SampleImage, SampleTile, Span, TILE, TileMask};

/// The samples of an image that `keep` accepts, given each and its inverse depth, as an image of `span`.
pub(super) fn samples_where(
    image: &SampleImage,
    span: Span,
    keep: impl Fn(&Sample, f32) -> bool,
) -> SampleImage {
    let mut part = SampleImage {
        camera: image.camera,
        span,
        tiles: Vec::new(),
        color: Vec::new(),
        depth: DepthPlane::default(),
        normal: image.normal.as_ref().map(|_| Vec::new()),
        doubtful: Vec::new(),
    };
    let inverse_depths = image.inverse_depths();
    let mut kept_depths = Vec::new();
    for sample in image.samples().filter(|sample| keep(sample, inverse_depths[sample.index])) {
        let (tile_x, tile_y) = ((sample.x / TILE) as u16, (sample.y / TILE) as u16);
        if part.tiles.last().is_none_or(|tile| (tile.tile_x, tile.tile_y) != (tile_x, tile_y)) {
            part.tiles.push(SampleTile { tile_x, tile_y, first: kept_depths.len() as u32, rows: [0; TILE] });
        }
        if let Some(tile) = part.tiles.last_mut() {
            tile.rows[sample.y % TILE] |= 1 << (sample.x % TILE);
        }
        if !image.doubtful.is_empty() && image.is_doubtful(sample.x, sample.y) {
            let tile = part.tiles.len() as u32 - 1;
            if part.doubtful.last().is_none_or(|mask| mask.tile != tile) {
                part.doubtful.push(TileMask { tile, rows: [0; TILE] });
            }
            if let Some(mask) = part.doubtful.last_mut() {
                mask.rows[sample.y % TILE] |= 1 << (sample.x % TILE);
            }
        }
        part.color.push(image.color[sample.index]);
        kept_depths.push(inverse_depths[sample.index]);
        if let (Some(part), Some(normals)) = (&mut part.normal, &image.normal) {
            part.push(normals[sample.index]);
        }
    }
    part.depth = DepthPlane::pack(&part.tiles, &kept_depths);
    part
}
