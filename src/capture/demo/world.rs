//! One moment of a demo scene: placed solids, those at rest apart from those that move, and the light.

use std::sync::{Arc, OnceLock};

use glam::{DMat3, DVec3, Vec3};

use super::bvh::Bounds;
use super::part::Part;
use super::shapes::Shape;
use super::texture::Material;

/// A solid at its place.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Solid {
    pub(super) shape: Shape,
    /// Rotation from the solid's space to world space.
    world_from_local: DMat3,
    /// Where the solid's origin lies, in world space, m.
    position: DVec3,
    material: Material,
}

impl Solid {
    fn to_local(&self, point_in_world: DVec3) -> DVec3 {
        self.world_from_local.transpose() * (point_in_world - self.position)
    }

    /// Start and direction of a ray in the solid's space.
    pub(super) fn ray_to_local(&self, origin: DVec3, direction: DVec3) -> (DVec3, DVec3) {
        (self.to_local(origin), self.world_from_local.transpose() * direction)
    }

    /// Whether no part of the solid can shade another part of it.
    pub(super) fn is_convex(&self) -> bool {
        !matches!(self.shape, Shape::Torus { .. } | Shape::Ring { .. })
    }

    pub(super) fn bounds(&self) -> Bounds {
        let (center, half_axes) = self.outer_box();
        let reach = half_axes.iter().fold(DVec3::ZERO, |sum, axis| sum + axis.abs());
        Bounds { low: center - reach, high: center + reach }
    }

    /// Center and half axes of a box around the solid, in world space.
    pub(super) fn outer_box(&self) -> (DVec3, [DVec3; 3]) {
        let (half, axes) = (self.shape.half_extents(), self.world_from_local);
        (self.position, [axes.x_axis * half.x, axes.y_axis * half.y, axes.z_axis * half.z])
    }
}

/// The light of a scene. Directions are unit vectors in world space, colors linear.
#[derive(Clone, Copy, Debug)]
pub(super) struct Light {
    /// Toward the sun.
    pub(super) to_sun: DVec3,
    /// Radiance that a white surface facing the sun sends out.
    pub(super) sun: Vec3,
    /// Width of the penumbra in meters per meter behind the edge that casts it.
    pub(super) sun_spread: f64,
    /// Sky straight up.
    pub(super) zenith: Vec3,
    /// Sky at the horizon.
    pub(super) horizon: Vec3,
    /// What the ground sends back up.
    pub(super) ground: Vec3,
    /// Solids within this distance darken each other's skylight, m; beyond it nothing changes.
    pub(super) contact: f64,
    /// A lamp in the scene.
    pub(super) lamp: Option<Lamp>,
}

/// A lamp that lights what lies within its reach, without shadows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lamp {
    /// Where it hangs, in world space, m.
    pub(super) position: DVec3,
    /// Radiance that a white surface facing it from nearby sends out.
    pub(super) color: Vec3,
    /// Distance at which its light has faded to nothing, m.
    pub(super) reach: f64,
}

/// Origin and direction of a ray, world space.
pub(super) type Ray = (DVec3, DVec3);

/// Where a ray meets a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit {
    /// Index of the solid.
    pub(super) solid: usize,
    /// Ray parameter.
    pub(super) t: f64,
    /// In world space, m.
    pub(super) point: DVec3,
    /// Unit geometric normal in world space, toward the ray's origin.
    pub(super) normal: DVec3,
    /// Whether another solid is met at the same place.
    pub(super) is_tied: bool,
}

/// Collects the solids of one moment, in an order that is the same for every moment.
pub(super) struct Builder {
    solids: Vec<Solid>,
    light: Light,
    /// Indices of the solids that move.
    moving: Vec<u32>,
    adds_moving: bool,
}

/// One moment of a scene.
#[derive(Debug)]
pub(super) struct World {
    /// The solids, in the order the scene adds them.
    pub(super) solids: Vec<Solid>,
    /// Those that are the same at every moment.
    pub(super) still: Arc<Part>,
    /// All others.
    pub(super) moving: Part,
    /// What lights them.
    pub(super) light: Light,
    /// Both parts together, once a ray meets two solids at once.
    whole: OnceLock<Part>,
}

