//! The ray tracer of the built-in scenes.

mod bvh;
mod camera_noise;
mod hits;
mod shade;
mod shadow_map;
mod shapes;
mod texture;
pub(crate) mod trace;
mod world;

pub(crate) use camera_noise::RenderNoise;
pub use camera_noise::with_render_noise;
pub(crate) use shapes::{SolidShape, block, cone, cylinder, sphere, torus};
pub(crate) use texture::{Material, Pattern, hash};
pub(crate) use world::{Backdrop, Lamp, Light, World, WorldBuilder, upright_to};
