//! A capture with depth carried into the pixels of color, for sensors whose color lens is not the depth lens as claimed.

use glam::{DVec2, Vec3};

use super::color_lens::ColorLens;
use crate::capture::pictures::{DepthGrid, RayCache, register};
use crate::capture::sighting::tolerances::TAKEN_OVER;
use crate::capture::sighting::{Landing, Sighting};
use crate::capture::{Camera, Capture, Frame, Intrinsics, with_changed_frames};
use crate::grid::Grid;

/// Color as it is, with the depth and the normals behind its pixels.
fn registered(frame: &Frame, depth: &Camera, lens: &ColorLens, rays: &RayCache) -> Frame {
    let ColorLens { intrinsics: color, color_from_depth } = *lens;
    let grid = DepthGrid { intrinsics: depth.intrinsics, distortion: None, color_from_depth };
    let inverse_depth = register(frame.inverse_depth.as_slice(), &grid, &rays.rays(&grid), &color);
    let (width, height) = color.size();
    let inverse_depth = Grid::from_vec(width, height, inverse_depth);
    let normal_in_world = frame.normal_in_world.as_ref().map(|normals| {
        Grid::from_fn(width, height, |x, y| {
            let position = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            normal_behind(frame, normals, &depth.intrinsics, lens, position, inverse_depth[(x, y)])
                .unwrap_or_default()
        })
    });
    Frame {
        color: frame.color.clone(),
        inverse_depth,
        normal_in_world,
        values: frame.values.clone(),
        ..*frame
    }
}

/// The depth camera's normal of the surface at a position of the color picture; `None` where it has none.
fn normal_behind(
    frame: &Frame,
    normals: &Grid<[f32; 3]>,
    depth: &Intrinsics,
    lens: &ColorLens,
    position: DVec2,
    inverse_depth: f32,
) -> Option<[f32; 3]> {
    if inverse_depth <= 0.0 {
        return None;
    }
    let point = lens.intrinsics.ray_in_camera(position) / f64::from(inverse_depth);
    let there = lens.color_from_depth.inverse().transform_point3(point);
    let landing = Landing::through(depth, there, frame.size())?;
    let normal = normals[landing.pixel];
    let sighting = landing.compare(frame.inverse_depth[landing.pixel], TAKEN_OVER);
    let is_surface = sighting == Sighting::Same;
    (is_surface && Vec3::from_array(normal) != Vec3::ZERO).then_some(normal)
}

/// The camera of the color whose depth is of `camera`.
pub(crate) fn color_camera(camera: &Camera, lens: &ColorLens) -> Camera {
    Camera {
        name: camera.name.clone(),
        intrinsics: lens.intrinsics,
        world_from_camera: camera.world_from_camera * lens.color_from_depth.inverse(),
    }
}

/// Registered frames that are kept, bytes.
const CACHE_BYTES: usize = 256 << 20;

/// The capture as seen through the color lenses, per camera; `None` where color has the lens of depth.
pub(crate) fn with_color_lenses(capture: &Capture, lenses: Vec<Option<ColorLens>>) -> Capture {
    let seen_through = lenses.clone();
    let originals = capture.cameras.clone();
    let rays = RayCache::default();
    let change = move |camera: usize, _, frame: &Frame| match &lenses[camera] {
        Some(lens) => registered(frame, &originals[camera], lens, &rays),
        None => frame.clone(),
    };
    with_changed_frames(capture, CACHE_BYTES, change).with_changed_cameras(|index, camera| {
        if let Some(lens) = &seen_through[index] {
            *camera = color_camera(camera, lens);
        }
    })
}
