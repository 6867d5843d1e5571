//! Depth of another size, lens or place than color, carried into the color camera's pixels.
//!
//! Purpose: a sample needs color and depth of one ray. Source: the registration of depth to color of every RGB-D sensor's driver:
//! project, and keep the nearest of what falls on one pixel. What differs: not points but the surfaces of
//! [`SurfaceMesh`](super::surface_mesh) are drawn, so that color finer than depth leaves no holes; what the color camera sees and the
//! depth camera does not stays empty.

use std::sync::{Arc, Mutex, PoisonError};

use glam::{DAffine3, DVec2, DVec3};

use super::distortion::Distortion;
use super::surface_mesh::SurfaceMesh;
use crate::capture::camera::Intrinsics;
use crate::capture::frame::INVALID_INVERSE_DEPTH;

/// A depth camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DepthGrid {
    /// Its size and lens.
    pub intrinsics: Intrinsics,
    /// What its lens does to its picture; `None` where it is a pinhole.
    pub distortion: Option<Distortion>,
    /// From its space into the color camera's, both x right, y down, z forward; rigid.
    pub color_from_depth: DAffine3,
}

impl DepthGrid {
    /// The ray through a position in the depth picture, scaled to z = 1; `None` where the lens sees none there.
    pub(crate) fn ray(&self, pixel: DVec2) -> Option<DVec3> {
        let ray = self.intrinsics.ray_in_camera(pixel);
        match &self.distortion {
            Some(distortion) => Some(distortion.undistort(ray.truncate())?.extend(1.0)),
            None => Some(ray),
        }
    }
}

/// The rays through a depth camera's pixels, which a lens makes dear to follow: once for all pictures of a camera.
#[derive(Debug)]
pub(crate) struct GridRays {
    columns: usize,
    /// Through the pixels' centers, row by row, scaled to z = 1; `None` where the lens sees none.
    centers: Vec<Option<DVec3>>,
    /// Through the pixels' corners, one more in a row and in a column.
    corners: Vec<Option<DVec3>>,
}

impl GridRays {
    /// Follows the rays of `grid`.
    pub(crate) fn of(grid: &DepthGrid) -> Self {
        let (columns, rows) = grid.intrinsics.size();
        let rays = |columns: usize, rows: usize, offset: f64| {
            let at =
                move |index: usize| DVec2::new((index % columns) as f64, (index / columns) as f64) + offset;
            (0..columns * rows).map(|index| grid.ray(at(index))).collect()
        };
        Self { columns, centers: rays(columns, rows, 0.5), corners: rays(columns + 1, rows + 1, 0.0) }
    }

    /// Through the center of a pixel.
    fn center(&self, x: usize, y: usize) -> Option<DVec3> {
        self.centers[y * self.columns + x]
    }

    /// Through its corners: top left, top right, bottom right, bottom left.
    fn around(&self, x: usize, y: usize) -> [Option<DVec3>; 4] {
        let corner = |x: usize, y: usize| self.corners[y * (self.columns + 1) + x];
        [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)]
    }
}

/// The rays of the depth cameras of one capture. Cloning is cheap; clones share them.
#[derive(Clone, Debug, Default)]
pub(crate) struct RayCache(Arc<Mutex<Vec<CachedRays>>>);

/// A lens and the rays of it.
type CachedRays = ((Intrinsics, Option<Distortion>), Arc<GridRays>);

/// The most pixels, in all cameras together, whose rays are kept: 64 bytes each.
const MAX_KEPT_PIXELS: usize = 2 << 20;

impl RayCache {
    /// The rays of a grid. Who finds them missing makes them while others wait, without a thread pool.
    pub(crate) fn rays(&self, grid: &DepthGrid) -> Arc<GridRays> {
        let lens = (grid.intrinsics, grid.distortion);
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, rays)) = kept.iter().find(|(of, _)| *of == lens) {
            return rays.clone();
        }
        let pixels: usize = kept.iter().map(|((intrinsics, _), _)| intrinsics.pixel_count()).sum();
        if pixels + grid.intrinsics.pixel_count() > MAX_KEPT_PIXELS {
            drop(kept);
            return Arc::new(GridRays::of(grid));
        }
        let rays = Arc::new(GridRays::of(grid));
        kept.push((lens, rays.clone()));
        rays
    }
}

/// A corner of a triangle in the color camera's picture.
#[derive(Clone, Copy)]
struct Vertex {
    pixel: DVec2,
    inverse_depth: f64,
}

/// Carries inverse planar depth into the pixels of the color camera; negative where the depth camera saw nothing. `color` is the
/// color camera's lens without distortion, `rays` are the rays of the depth camera.
pub(crate) fn register(
    inverse_depth: &[f32],
    depth: &DepthGrid,
    rays: &GridRays,
    color: &Intrinsics,
) -> Vec<f32> {
    let (columns, rows) = depth.intrinsics.size();
    let mesh = SurfaceMesh::new(inverse_depth, (columns, rows), depth.intrinsics.fx.min(depth.intrinsics.fy));
    let vertex = |ray: Option<DVec3>, inverse: f32| {
        let inverse = f64::from(inverse);
        let DAffine3 { matrix3, translation } = depth.color_from_depth;
        let point = matrix3 * ray? + translation * inverse;
        Some(Vertex { pixel: color.project(point)?, inverse_depth: inverse / point.z })
    };
    let mut target = vec![INVALID_INVERSE_DEPTH; color.pixel_count()];
    for y in 0..rows {
        for x in 0..columns {
            let Some((own, corners)) = mesh.pixel(x, y) else { continue };
            let center = vertex(rays.center(x, y), own);
            let corner_rays = rays.around(x, y);
            let around: [Option<Vertex>; 4] =
                std::array::from_fn(|index| vertex(corner_rays[index], corners[index]));
            for index in 0..4 {
                if let (Some(center), Some(a), Some(b)) = (center, around[index], around[(index + 1) % 4]) {
                    draw([center, a, b], color.size(), &mut target);
                }
            }
        }
    }
    target
}

