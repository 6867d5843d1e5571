//! Where a ray first meets a solid: in closed form where there is one, traced along the distance elsewhere.
//!
//! Source: sphere tracing (John C. Hart, *Sphere Tracing*, 1996). What differs: hits are refined, by Newton's steps
//! where they are safe, until the distance is far below what a 32-bit depth can tell apart, so that traced and
//! closed-form depths are equally exact.

use glam::DVec3;

use super::shapes::SolidShape;

/// Distance at which a traced ray counts as having arrived, m: a hundredth of the spacing of 32-bit floats at 1 m.
const ARRIVED_M: f64 = 1e-10;
/// How far beyond its box a solid is looked for, m.
const BOX_MARGIN_M: f64 = 1e-9;
/// Steps after which a traced ray that only grazes is given up.
const MAX_STEPS: usize = 256;

impl SolidShape {
    /// Parameter of the first hit of `origin + t · direction` with `t` in `(t_min, t_max)`.
    ///
    /// `direction` need not have unit length. A ray that starts inside finds its way out, unless it leaves a traced
    /// solid at a grazing angle.
    pub(crate) fn hit(&self, origin: DVec3, direction: DVec3, t_min: f64, t_max: f64) -> Option<f64> {
        let within = |t: f64| (t > t_min && t < t_max).then_some(t);
        let first = |hits: &[f64]| hits.iter().filter_map(|t| within(*t)).min_by(f64::total_cmp);
        match self {
            Self::Sphere { radius } => {
                let a = direction.length_squared();
                let b = origin.dot(direction);
                let c = origin.length_squared() - radius * radius;
                let root = quadratic(a, b, c)?;
                within(root.0).or_else(|| within(root.1))
            }
            Self::Block { half, round: 0.0 } => {
                let (enter, leave) = slab(origin, direction.recip(), -*half, *half);
                if enter > leave { None } else { within(enter).or_else(|| within(leave)) }
            }
            Self::Cone { bottom, top, half_height } => {
                first(&cone_hits(origin, direction, *bottom, *top, *half_height))
            }
            Self::Convex { planes, .. } => {
                let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
                for plane in planes.iter() {
                    let speed = plane.truncate().dot(direction);
                    let above = plane.truncate().dot(origin) - plane.w;
                    if speed == 0.0 {
                        if above > 0.0 {
                            return None;
                        }
                    } else if speed < 0.0 {
                        enter = enter.max(-above / speed);
                    } else {
                        leave = leave.min(-above / speed);
                    }
                }
                if enter > leave { None } else { within(enter).or_else(|| within(leave)) }
            }
            Self::Ring { inner, outer, half_height } => {
                first(&ring_hits(origin, direction, (*inner, *outer), *half_height))
            }
            Self::Block { .. } | Self::Torus { .. } => self.traced_hit(origin, direction, t_min, t_max),
        }
    }

    /// Sphere tracing with Newton's steps where they cannot pass the first hit.
    fn traced_hit(&self, origin: DVec3, direction: DVec3, t_min: f64, t_max: f64) -> Option<f64> {
        let half = self.half_extents();
        let (enter, leave) = slab(origin, direction.recip(), -half, half);
        let speed = direction.length();
        // A face may be in the side of the box: the last bit must not decide whether the way out is within it.
        let (mut t, end) = (enter.max(t_min), (leave + BOX_MARGIN_M / speed).min(t_max));
        // A ray that starts inside follows the negative distance to its exit.
        let side = self.distance(origin + direction * t).signum();
        for _ in 0..MAX_STEPS {
            if t > end {
                return None;
            }
            let point = origin + direction * t;
            let distance = side * self.distance(point);
            if distance.abs() < ARRIVED_M {
                return (t > t_min && t < t_max).then_some(t);
            }
            let approach = -self.normal(point).dot(direction) / speed;
            let newton = side > 0.0 && approach > 0.0 && self.newton_stays_before(distance, approach);
            t += if newton { distance / approach } else { distance } / speed;
        }
        None
    }

