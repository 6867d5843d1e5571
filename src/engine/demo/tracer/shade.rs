//! The color of a surface point: sun with soft shadows, skylight dimmed near other solids, a lamp. Diffuse alone, so
//! that it depends on the point and the time and never on who looks.
//!
//! Source: shadows and contact shading follow Inigo Quilez, *Soft shadows in raymarched SDFs* (2010) and *Ambient
//! occlusion* (2008). What differs: penumbrae are two-sided; shadows are marched solid by solid within the cone of
//! light instead of through one distance field; and solids are combined by minimum, which no order of visiting
//! changes: a still place keeps its exact color while things move elsewhere.

use glam::{DVec3, Vec3};

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

#[cfg(test)]
mod tests {
    use super::clearance;
    use crate::demo::ALL;
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
