//! The solids of a world that never move, or those that do, with what finds them quickly.
//!
//! Every question to a world is one to both of its parts, and the answers combine by minimum: the nearer hit, the
//! smaller clearance. What the part at rest answers is thus the same at every moment.

use glam::DVec3;

use super::bvh::{Bounds, Bvh};
use super::shadow_map::ShadowMap;
use super::world::{Light, Ray, Solid};

/// Some of the solids of a world; they keep their index among all.
#[derive(Debug)]
pub(super) struct Part {
    /// Index in the world, ascending.
    members: Vec<u32>,
    bounds: Vec<Bounds>,
    bvh: Bvh,
    shadows: ShadowMap,
}

impl Part {
    /// Those of `solids` that `members` lists. No lit point lies deeper along the sun's rays than they and `ground_m`.
    pub(super) fn new(solids: &[Solid], members: Vec<u32>, light: &Light, ground_m: f64) -> Self {
        let chosen = || members.iter().map(|index| &solids[*index as usize]);
        let bounds: Vec<Bounds> = chosen().map(Solid::bounds).collect();
        let shadows =
            ShadowMap::new((light.to_sun, light.sun_spread), ground_m, chosen().map(Solid::outer_box));
        Self { bvh: Bvh::new(&bounds), bounds, shadows, members }
    }

    /// Indices of the solids, ascending.
    pub(super) fn members(&self) -> impl Iterator<Item = usize> {
        self.members.iter().map(|index| *index as usize)
    }

    /// See [`ShadowMap::deepest`].
    pub(super) fn ground_m(&self) -> f64 {
        self.shadows.deepest()
    }

    /// See [`Bvh::for_each_before`].
    pub(super) fn for_each_before(
        &self,
        (origin, direction): Ray,
        t_max: f64,
        mut test: impl FnMut(usize, f64) -> Option<f64>,
    ) {
        let test = |item: usize, t_max| test(self.members[item] as usize, t_max);
        self.bvh.for_each_before(origin, direction, t_max, test);
    }

    /// See [`Bvh::for_each_near`].
    pub(super) fn for_each_near(&self, point: DVec3, radius: f64, mut found: impl FnMut(usize)) {
        self.bvh.for_each_near(point, radius, |item| found(self.members[item] as usize));
    }

    /// See [`ShadowMap::for_each_toward_sun`].
    pub(super) fn for_each_toward_sun(&self, point: DVec3, mut found: impl FnMut(usize, f64, f64) -> bool) {
        self.shadows
            .for_each_toward_sun(point, |item, from, to| found(self.members[item] as usize, from, to));
    }

    /// Whether a solid may come between the sun and a point of the first box, or within `contact_m` of the second.
    pub(super) fn may_dim(&self, points: &Bounds, taps: &Bounds, contact_m: f64) -> bool {
        self.bounds.iter().any(|solid| solid.is_within(contact_m, taps)) || self.shadows.may_shade(points)
    }
}