    /// Whether Newton's step from a point outside cannot pass the first hit, at the given distance and rate of approach
    /// (meters per meter).
    fn newton_stays_before(&self, distance: f64, approach: f64) -> bool {
        match *self {
            // The distance to a convex solid is convex along a ray: its tangent meets zero first.
            Self::Block { .. } => true,
            // Kantorovich's condition with twice the curvature of the surface, to allow for the way there.
            Self::Torus { major, minor } => 4.0 * distance < approach * approach * minor.min(major - minor),
            _ => false,
        }
    }
}

/// Parameters at which a ray enters and leaves the box from `low` to `high`; `enter > leave` where it misses.
pub(crate) fn slab(origin: DVec3, inverse_direction: DVec3, low: DVec3, high: DVec3) -> (f64, f64) {
    let a = (low - origin) * inverse_direction;
    let b = (high - origin) * inverse_direction;
    // `min` and `max` of the components pass over NaN, which a ray within a face's plane makes of 0 · ∞.
    let near = DVec3::new(a.x.min(b.x), a.y.min(b.y), a.z.min(b.z));
    let far = DVec3::new(a.x.max(b.x), a.y.max(b.y), a.z.max(b.z));
    (near.x.max(near.y).max(near.z), far.x.min(far.y).min(far.z))
}

/// Both roots of `a t² + 2 b t + c`, ascending.
fn quadratic(a: f64, b: f64, c: f64) -> Option<(f64, f64)> {
    let discriminant = b * b - a * c;
    if discriminant < 0.0 || a == 0.0 {
        return None;
    }
    // The root of equal signs first: the other one from the product of roots, without cancellation.
    let q = -(b + b.signum() * discriminant.sqrt());
    let (first, second) = (q / a, if q == 0.0 { 0.0 } else { c / q });
    Some((first.min(second), first.max(second)))
}

/// Where a ray meets the side (twice at most) and the caps; NaN where it does not.
fn cone_hits(origin: DVec3, direction: DVec3, bottom: f64, top: f64, half_height: f64) -> [f64; 4] {
    let slope = (top - bottom) / (2.0 * half_height);
    let middle = 0.5 * (top + bottom);
    let mut hits = [f64::NAN; 4];
    let (o, d) = (origin.truncate(), direction.truncate());
    let (radius_at_origin, radius_speed) = (middle + slope * origin.z, slope * direction.z);
    let roots = quadratic(
        d.length_squared() - radius_speed * radius_speed,
        o.dot(d) - radius_at_origin * radius_speed,
        o.length_squared() - radius_at_origin * radius_at_origin,
    );
    if let Some((first, second)) = roots {
        for (slot, t) in [first, second].into_iter().enumerate() {
            let z = origin.z + t * direction.z;
            if z.abs() <= half_height && middle + slope * z >= 0.0 {
                hits[slot] = t;
            }
        }
    }
    for (slot, z, radius) in [(2, -half_height, bottom), (3, half_height, top)] {
        let t = (z - origin.z) / direction.z;
        if (o + d * t).length_squared() <= radius * radius {
            hits[slot] = t;
        }
    }
    hits
}

/// Where a ray meets the outer and inner sides and the faces of a ring; NaN where it does not.
fn ring_hits(origin: DVec3, direction: DVec3, radii: (f64, f64), half_height: f64) -> [f64; 6] {
    let (inner, outer) = radii;
    let mut hits = [f64::NAN; 6];
    for (slot, radius) in [(0, outer), (2, inner)] {
        // The caps of these cylinders are not faces of the ring.
        let sides = cone_hits(origin, direction, radius, radius, half_height);
        hits[slot..slot + 2].copy_from_slice(&sides[..2]);
    }
    for (slot, z) in [(4, -half_height), (5, half_height)] {
        let t = (z - origin.z) / direction.z;
        let radius = (origin + direction * t).truncate().length();
        if (inner..=outer).contains(&radius) {
            hits[slot] = t;
        }
    }
    hits
}