impl Builder {
    pub(super) fn new(light: Light) -> Self {
        Self { solids: Vec::new(), light, moving: Vec::new(), adds_moving: false }
    }

    /// Adds an upright solid with its origin at `position`.
    pub(super) fn add(&mut self, shape: Shape, position: DVec3, material: Material) {
        self.add_turned(shape, position, DMat3::IDENTITY, material);
    }

    /// Adds a solid turned by `world_from_local`.
    pub(super) fn add_turned(
        &mut self,
        shape: Shape,
        position: DVec3,
        world_from_local: DMat3,
        material: Material,
    ) {
        if self.adds_moving {
            self.moving.push(self.solids.len() as u32);
        }
        self.solids.push(Solid { shape, world_from_local, position, material });
    }

    /// Adds a round bar between two points.
    pub(super) fn add_bar(&mut self, ends: (DVec3, DVec3), radii: (f64, f64), material: Material) {
        let axis = ends.1 - ends.0;
        let shape = Shape::Cone { bottom: radii.0, top: radii.1, half_height: 0.5 * axis.length() };
        self.add_turned(shape, 0.5 * (ends.0 + ends.1), upright_to(axis), material);
    }

    /// Solids that `add` adds may differ from moment to moment; all others are the same at every moment.
    pub(super) fn moving(&mut self, add: impl FnOnce(&mut Self)) {
        self.adds_moving = true;
        add(self);
        self.adds_moving = false;
    }

    pub(super) fn build(self) -> World {
        let mut is_still = vec![true; self.solids.len()];
        for index in &self.moving {
            is_still[*index as usize] = false;
        }
        let members = (0..self.solids.len() as u32).filter(|index| is_still[*index as usize]).collect();
        let still = Part::new(&self.solids, members, &self.light, f64::INFINITY);
        self.build_around(Arc::new(still))
    }

    /// As [`Self::build`], with the part at rest taken from another moment of the same scene.
    pub(super) fn build_around(self, still: Arc<Part>) -> World {
        let moving = Part::new(&self.solids, self.moving, &self.light, still.ground_m());
        World { moving, still, solids: self.solids, light: self.light, whole: OnceLock::new() }
    }
}

/// A rotation that takes z to `axis`.
pub(super) fn upright_to(axis: DVec3) -> DMat3 {
    let z = axis.try_normalize().unwrap_or(DVec3::Z);
    let x = z.any_orthonormal_vector();
    DMat3::from_cols(x, z.cross(x), z)
}

/// Hits closer together than this, as ray parameter, may come in either order out of a hierarchy: its boxes are rounded.
/// The scenes have faces that lie in one plane, as where a shelf's side meets its back.
const TIE: f64 = 1e-9;

/// The nearest of some hits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Nearest {
    /// Ray parameter.
    pub(super) t: f64,
    /// Index of the solid; none for a ray that meets nothing.
    pub(super) solid: usize,
    /// Whether another solid is met within [`TIE`]. Which of them is seen is for [`World::hit`] to say.
    pub(super) is_tied: bool,
}

impl Nearest {
    /// No hit at all.
    pub(super) const NONE: Self = Self { t: f64::INFINITY, solid: usize::MAX, is_tied: false };

    fn include(&mut self, t: f64, solid: usize) {
        let is_tied = (t - self.t).abs() <= TIE;
        if t < self.t {
            *self = Self { t, solid, is_tied };
        } else {
            self.is_tied |= is_tied;
        }
    }
}

impl World {
    /// The world without the solids that move.
    pub(super) fn at_rest(&self) -> Self {
        let moving = Part::new(&self.solids, Vec::new(), &self.light, self.still.ground_m());
        Self {
            solids: self.solids.clone(),
            still: self.still.clone(),
            moving,
            light: self.light,
            whole: OnceLock::new(),
        }
    }

