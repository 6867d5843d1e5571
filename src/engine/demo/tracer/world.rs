//! One moment of a demo scene: placed solids, what finds them quickly, and the light.

use glam::{DMat3, DVec3, Vec3};

use super::bvh::{Aabb, Bvh};
use super::shadow_map::ShadowMap;
use super::shapes::SolidShape;
use super::texture::Material;

/// A solid at its place.
#[derive(Debug)]
pub(crate) struct Solid {
    pub(crate) shape: SolidShape,
    /// Rotation from the solid's space to world space.
    world_from_local: DMat3,
    /// The solid's origin in world space, m.
    position: DVec3,
    material: Material,
}

impl Solid {
    fn to_local(&self, point_in_world: DVec3) -> DVec3 {
        self.world_from_local.transpose() * (point_in_world - self.position)
    }

    /// Start and direction of a ray in the solid's space.
    pub(crate) fn ray_to_local(&self, origin: DVec3, direction: DVec3) -> (DVec3, DVec3) {
        (self.to_local(origin), self.world_from_local.transpose() * direction)
    }

    /// Whether no part of the solid can shade another part of it.
    pub(crate) fn is_convex(&self) -> bool {
        !matches!(self.shape, SolidShape::Torus { .. } | SolidShape::Ring { .. })
    }

    pub(crate) fn bounds(&self) -> Aabb {
        let (center, half_axes) = self.outer_box();
        let reach = half_axes.iter().fold(DVec3::ZERO, |sum, axis| sum + axis.abs());
        Aabb { low: center - reach, high: center + reach }
    }

    /// Center and half axes of a box around the solid, in world space.
    pub(crate) fn outer_box(&self) -> (DVec3, [DVec3; 3]) {
        let (half, axes) = (self.shape.half_extents(), self.world_from_local);
        (self.position, [axes.x_axis * half.x, axes.y_axis * half.y, axes.z_axis * half.z])
    }
}

/// The light of a scene. Directions are unit vectors in world space, colors linear.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Light {
    /// Toward the sun.
    pub(crate) to_sun: DVec3,
    /// Radiance that a white surface facing the sun sends out.
    pub(crate) sun: Vec3,
    /// Width of the penumbra in meters per meter behind the edge that casts it.
    pub(crate) sun_spread: f64,
    /// Sky straight up.
    pub(crate) zenith: Vec3,
    /// Sky at the horizon.
    pub(crate) horizon: Vec3,
    /// What the ground sends back up.
    pub(crate) ground: Vec3,
    /// What a camera sees where there is no solid.
    pub(crate) backdrop: Backdrop,
    /// Solids within this distance darken each other's skylight, m; beyond it nothing changes.
    pub(crate) contact: f64,
    /// A lamp in the scene.
    pub(crate) lamp: Option<Lamp>,
}

/// The sky as a camera sees it, which need not be the one that lights. Colors are linear.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Backdrop {
    /// From 39° above the horizon up to the zenith.
    pub(crate) overhead: Vec3,
    /// At the horizon.
    pub(crate) horizon: Vec3,
    /// From 19° below the horizon down.
    pub(crate) below: Vec3,
}

impl Backdrop {
    /// A clear evening sky over haze.
    pub(crate) const EVENING: Self = Self {
        overhead: Vec3::new(0.16, 0.32, 0.58),
        horizon: Vec3::new(0.86, 0.72, 0.54),
        below: Vec3::new(0.42, 0.36, 0.32),
    };
    /// White paper.
    pub(crate) const WHITE: Self = Self { overhead: Vec3::ONE, horizon: Vec3::ONE, below: Vec3::ONE };
}

/// A lamp that lights what is within its reach, without shadows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lamp {
    /// Where it hangs, in world space, m.
    pub(crate) position: DVec3,
    /// Radiance that a white surface facing it from nearby sends out.
    pub(crate) color: Vec3,
    /// Distance at which its light has faded to nothing, m.
    pub(crate) reach: f64,
}

/// Origin and direction of a ray, world space.
pub(crate) type Ray = (DVec3, DVec3);

