//! The color of a surface point: sun with soft shadows, skylight dimmed near other solids, a lamp. Diffuse alone, so
//! that it depends on the point and the time and never on who looks.
//!
//! Source: shadows and contact shading follow Inigo Quilez, *Soft shadows in raymarched SDFs* (2010) and *Ambient
//! occlusion* (2008). What differs: penumbrae are two-sided; shadows are marched solid by solid within the cone of
//! light instead of through one distance field; and solids are combined by minimum, which no order of visiting
//! changes: a still place keeps its exact color while things move elsewhere.
//!
//! Which solids may be between a point and the sun.
//!
//! Seen along the sun's rays every solid covers a rectangle of the plane across them. A grid over that plane lists the
//! solids of each cell, penumbra included, so that a shadow looks only at solids that can cast it.

use glam::{DVec2, DVec3, Vec3};

use super::world::{Backdrop, Light, SurfaceHit, World};

/// Heights above the surface at which its surroundings are felt, as shares of [`Light::contact`], and their weights, the
/// highest first.
const CONTACT_TAPS: [(f64, f32); 3] = [(1.0, 0.38), (0.4, 0.34), (0.1, 0.3)];
/// A shadow march starts here, m: past the rounding of hit points, short of anything visible.
const SHADOW_START_M: f64 = 1e-3;
/// A shadow march advances by at least this much, m: less than the thinnest bar.
const SHADOW_STEP_M: f64 = 3e-3;
const SHADOW_STEPS: usize = 40;

/// Linear color of the backdrop in a direction.
pub(crate) fn sky(backdrop: &Backdrop, direction: DVec3) -> Vec3 {
    let up = direction.normalize_or_zero().z as f32;
    if up >= 0.0 {
        backdrop.horizon.lerp(backdrop.overhead, (1.6 * up).min(1.0).sqrt())
    } else {
        backdrop.horizon.lerp(backdrop.below, (-3.0 * up).min(1.0))
    }
}

/// Linear color that the point sends in every direction under the given [`irradiance`].
pub(crate) fn reflected(world: &World, hit: &SurfaceHit, irradiance: Vec3) -> Vec3 {
    let (color, glow) = world.surface_color(hit);
    color * (irradiance + Vec3::splat(glow))
}

/// Light that arrives at the point: the radiance of a white surface there.
pub(crate) fn irradiance(world: &World, hit: &SurfaceHit) -> Vec3 {
    let light = &world.light;
    let toward_sun = hit.normal.dot(light.to_sun);
    let sun = if toward_sun > 0.0 {
        sunlight(sun_clearance(world, hit, toward_sun)) * toward_sun as f32
    } else {
        0.0
    };
    let up = 0.5 + 0.5 * hit.normal.z as f32;
    let above = light.horizon.lerp(light.zenith, 0.5 + 0.5 * up);
    let sky = light.ground.lerp(above, up) * skylight(light.contact, free_distances(world, hit));
    light.sun * sun + sky + lamp(light, hit)
}

fn lamp(light: &Light, hit: &SurfaceHit) -> Vec3 {
    let Some(lamp) = light.lamp else { return Vec3::ZERO };
    let to_lamp = lamp.position - hit.point;
    let distance = to_lamp.length();
    if distance >= lamp.reach {
        return Vec3::ZERO;
    }
    let facing = hit.normal.dot(to_lamp / distance.max(1e-6)).max(0.0);
    let near = 1.0 - distance / lamp.reach;
    lamp.color * (facing * near * near) as f32
}

/// Share of the sun's disc that a point sees past what the cone of light to it clears, 0 to 1.
fn sunlight(clear: f64) -> f32 {
    let t = (0.5 + 0.5 * clear).clamp(0.0, 1.0);
    (t * t * (3.0 - 2.0 * t)) as f32
}

/// By how much the cone of light to a point clears the solids: −1 fully shaded to 1 not touched. `toward_sun`, the
/// cosine between normal and sun, is positive.
fn sun_clearance(world: &World, hit: &SurfaceHit, toward_sun: f64) -> f64 {
    let mut clear: f64 = 1.0;
    world.shadows.for_each_toward_sun(hit.point, |index, from, to| {
        clear = clear.min(if index == hit.solid && world.solids[index].is_convex() {
            toward_sun / world.light.sun_spread
        } else {
            clearance(world, index, hit.point, from, to)
        });
        clear > -1.0
    });
    clear
}

