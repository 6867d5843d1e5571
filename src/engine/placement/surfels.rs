//! The kept samples of a coarse capture as small disks on surfaces.

use glam::{DVec3, Vec3};
use half::f16;

use crate::capture::Camera;
use crate::preprocess::{Rate, ViewingRays, footprint};
use crate::samples::{PlacedSample, SampleImage, SampleSet};
use crate::settings::PruningSettings;

/// About the most surfels of all frames together; of more samples every second, third … in both directions stands for all.
const MOST: usize = 90_000;

/// How finely surfaces should be seen.
#[derive(Clone, Copy, Debug)]
pub(super) enum Asked {
    /// Width of a pixel on the surface, as a share of that of the finest coarse picture.
    AsCoarse(f64),
    /// Width of a pixel on every surface, world units.
    Width(f64),
}

/// A small disk on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surfel {
    /// World units.
    pub point_in_world: DVec3,
    /// Unit length, on the side that was seen.
    pub normal_in_world: Vec3,
    /// Diameter, world units.
    pub width: f64,
    /// Linear Rec.709.
    pub color: [f32; 3],
    /// Width of a pixel that shows it as finely as it should be, world units.
    pub(super) asked_width: f32,
    /// What it counts for.
    pub(super) weight: u32,
}

/// What is there at one frame.
#[derive(Clone, Debug)]
pub(super) struct Moment {
    pub(super) surfels: Vec<Surfel>,
}

/// The surfels of each frame.
pub(super) fn moments(set: &SampleSet, asked: &Asked) -> Vec<Moment> {
    let frames = 0..set.frame_count();
    let samples: usize = frames.clone().flat_map(|frame| set.images_at(frame)).map(|image| image.len()).sum();
    let step = (samples as f64 / MOST as f64).sqrt().ceil().max(1.0) as usize;
    let mut moments: Vec<Moment> = frames
        .map(|frame| {
            let images = set.images_at(frame);
            let of_image = |image: &std::sync::Arc<SampleImage>| of_image(image, set, asked, step);
            Moment { surfels: images.flat_map(of_image).collect() }
        })
        .collect();
    if let Asked::Width(width) = asked {
        weigh_by_area(&mut moments, *width);
    }
    moments
}

fn of_image(image: &SampleImage, set: &SampleSet, asked: &Asked, step: usize) -> Vec<Surfel> {
    let camera = &set.cameras[image.camera as usize];
    let rays = ViewingRays::new(camera);
    let is_chosen =
        |placed: &PlacedSample| [placed.sample.x, placed.sample.y].iter().all(|at| at.is_multiple_of(step));
    let surfel = |placed: PlacedSample| {
        let ray = (camera.world_from_camera.matrix3 * placed.ray_in_camera).as_vec3();
        let known = image.normal.as_ref().map_or(Vec3::ZERO, |normals| normals[placed.sample.index].decode());
        // What has no normal faces its camera.
        let normal_in_world = if known == Vec3::ZERO { -ray.normalize_or_zero() } else { known };
        let width = width_of_pixel(&rays, ray, placed.depth, normal_in_world, &set.settings.pruning);
        Surfel {
            point_in_world: placed.point_in_world,
            normal_in_world,
            width: f64::from(width) * step as f64,
            color: image.color[placed.sample.index].map(f16::to_f32),
            asked_width: match asked {
                Asked::AsCoarse(share) => width * *share as f32,
                Asked::Width(width) => *width as f32,
            },
            weight: 1,
        }
    };
    image.placed(camera).filter(is_chosen).map(surfel).collect()
}

/// The longer side of a pixel on a surface, world units, of a camera whose ray to it has planar depth 1.
pub(super) fn width_of_pixel(
    rays: &ViewingRays,
    ray: Vec3,
    depth: f64,
    normal: Vec3,
    settings: &PruningSettings,
) -> f32 {
    footprint(Rate::Stretch, rays, ray, (1.0 / depth) as f32, normal, settings)
}

/// Weights in pixels that the asked rate has on each surfel, scaled so that they are whole, and small.
fn weigh_by_area(moments: &mut [Moment], width: f64) {
    /// The largest weight.
    const LARGEST: f64 = 4096.0;
    let pixels = |surfel: &Surfel| (surfel.width / width).powi(2);
    let all = moments.iter().flat_map(|moment| &moment.surfels);
    let largest = all.map(pixels).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    for surfel in moments.iter_mut().flat_map(|moment| &mut moment.surfels) {
        surfel.weight = (LARGEST * pixels(surfel) / largest).ceil().max(1.0) as u32;
    }
}

impl Surfel {
    /// How finely a camera shows it that does see it, in proportion to what is asked for: 0 to [`FINEST`].
    pub(super) fn fineness(
        &self,
        rays: &ViewingRays,
        camera: &Camera,
        depth: f64,
        settings: &PruningSettings,
    ) -> u8 {
        let ray = ((self.point_in_world - camera.position_in_world()) / depth).as_vec3();
        let width = width_of_pixel(rays, ray, depth, self.normal_in_world, settings);
        (f32::from(FINEST) * (self.asked_width / width).min(1.0)).round() as u8
    }
}

/// Value of a surfel that is seen as finely as it should be.
pub(super) const FINEST: u8 = u8::MAX;
