//! Projection (the paper, §3.3): from a sample's pixel and depth to its place in the vantage, incrementally along rows.
//!
//! Unprojecting `ray · z`, moving to the target camera and projecting is linear in `(ray, 1/z)` before the division:
//! `P = M·ray + o·w` with `w = 1/z`. `P.xy / P.z` is the position in target pixels and `w / P.z` the target's inverse
//! depth, for points at infinity (`w = 0`) as well. Along a row `M·ray` grows by a constant: one addition a pixel.

use glam::{DMat3, DVec2, DVec3, Vec3};

use crate::capture::Camera;
use crate::preprocess::{SampleImage, TILE};

/// Carries samples of one camera into a vantage.
#[derive(Clone, Copy, Debug)]
pub(super) struct Projector {
    first_pixel: Vec3,
    per_column: Vec3,
    per_row: Vec3,
    origin: Vec3,
}

/// A sample in the vantage.
#[derive(Clone, Copy, Debug)]
pub(super) struct Projected {
    /// Target pixels; centers at +0.5. Finite, but perhaps outside the picture.
    pub(super) u: f32,
    /// See `u`.
    pub(super) v: f32,
    /// Reciprocal of planar z in the target, 0 at infinity.
    pub(super) inverse_depth: f32,
    /// Index into the planes of the sample's image.
    pub(super) index: usize,
}

impl Projector {
    pub(super) fn new(source: &Camera, target: &Camera) -> Self {
        let k = target.intrinsics;
        let image_from_camera = DMat3::from_cols(
            DVec3::new(k.fx, 0.0, 0.0),
            DVec3::new(0.0, k.fy, 0.0),
            DVec3::new(k.cx, k.cy, 1.0),
        );
        let target_from_source = target.camera_from_world() * source.world_from_camera;
        let image_from_source = image_from_camera * target_from_source.matrix3;
        let s = source.intrinsics;
        Self {
            first_pixel: (image_from_source * s.ray_in_camera(DVec2::splat(0.5))).as_vec3(),
            per_column: (image_from_source.x_axis / s.fx).as_vec3(),
            per_row: (image_from_source.y_axis / s.fy).as_vec3(),
            origin: (image_from_camera * target_from_source.translation).as_vec3(),
        }
    }

    /// Calls `paint` for every sample of one tile that lies in front of the vantage.
    pub(super) fn project_tile(&self, image: &SampleImage, tile: usize, mut paint: impl FnMut(Projected)) {
        let tile = &image.tiles[tile];
        let mut index = tile.first as usize;
        let (x, y) = (tile.tile_x as usize * TILE, tile.tile_y as usize * TILE);
        for (row, &mask) in tile.rows.iter().enumerate() {
            if mask == 0 {
                continue;
            }
            let mut ray = self.first_pixel + self.per_column * x as f32 + self.per_row * (y + row) as f32;
            for column in 0..TILE {
                if mask >> column & 1 == 1 {
                    let inverse_depth = image.inverse_depth[index];
                    let point = ray + self.origin * inverse_depth;
                    if point.z > 0.0 {
                        let reciprocal = point.z.recip();
                        paint(Projected {
                            u: point.x * reciprocal,
                            v: point.y * reciprocal,
                            inverse_depth: inverse_depth * reciprocal,
                            index,
                        });
                    }
                    index += 1;
                }
                ray += self.per_column;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::Intrinsics;
    use crate::preprocess::{SampleTile, Span};
    use half::f16;

    #[test]
    fn projecting_along_rows_agrees_with_unprojecting_and_projecting() {
        let source = Camera::look_at(
            "a",
            Intrinsics::from_horizontal_angle(64, 48, 0.9),
            DVec3::new(1.0, -4.0, 2.0),
            DVec3::ZERO,
            DVec3::Z,
        );
        let target = Camera::look_at(
            "b",
            Intrinsics::from_horizontal_angle(80, 60, 0.7),
            DVec3::new(-2.0, -3.0, 1.0),
            DVec3::ZERO,
            DVec3::Z,
        );
        let depths: Vec<f32> = (0..256).map(|i| 1.0 / (3.0 + 0.01 * i as f32)).collect();
        let image = SampleImage {
            camera: 0,
            span: Span { start: 0, end: 1 },
            tiles: vec![SampleTile { tile_x: 1, tile_y: 2, first: 0, rows: [u16::MAX; TILE] }],
            color: vec![[f16::ZERO; 3]; 256],
            inverse_depth: depths,
            normal: None,
        };
        let mut seen = 0;
        Projector::new(&source, &target).project_tile(&image, 0, |projected| {
            let (x, y) = (16 + projected.index % 16, 32 + projected.index / 16);
            let z = f64::from(image.inverse_depth[projected.index]).recip();
            let point = source.unproject(DVec2::new(x as f64 + 0.5, y as f64 + 0.5), z);
            let (pixel, depth) = target.project(point).unwrap();
            assert!(
                (pixel.x as f32 - projected.u).abs() < 1e-3 && (pixel.y as f32 - projected.v).abs() < 1e-3
            );
            assert!((depth as f32 * projected.inverse_depth - 1.0).abs() < 1e-5);
            seen += 1;
        });
        assert_eq!(seen, 256);
    }
}