/// By how much the cone of light clears one solid between two distances from the point: −1 fully shaded, 0 the cone's
/// axis grazes it, 1 not touched.
fn clearance(world: &World, index: usize, point: DVec3, from: f64, to: f64) -> f64 {
    let solid = &world.solids[index];
    let Light { to_sun, sun_spread, .. } = world.light;
    let (start, direction) = solid.ray_to_local(point, to_sun);
    let mut t = from.max(SHADOW_START_M);
    let mut clear: f64 = 1.0;
    for _ in 0..SHADOW_STEPS {
        if t > to {
            break;
        }
        let distance = solid.shape.distance(start + direction * t);
        clear = clear.min(distance / (sun_spread * t));
        if clear <= -1.0 {
            return -1.0;
        }
        // Nothing within the rest of the way can come into the cone any more.
        if distance > (to - t) * (1.0 + sun_spread) + sun_spread * t {
            break;
        }
        t += distance.abs().max(SHADOW_STEP_M).max(0.3 * sun_spread * t);
    }
    clear
}

/// Distance of the solids to each of the point's [`CONTACT_TAPS`], m, at most its height.
fn free_distances(world: &World, hit: &SurfaceHit) -> [f64; CONTACT_TAPS.len()] {
    let reach = world.light.contact;
    let mut free = CONTACT_TAPS.map(|(share, _)| share * reach);
    world.bvh.for_each_near(hit.point + hit.normal * reach, reach, |index| {
        let solid = &world.solids[index];
        if index == hit.solid && solid.is_convex() {
            return;
        }
        let (foot, up) = solid.ray_to_local(hit.point, hit.normal);
        for (free, (share, _)) in free.iter_mut().zip(CONTACT_TAPS) {
            let distance = solid.shape.distance(foot + up * (share * reach));
            *free = free.min(distance);
            // A solid that leaves the highest tap free leaves every lower one free: they are within its clear ball.
            if share == 1.0 && distance >= reach {
                break;
            }
        }
    });
    free
}

/// Share of the skylight that reaches a point past its surroundings, 0 to 1.
fn skylight(reach: f64, free: [f64; CONTACT_TAPS.len()]) -> f32 {
    let mut open = 1.0;
    for (free, (share, weight)) in free.into_iter().zip(CONTACT_TAPS) {
        let missing = 1.0 - free.max(0.0) / (share * reach);
        open -= weight * missing as f32;
    }
    open.max(0.0)
}

/// Cells along each side of the grid.
const CELLS: usize = 64;

/// A solid as the sun sees it.
#[derive(Clone, Copy, Debug)]
struct Outline {
    /// Across the sun's rays, m.
    low: DVec2,
    high: DVec2,
    /// Along the rays toward the sun, m: nearest to and farthest from the ground.
    below: f64,
    above: f64,
}

/// The grid.
#[derive(Debug)]
pub(crate) struct ShadowMap {
    across: [DVec3; 2],
    to_sun: DVec3,
    spread: f64,
    outlines: Vec<Outline>,
    low: DVec2,
    cells_per_m: DVec2,
    /// Where each cell's list starts in `items`; one more than there are cells.
    starts: Vec<u32>,
    items: Vec<u32>,
    /// Height along the sun's rays that no lit point is below, m.
    deepest: f64,
}

impl ShadowMap {
    /// A map over solids that are given by their centers and half axes (half extent times direction), world space, for
    /// a sun whose penumbra is `spread` m wide per meter behind an edge. No lit point may lie deeper along the sun's
    /// rays than these solids.
    pub(crate) fn new(to_sun: DVec3, spread: f64, solids: impl Iterator<Item = (DVec3, [DVec3; 3])>) -> Self {
        let across = {
            let u = to_sun.any_orthonormal_vector();
            [u, to_sun.cross(u)]
        };
        let outlines: Vec<Outline> =
            solids.map(|(center, half_axes)| outline(across, to_sun, center, half_axes)).collect();
        let low = outlines.iter().fold(DVec2::INFINITY, |low, o| low.min(o.low));
        let high = outlines.iter().fold(DVec2::NEG_INFINITY, |high, o| high.max(o.high));
        let deepest = outlines.iter().fold(f64::INFINITY, |deepest, o| deepest.min(o.below));
        let cells_per_m = DVec2::splat(CELLS as f64) / (high - low).max(DVec2::splat(1e-6));
        let (starts, items) = (Vec::new(), Vec::new());
        let mut map = Self { across, to_sun, spread, outlines, low, cells_per_m, starts, items, deepest };
        map.fill();
        map
    }

