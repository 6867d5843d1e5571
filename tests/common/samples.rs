//! Sample sets made by hand, pixel by pixel.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};
use half::f16;
use overlook_engine::capture::{Camera, Intrinsics};
use overlook_engine::samples::{DepthPlane, SampleImage, SampleSet, SampleTile, Span, TILE};
use overlook_engine::settings::Settings;

/// A camera at `eye` that looks along +z with y down, its focal length being its width: angles are simple ratios.
pub(crate) fn plain_camera(name: &str, eye: DVec3, width: u32, height: u32) -> Camera {
    let focal = f64::from(width.max(1));
    let intrinsics = Intrinsics::centered(width, height, focal);
    Camera {
        name: name.to_owned(),
        intrinsics,
        world_from_camera: DAffine3::from_mat3_translation(DMat3::IDENTITY, eye),
    }
}

/// What `camera` kept of one frame: linear color and inverse depth of each pixel, or nothing.
pub(crate) fn samples(
    camera: Camera,
    pixel: impl Fn(usize, usize) -> Option<([f32; 3], f32)>,
) -> Arc<SampleSet> {
    let (width, height) = camera.intrinsics.size();
    let mut inverse_depths = Vec::new();
    let mut image = SampleImage {
        camera: 0,
        span: Span { start: 0, end: 1 },
        tiles: Vec::new(),
        color: Vec::new(),
        depth: DepthPlane::default(),
        normal: None,
        doubtful: Vec::new(),
        values: overlook_engine::capture::Values::default(),
    };
    for tile in 0..width.div_ceil(TILE) * height.div_ceil(TILE) {
        let (tile_x, tile_y) = (tile % width.div_ceil(TILE), tile / width.div_ceil(TILE));
        let first = image.color.len() as u32;
        let mut rows = [0_u16; TILE];
        for (row, mask) in rows.iter_mut().enumerate() {
            for column in 0..TILE {
                let (x, y) = (tile_x * TILE + column, tile_y * TILE + row);
                if x < width
                    && y < height
                    && let Some((color, inverse_depth)) = pixel(x, y)
                {
                    *mask |= 1 << column;
                    image.color.push(color.map(f16::from_f32));
                    inverse_depths.push(inverse_depth);
                }
            }
        }
        if rows.iter().any(|mask| *mask != 0) {
            image.tiles.push(SampleTile { tile_x: tile_x as u16, tile_y: tile_y as u16, first, rows });
        }
    }
    image.depth = DepthPlane::pack(&image.tiles, &inverse_depths);
    let images = if image.is_empty() { Vec::new() } else { vec![Arc::new(image)] };
    Arc::new(SampleSet {
        name: "by hand".to_owned(),
        cameras: vec![camera],
        frame_numbers: vec![0],
        up_in_world: DVec3::NEG_Y,
        settings: Settings::default(),
        images,
        values: Vec::new(),
    })
}