    /// The first surface along `origin + t · direction`, `t > 0`. With a direction of camera-space `z = 1`, `t` is
    /// planar depth.
    pub(super) fn hit(&self, ray: Ray) -> Option<Hit> {
        let mut nearest = self.nearest(&self.moving, ray, self.nearest(&self.still, ray, Nearest::NONE));
        if nearest.is_tied {
            (nearest.t, nearest.solid) = self.first_of_tied(ray)?;
        }
        (nearest.solid != Nearest::NONE.solid).then(|| self.hit_at(ray, nearest))
    }

    /// The nearest of `before` and the hits of a part.
    pub(super) fn nearest(&self, part: &Part, ray: Ray, before: Nearest) -> Nearest {
        let mut nearest = before;
        part.for_each_before(ray, nearest.t + TIE, |index, t_max| {
            nearest.include(self.hit_solid(index, ray.0, ray.1, t_max)?, index);
            Some(nearest.t + TIE)
        });
        nearest
    }

    /// Of solids that are met together, the one that one hierarchy over all of them comes to first.
    fn first_of_tied(&self, ray: Ray) -> Option<(f64, usize)> {
        let whole = self.whole.get_or_init(|| {
            let mut members: Vec<u32> =
                self.still.members().chain(self.moving.members()).map(|index| index as u32).collect();
            members.sort_unstable();
            Part::new(&self.solids, members, &self.light, self.still.ground_m())
        });
        let mut first = None;
        whole.for_each_before(ray, f64::INFINITY, |index, t_max| {
            let t = self.hit_solid(index, ray.0, ray.1, t_max)?;
            first = Some((t, index));
            Some(t)
        });
        first
    }

    /// The nearest hit of a ray, in full.
    pub(super) fn hit_at(&self, (origin, direction): Ray, nearest: Nearest) -> Hit {
        let Nearest { t, solid, is_tied } = nearest;
        let placed = &self.solids[solid];
        let point = origin + direction * t;
        let outward = placed.world_from_local * placed.shape.normal(placed.to_local(point));
        let normal = if outward.dot(direction) > 0.0 { -outward } else { outward };
        Hit { solid, t, point, normal, is_tied }
    }

    /// Ray parameter at which one solid is met before `t_max`.
    pub(super) fn hit_solid(&self, index: usize, origin: DVec3, direction: DVec3, t_max: f64) -> Option<f64> {
        let solid = &self.solids[index];
        let (origin, direction) = solid.ray_to_local(origin, direction);
        solid.shape.hit(origin, direction, 0.0, t_max)
    }

    /// Linear reflectance and glow at a hit.
    pub(super) fn surface_color(&self, hit: &Hit) -> (Vec3, f32) {
        let solid = &self.solids[hit.solid];
        let normal = solid.world_from_local.transpose() * hit.normal;
        let color = solid.material.color(solid.to_local(hit.point), normal, hit.solid as u32);
        (color, solid.material.glow)
    }
}

#[cfg(test)]
mod tests {
    use crate::capture::demo::ALL;

    #[test]
    fn the_part_at_rest_is_the_same_at_every_moment_and_nothing_else_is() {
        for scene in ALL {
            let first = scene.world(0.0);
            let mut has_moved = vec![false; first.solids.len()];
            for step in 0..=40 {
                let now = scene.world(f64::from(step) / 40.0);
                assert!(now.still.members().eq(first.still.members()));
                assert!(now.moving.members().eq(first.moving.members()));
                assert_eq!(now.solids.len(), first.solids.len());
                assert_eq!(format!("{:?}", now.light), format!("{:?}", first.light));
                for (index, has_moved) in has_moved.iter_mut().enumerate() {
                    *has_moved |= now.solids[index] != first.solids[index];
                }
            }
            let moved = (0..has_moved.len()).filter(|index| has_moved[*index]);
            assert!(moved.eq(first.moving.members()), "{} marks what moves", scene.name);
        }
    }
}