/// Where a ray meets a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfaceHit {
    /// Index of the solid.
    pub(crate) solid: usize,
    /// Ray parameter.
    pub(crate) t: f64,
    /// In world space, m.
    pub(crate) point: DVec3,
    /// Unit geometric normal in world space, toward the ray's origin.
    pub(crate) normal: DVec3,
}

/// Collects the solids of one moment, in an order that is the same for every moment.
pub(crate) struct WorldBuilder {
    solids: Vec<Solid>,
    light: Light,
}

/// One moment of a scene.
#[derive(Debug)]
pub(crate) struct World {
    /// The solids, in the order the scene adds them.
    pub(crate) solids: Vec<Solid>,
    /// What lights them.
    pub(crate) light: Light,
    /// Finds the solids along a ray or near a point.
    pub(crate) bvh: Bvh,
    /// Finds the solids between a point and the sun.
    pub(crate) shadows: ShadowMap,
}

impl WorldBuilder {
    pub(crate) fn new(light: Light) -> Self {
        Self { solids: Vec::new(), light }
    }

    /// Adds an upright solid with its origin at `position`.
    pub(crate) fn add(&mut self, shape: SolidShape, position: DVec3, material: Material) {
        self.add_turned(shape, position, DMat3::IDENTITY, material);
    }

    /// Adds a solid turned by `world_from_local`.
    pub(crate) fn add_turned(
        &mut self,
        shape: SolidShape,
        position: DVec3,
        world_from_local: DMat3,
        material: Material,
    ) {
        self.solids.push(Solid { shape, world_from_local, position, material });
    }

    /// Adds a round bar between two points.
    pub(crate) fn add_bar(&mut self, ends: (DVec3, DVec3), radii: (f64, f64), material: Material) {
        let axis = ends.1 - ends.0;
        let shape = SolidShape::Cone { bottom: radii.0, top: radii.1, half_height: 0.5 * axis.length() };
        self.add_turned(shape, 0.5 * (ends.0 + ends.1), upright_to(axis), material);
    }

    pub(crate) fn build(self) -> World {
        let Self { solids, light } = self;
        let bounds: Vec<Aabb> = solids.iter().map(Solid::bounds).collect();
        let shadows = ShadowMap::new(light.to_sun, light.sun_spread, solids.iter().map(Solid::outer_box));
        World { bvh: Bvh::new(&bounds), shadows, solids, light }
    }
}

/// A rotation that takes z to `axis`.
pub(crate) fn upright_to(axis: DVec3) -> DMat3 {
    let z = axis.try_normalize().unwrap_or(DVec3::Z);
    let x = z.any_orthonormal_vector();
    DMat3::from_cols(x, z.cross(x), z)
}

impl World {
    /// The first surface along `origin + t · direction`, `t > 0`. With a direction of camera-space `z = 1`, `t` is
    /// planar depth. Where faces are in one plane, the solid that the hierarchy visits first is met.
    pub(crate) fn hit(&self, (origin, direction): Ray) -> Option<SurfaceHit> {
        let mut nearest = None;
        self.bvh.for_each_before(origin, direction, f64::INFINITY, |index, t_max| {
            let t = self.hit_solid(index, origin, direction, t_max)?;
            nearest = Some((t, index));
            Some(t)
        });
        let (t, solid) = nearest?;
        let placed = &self.solids[solid];
        let point = origin + direction * t;
        let outward = placed.world_from_local * placed.shape.normal(placed.to_local(point));
        let normal = if outward.dot(direction) > 0.0 { -outward } else { outward };
        Some(SurfaceHit { solid, t, point, normal })
    }

    /// Ray parameter at which one solid is met before `t_max`.
    pub(crate) fn hit_solid(&self, index: usize, origin: DVec3, direction: DVec3, t_max: f64) -> Option<f64> {
        let solid = &self.solids[index];
        let (origin, direction) = solid.ray_to_local(origin, direction);
        solid.shape.hit(origin, direction, 0.0, t_max)
    }

    /// Linear reflectance and glow at a hit.
    pub(crate) fn surface_color(&self, hit: &SurfaceHit) -> (Vec3, f32) {
        let solid = &self.solids[hit.solid];
        let normal = solid.world_from_local.transpose() * hit.normal;
        let color = solid.material.color(solid.to_local(hit.point), normal, hit.solid as u32);
        (color, solid.material.glow)
    }
}
