//! The ray tracer of the built-in scenes.

mod bvh;
mod camera_noise;
mod hits;
mod shade;
mod shadow_map;
mod shapes;
mod texture;
mod world;

use glam::{DVec2, DVec3, Vec3};
use half::f16;
use rayon::prelude::*;

use crate::capture::{Camera, Frame, Values};
use crate::grid::Grid;
pub(crate) use camera_noise::RenderNoise;
pub use camera_noise::with_render_noise;
pub(crate) use shapes::{SolidShape, block, cone, cylinder, sphere, torus};
pub(crate) use texture::{Material, Pattern, hash};
use world::Ray;
pub(crate) use world::{Backdrop, Lamp, Light, World, WorldBuilder, upright_to};

/// Where in the pixel the color of an edge is sampled besides its center: five points of a rotated grid.
const SUBPIXELS: [(f64, f64); 5] = [(0.1, 0.3), (0.3, 0.9), (0.5, 0.1), (0.7, 0.7), (0.9, 0.45)];
/// Neighbors whose normals differ by more than this cosine are on two sides of an edge.
const EDGE_COSINE: f32 = 0.9;
/// Neighbors whose colors differ by more than this share of the brighter are on two sides of an edge.
const EDGE_CONTRAST: f32 = 0.2;
/// Samples of one pixel whose normals agree to this cosine share their light.
const SAME_SURFACE_COSINE: f32 = 0.995;
/// [`Surfel::solid`] of the sky.
const SKY: u32 = u32::MAX;

/// What of a picture is wanted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WantedPlanes {
    /// Whether color is filtered over the pixel where it holds an edge.
    pub(crate) antialiased: bool,
    /// Whether normals are given.
    pub(crate) normals: bool,
    /// Noise on top of the color.
    pub(crate) noise: Option<RenderNoise>,
}

/// What one pixel's center shows.
struct Surfel {
    color: Vec3,
    irradiance: Vec3,
    inverse_depth: f32,
    normal: [f32; 3],
    /// Index in the world, or [`SKY`].
    solid: u32,
}

/// The picture that `camera` takes of `world`.
pub(crate) fn picture(world: &World, camera: &Camera, wanted: WantedPlanes) -> Frame {
    let view = CameraRays::new(camera);
    let (width, height) = camera.intrinsics.size();
    let surfels = rows(width, height, |x, y| surfel(world, view.center(x, y)));
    let color = rows(width, height, |x, y| {
        let center = &surfels[(x, y)];
        let color = if wanted.antialiased && is_edge(&surfels, x, y) {
            filtered(world, center, view.subpixels(x, y))
        } else {
            center.color
        };
        let color = wanted.noise.map_or(color, |noise| noise.apply(color, y * width + x));
        color.to_array().map(|value| f16::from_f32(value.clamp(0.0, f16::MAX.to_f32())))
    });
    Frame {
        color,
        inverse_depth: surfels.map(|surfel| surfel.inverse_depth),
        normal_in_world: wanted.normals.then(|| surfels.map(|surfel| surfel.normal)),
        depth_step_relative: 0.0,
        values: Values::default(),
    }
}

/// The rays of a camera.
struct CameraRays<'a> {
    camera: &'a Camera,
    origin: DVec3,
}

impl<'a> CameraRays<'a> {
    fn new(camera: &'a Camera) -> Self {
        Self { camera, origin: camera.position_in_world() }
    }

    /// Origin and direction of the ray through an image position, scaled so that its parameter is planar depth.
    fn through(&self, pixel: DVec2) -> Ray {
        (self.origin, self.camera.world_from_camera.matrix3 * self.camera.intrinsics.ray_in_camera(pixel))
    }

    /// The ray through a pixel's center.
    fn center(&self, x: usize, y: usize) -> Ray {
        self.through(DVec2::new(x as f64 + 0.5, y as f64 + 0.5))
    }

    /// The rays through the [`SUBPIXELS`] of a pixel.
    fn subpixels(&self, x: usize, y: usize) -> [Ray; SUBPIXELS.len()] {
        SUBPIXELS.map(|(dx, dy)| self.through(DVec2::new(x as f64 + dx, y as f64 + dy)))
    }
}

/// What the ray through a pixel's center meets.
fn surfel(world: &World, ray: Ray) -> Surfel {
    let Some(hit) = world.hit(ray) else {
        return Surfel {
            color: shade::sky(&world.light.backdrop, ray.1),
            irradiance: Vec3::ZERO,
            inverse_depth: 0.0,
            normal: [0.0; 3],
            solid: SKY,
        };
    };
    let irradiance = shade::irradiance(world, &hit);
    Surfel {
        color: shade::reflected(world, &hit, irradiance),
        irradiance,
        inverse_depth: (1.0 / hit.t) as f32,
        normal: hit.normal.as_vec3().to_array(),
        solid: hit.solid as u32,
    }
}

/// The color of a pixel that holds an edge. Within a pixel light hardly changes along a smooth surface, so that the
/// center's serves every sample of the same surface; texture and silhouettes are sampled.
fn filtered(world: &World, center: &Surfel, rays: [Ray; SUBPIXELS.len()]) -> Vec3 {
    let samples = rays.map(|ray| {
        let Some(hit) = world.hit(ray) else { return shade::sky(&world.light.backdrop, ray.1) };
        let is_same_surface = hit.solid as u32 == center.solid
            && hit.normal.as_vec3().dot(center.normal.into()) > SAME_SURFACE_COSINE;
        let irradiance = if is_same_surface { center.irradiance } else { shade::irradiance(world, &hit) };
        shade::reflected(world, &hit, irradiance)
    });
    let sum = samples.into_iter().fold(center.color, |sum, sample| sum + sample);
    sum / (SUBPIXELS.len() + 1) as f32
}

/// Whether the pixel and one of its eight neighbors show different surfaces, faces, or sides of a color edge.
fn is_edge(surfels: &Grid<Surfel>, x: usize, y: usize) -> bool {
    let here = &surfels[(x, y)];
    let (x_end, y_end) = ((x + 2).min(surfels.width()), (y + 2).min(surfels.height()));
    (y.saturating_sub(1)..y_end).any(|row| {
        surfels.row(row)[x.saturating_sub(1)..x_end].iter().any(|there| {
            let contrast = (here.color - there.color).abs().max_element();
            let brightest = here.color.max_element().max(there.color.max_element());
            there.solid != here.solid
                || (there.solid != SKY && Vec3::from(here.normal).dot(there.normal.into()) < EDGE_COSINE)
                || contrast > EDGE_CONTRAST * brightest + 0.01
        })
    })
}

/// Fills a grid row by row, in parallel unless the caller is itself one of many parallel workers.
///
/// A worker that waits for rows takes up other work meanwhile, and that may be the very frame whose rows it waits for:
/// traced twice, with two frames in memory. Hence a worker traces its frame alone.
fn rows<T: Send + Sync>(width: usize, height: usize, value: impl Fn(usize, usize) -> T + Sync) -> Grid<T> {
    if rayon::current_thread_index().is_some() {
        return Grid::from_fn(width, height, value);
    }
    let values = (0..height).into_par_iter().flat_map_iter(|y| (0..width).map(move |x| (x, y)));
    Grid::from_vec(width, height, values.map(|(x, y)| value(x, y)).collect())
}