    /// Lists the solids of each cell: first counts them, then puts each in its place.
    fn fill(&mut self) {
        let spans: Vec<_> = self
            .outlines
            .iter()
            .map(|outline| {
                let margin = DVec2::splat(self.spread * (outline.above - self.deepest));
                (self.cell(outline.low - margin), self.cell(outline.high + margin))
            })
            .collect();
        let cells_of = |((x0, y0), (x1, y1)): ((usize, usize), (usize, usize))| {
            (y0..=y1).flat_map(move |y| y * CELLS + x0..=y * CELLS + x1)
        };
        let mut starts = vec![0_u32; CELLS * CELLS + 1];
        for cell in spans.iter().copied().flat_map(cells_of) {
            starts[cell + 1] += 1;
        }
        for cell in 0..CELLS * CELLS {
            starts[cell + 1] += starts[cell];
        }
        let mut next = starts.clone();
        self.items = vec![0; starts[CELLS * CELLS] as usize];
        for (index, span) in spans.into_iter().enumerate() {
            for cell in cells_of(span) {
                self.items[next[cell] as usize] = index as u32;
                next[cell] += 1;
            }
        }
        self.starts = starts;
    }

    fn cell(&self, place: DVec2) -> (usize, usize) {
        let cell =
            ((place - self.low) * self.cells_per_m).clamp(DVec2::ZERO, DVec2::splat((CELLS - 1) as f64));
        (cell.x as usize, cell.y as usize)
    }

    /// Calls `found(solid, from, to)` for solids that the cone of light to `point` may touch, between the given
    /// distances from it; stops once `found` gives `false`.
    pub(crate) fn for_each_toward_sun(&self, point: DVec3, mut found: impl FnMut(usize, f64, f64) -> bool) {
        let place = DVec2::new(self.across[0].dot(point), self.across[1].dot(point));
        let height = self.to_sun.dot(point);
        let (x, y) = self.cell(place);
        let cell = y * CELLS + x;
        for item in &self.items[self.starts[cell] as usize..self.starts[cell + 1] as usize] {
            let outline = &self.outlines[*item as usize];
            let to = outline.above - height;
            let beside = (outline.low - place).max(place - outline.high).max_element();
            if to > 0.0 && beside < self.spread * to && !found(*item as usize, outline.below - height, to) {
                return;
            }
        }
    }
}

fn outline(across: [DVec3; 2], to_sun: DVec3, center: DVec3, half_axes: [DVec3; 3]) -> Outline {
    let reach = |direction: DVec3| half_axes.iter().map(|axis| axis.dot(direction).abs()).sum::<f64>();
    let middle = DVec2::new(across[0].dot(center), across[1].dot(center));
    let half = DVec2::new(reach(across[0]), reach(across[1]));
    let (height, depth) = (to_sun.dot(center), reach(to_sun));
    Outline { low: middle - half, high: middle + half, below: height - depth, above: height + depth }
}

#[cfg(test)]
mod tests {
    use crate::demo::ALL;
    use crate::demo::tracer::shade::clearance;
    use glam::DVec3;

    #[test]
    fn solids_that_the_shadow_map_leaves_out_cast_no_shadow() {
        for scene in ALL {
            let world = scene.world(0.6);
            for index in 0..150 {
                let (sin, cos) = (f64::from(index) * 2.399_963).sin_cos();
                let direction = DVec3::new(0.7 * sin, 1.0, 0.5 * cos - 0.3);
                let Some(hit) = world.hit((DVec3::new(0.3, -1.9, 1.6), direction)) else { continue };
                let mut listed = vec![false; world.solids.len()];
                world.shadows.for_each_toward_sun(hit.point, |solid, _, _| {
                    listed[solid] = true;
                    true
                });
                listed[hit.solid] = true;
                for (solid, _) in listed.iter().enumerate().filter(|(_, listed)| !**listed) {
                    assert!(clearance(&world, solid, hit.point, 0.0, 20.0) >= 1.0 - 1e-9);
                }
            }
        }
    }
}