#[cfg(test)]
mod tests {
    use crate::demo::scenes::four_cameras::crystal;
    use crate::demo::tracer::shapes::SolidShape;
    use glam::DVec3;
    use proptest::prelude::*;

    fn shapes() -> Vec<SolidShape> {
        vec![
            SolidShape::Sphere { radius: 0.7 },
            SolidShape::Block { half: DVec3::new(0.5, 0.3, 0.8), round: 0.0 },
            SolidShape::Block { half: DVec3::new(0.5, 0.3, 0.8), round: 0.1 },
            crate::demo::tracer::cylinder(0.4, 0.6),
            SolidShape::Cone { bottom: 0.6, top: 0.2, half_height: 0.5 },
            SolidShape::Cone { bottom: 0.5, top: 0.0, half_height: 0.5 },
            SolidShape::Torus { major: 0.6, minor: 0.2 },
            SolidShape::Ring { inner: 0.3, outer: 0.7, half_height: 0.1 },
            crystal(0.3, 0.9),
        ]
    }

    proptest! {
        #[test]
        fn a_hit_lies_on_the_surface_with_the_gradient_as_its_normal(
            origin in prop::array::uniform3(-3.0..3.0_f64),
            aim in prop::array::uniform3(-0.6..0.6_f64),
        ) {
            let (origin, direction) = (DVec3::from(origin), DVec3::from(aim) - DVec3::from(origin));
            for shape in shapes() {
                let Some(t) = shape.hit(origin, direction, 0.0, f64::INFINITY) else { continue };
                let point = origin + direction * t;
                prop_assert!(shape.distance(point).abs() < 1e-9, "{shape:?} at {point}");
                let normal = shape.normal(point);
                prop_assert!((normal.length() - 1.0).abs() < 1e-12);
                if shape.distance(origin) > 1e-6 {
                    prop_assert!(normal.dot(direction) < 1e-6, "{shape:?} faces away");
                }
                let step = 1e-6;
                let slope = |axis: DVec3| {
                    (shape.distance(point + axis * step) - shape.distance(point - axis * step)) / (2.0 * step)
                };
                let gradient = DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z));
                // Within a step of an edge the differences straddle two faces.
                if (gradient.length() - 1.0).abs() < 1e-6 {
                    prop_assert!((gradient - normal).length() < 1e-4, "{shape:?}: {gradient} is not {normal}");
                }
            }
        }

        #[test]
        fn no_ray_from_outside_passes_its_first_hit(
            origin in prop::array::uniform3(-3.0..3.0_f64),
            aim in prop::array::uniform3(-0.6..0.6_f64),
        ) {
            let (origin, direction) = (DVec3::from(origin), DVec3::from(aim) - DVec3::from(origin));
            for shape in shapes() {
                if shape.distance(origin) < 1e-6 {
                    continue;
                }
                let end = shape.hit(origin, direction, 0.0, f64::INFINITY).unwrap_or(3.0);
                for step in 1..200 {
                    let point = origin + direction * (end * f64::from(step) / 200.0);
                    prop_assert!(shape.distance(point) > -1e-6, "{shape:?} was passed through at {point}");
                }
            }
        }

        #[test]
        fn a_solid_lies_within_its_half_extents(point in prop::array::uniform3(-1.5..1.5_f64)) {
            let point = DVec3::from(point);
            for shape in shapes() {
                let outside = (point.abs() - shape.half_extents()).max_element() > 1e-12;
                prop_assert!(!outside || shape.distance(point) > 0.0, "{shape:?} at {point}");
            }
        }
    }

    #[test]
    fn hits_of_known_rays_are_where_they_must_be() {
        let from_left =
            |shape: &SolidShape| shape.hit(DVec3::new(-2.0, 0.0, 0.0), DVec3::X, 0.0, f64::INFINITY);
        let expected = [1.3, 1.5, 1.5, 1.6, 1.6, 1.75, 1.2, 1.3];
        for (shape, expected) in shapes().iter().zip(expected) {
            assert!((from_left(shape).unwrap() - expected).abs() < 1e-9, "{shape:?}");
        }
    }
}