/// How far outside a triangle a pixel's center still counts as inside, so that rounding opens no cracks.
const EDGE_SLACK: f64 = 1e-9;

/// Draws a triangle into the nearest surfaces so far. Inverse depth is linear in the picture.
fn draw([a, b, c]: [Vertex; 3], size: (usize, usize), target: &mut [f32]) {
    let (width, height) = size;
    let (ab, ac) = (b.pixel - a.pixel, c.pixel - a.pixel);
    let area = ab.perp_dot(ac);
    if area == 0.0 || !area.is_finite() {
        return;
    }
    let low = a.pixel.min(b.pixel).min(c.pixel);
    let high = a.pixel.max(b.pixel).max(c.pixel);
    let first = |value: f64, side: usize| (value - 0.5).ceil().clamp(0.0, side as f64) as usize;
    let end = |value: f64, side: usize| ((value - 0.5).floor() + 1.0).clamp(0.0, side as f64) as usize;
    for y in first(low.y, height)..end(high.y, height) {
        for x in first(low.x, width)..end(high.x, width) {
            let at = DVec2::new(x as f64 + 0.5, y as f64 + 0.5) - a.pixel;
            let (to_b, to_c) = (at.perp_dot(ac) / area, ab.perp_dot(at) / area);
            if to_b < -EDGE_SLACK || to_c < -EDGE_SLACK || to_b + to_c > 1.0 + EDGE_SLACK {
                continue;
            }
            let inverse = a.inverse_depth
                + to_b * (b.inverse_depth - a.inverse_depth)
                + to_c * (c.inverse_depth - a.inverse_depth);
            let nearest = &mut target[y * width + x];
            *nearest = nearest.max(inverse as f32);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COLOR: Intrinsics = Intrinsics::centered(60, 40, 50.0);

    fn grid(distortion: Option<Distortion>, shift: DVec3) -> DepthGrid {
        DepthGrid {
            intrinsics: Intrinsics::centered(24, 16, 18.0),
            distortion,
            color_from_depth: DAffine3::from_translation(shift),
        }
    }

    /// Inverse depth of a slanted plane `n · p = 1` as a depth camera sees it.
    fn plane(grid: &DepthGrid, n: DVec3) -> Vec<f32> {
        let at = |i: usize| DVec2::new((i % 24) as f64 + 0.5, (i / 24) as f64 + 0.5);
        let seen = |i: usize| grid.ray(at(i)).map_or(INVALID_INVERSE_DEPTH, |ray| n.dot(ray) as f32);
        (0..24 * 16).map(seen).collect()
    }

    #[test]
    fn a_plane_is_the_same_plane_in_finer_pixels_without_a_hole() {
        let lens = Distortion::radial_tangential([0.05, 0.0, 0.0, 0.0, 0.0, 0.0], [0.001, 0.0]);
        for distortion in [None, lens] {
            let grid = grid(distortion, DVec3::new(0.02, -0.01, 0.0));
            let n = DVec3::new(0.1, 0.05, 0.5);
            let found = register(&plane(&grid, n), &grid, &GridRays::of(&grid), &COLOR);
            // The same plane from the color camera: n · (p − t) = 1.
            let moved = n / (1.0 + n.dot(grid.color_from_depth.translation));
            let inner = (4..36).flat_map(|y| (4..56).map(move |x| (x, y)));
            for (x, y) in inner {
                let expected = moved.dot(COLOR.ray_in_camera(DVec2::new(x as f64 + 0.5, y as f64 + 0.5)));
                let value = f64::from(found[y * 60 + x]);
                assert!((value / expected - 1.0).abs() < 2e-3, "{x} {y}: {value} {expected}");
                if distortion.is_none() {
                    assert!((value / expected - 1.0).abs() < 1e-5, "{x} {y}: {value} {expected}");
                }
            }
        }
    }

    #[test]
    fn what_only_the_color_camera_sees_stays_empty_and_the_nearer_surface_wins() {
        let grid = grid(None, DVec3::new(-0.2, 0.0, 0.0));
        // A post at 1 before a wall at 4.
        let seen: Vec<f32> =
            (0..24 * 16).map(|i| if (9..15).contains(&(i % 24)) { 1.0 } else { 0.25 }).collect();
        let found = register(&seen, &grid, &GridRays::of(&grid), &COLOR);
        let row: Vec<f32> = found[20 * 60..21 * 60].to_vec();
        assert!(row.contains(&INVALID_INVERSE_DEPTH), "{row:?}");
        let is_one_of =
            |value: &f32| [1.0, 0.25, INVALID_INVERSE_DEPTH].iter().any(|it| (value - it).abs() < 1e-6);
        assert!(row.iter().all(is_one_of), "no bridge: {row:?}");
        let post = row.iter().filter(|value| (**value - 1.0).abs() < 1e-6).count();
        assert!((16..=18).contains(&post), "6 pixels of 18 are 16.7 of 50: {post}");
    }

    #[test]
    fn the_sky_stays_the_sky_whatever_the_baseline() {
        let grid = grid(None, DVec3::new(5.0, 0.0, 0.0));
        let found = register(&vec![0.0; 24 * 16], &grid, &GridRays::of(&grid), &COLOR);
        assert_eq!(found[20 * 60 + 30], 0.0);
    }
}
