//! The solids that demo scenes are made of: exact ray hits, exact normals, and signed distances.
//!
//! Source: the distance functions are those collected by Inigo Quilez, *Distance functions* (2008–); the traced hits
//! are sphere tracing (John C. Hart, *Sphere Tracing*, 1996). What differs: a traced hit is refined until the distance
//! is far below what a 32-bit depth can tell apart, so that traced and closed-form depths are equally exact.
//!
//! Everything here is in the solid's own space; sizes are in meters.

use std::sync::Arc;

use glam::{DVec2, DVec3, DVec4};

/// A solid around the origin of its own space.
#[derive(Clone, Debug)]
pub(super) enum Shape {
    /// A ball.
    Sphere {
        /// Radius, m.
        radius: f64,
    },
    /// A box with edges rounded by `round`.
    Block {
        /// Half extents, m, rounding included.
        half: DVec3,
        /// Radius of the edges, m; 0 is sharp.
        round: f64,
    },
    /// A capped cone or cylinder along z.
    Cone {
        /// Radius at `z = −half_height`, m.
        bottom: f64,
        /// Radius at `z = half_height`, m.
        top: f64,
        /// Half of the height, m.
        half_height: f64,
    },
    /// A torus around z.
    Torus {
        /// Radius of the circle in the middle of the tube, m.
        major: f64,
        /// Radius of the tube, m.
        minor: f64,
    },
    /// A flat ring around z: a disc with a hole.
    Ring {
        /// Radius of the hole, m.
        inner: f64,
        /// Outer radius, m.
        outer: f64,
        /// Half of the thickness, m.
        half_height: f64,
    },
    /// A convex solid: everything with `dot(normal, point) ≤ offset` for each plane.
    Convex {
        /// Outward unit normal and offset of each face.
        planes: Arc<[DVec4]>,
        /// Half extents of a box that holds the solid, m.
        half: DVec3,
    },
}

/// Distance at which a traced ray counts as having arrived, m: a hundredth of the spacing of 32-bit floats at 1 m.
const ARRIVED_M: f64 = 1e-10;
/// Steps after which a traced ray that only grazes is given up.
const MAX_STEPS: usize = 160;

impl Shape {
    /// A cylinder along z.
    pub(super) fn cylinder(radius: f64, half_height: f64) -> Self {
        Self::Cone { bottom: radius, top: radius, half_height }
    }

    /// Half extents of a box around the origin that holds the solid, m.
    pub(super) fn half_extents(&self) -> DVec3 {
        match *self {
            Self::Sphere { radius } => DVec3::splat(radius),
            Self::Block { half, .. } | Self::Convex { half, .. } => half,
            Self::Cone { bottom, top, half_height } => {
                let radius = bottom.max(top);
                DVec3::new(radius, radius, half_height)
            }
            Self::Torus { major, minor } => DVec3::new(major + minor, major + minor, minor),
            Self::Ring { outer, half_height, .. } => DVec3::new(outer, outer, half_height),
        }
    }

    /// Signed distance of `point` to the surface, m; negative inside.
    ///
    /// For [`Shape::Convex`] it is the largest distance to a face's plane: exact inside and above faces, too small
    /// beside edges.
    pub(super) fn distance(&self, point: DVec3) -> f64 {
        match self {
            Self::Sphere { radius } => point.length() - radius,
            Self::Block { half, round } => {
                let over = point.abs() - *half + DVec3::splat(*round);
                over.max(DVec3::ZERO).length() + over.max_element().min(0.0) - round
            }
            Self::Cone { bottom, top, half_height } => cone_distance(point, *bottom, *top, *half_height),
            Self::Torus { major, minor } => {
                DVec2::new(point.truncate().length() - major, point.z).length() - minor
            }
            Self::Ring { inner, outer, half_height } => {
                let over = ring_over(point, *inner, *outer, *half_height);
                over.max(DVec2::ZERO).length() + over.max_element().min(0.0)
            }
            Self::Convex { planes, .. } => planes
                .iter()
                .map(|plane| plane.truncate().dot(point) - plane.w)
                .fold(f64::NEG_INFINITY, f64::max),
        }
    }

    /// Outward unit normal at a point of the surface.
    pub(super) fn normal(&self, point: DVec3) -> DVec3 {
        let direction = match self {
            Self::Sphere { .. } => point,
            Self::Block { half, round } => block_normal(point, *half, *round),
            Self::Cone { bottom, top, half_height } => cone_normal(point, *bottom, *top, *half_height),
            Self::Torus { major, .. } => point - (point.truncate().normalize_or_zero() * *major).extend(0.0),
            Self::Ring { inner, outer, half_height } => {
                let over = ring_over(point, *inner, *outer, *half_height);
                if over.y > over.x {
                    DVec3::Z * point.z.signum()
                } else {
                    let radius = point.truncate().length();
                    (point.truncate() * (radius - 0.5 * (inner + outer))).extend(0.0)
                }
            }
            Self::Convex { planes, .. } => planes
                .iter()
                .max_by(|a, b| {
                    let above = |plane: &DVec4| plane.truncate().dot(point) - plane.w;
                    above(a).total_cmp(&above(b))
                })
                .map_or(DVec3::Z, |plane| plane.truncate()),
        };
        direction.try_normalize().unwrap_or(DVec3::Z)
    }

    /// Parameter of the first hit of `origin + t · direction` with `t` in `(t_min, t_max)`.
    ///
    /// `direction` need not have unit length.
    pub(super) fn hit(&self, origin: DVec3, direction: DVec3, t_min: f64, t_max: f64) -> Option<f64> {
        let within = |t: f64| (t > t_min && t < t_max).then_some(t);
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
                cone_hits(origin, direction, *bottom, *top, *half_height)
                    .into_iter()
                    .filter(|t| *t > t_min && *t < t_max)
                    .min_by(f64::total_cmp)
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
            Self::Block { .. } | Self::Torus { .. } | Self::Ring { .. } => {
                self.traced_hit(origin, direction, t_min, t_max)
            }
        }
    }

    fn traced_hit(&self, origin: DVec3, direction: DVec3, t_min: f64, t_max: f64) -> Option<f64> {
        let half = self.half_extents();
        let (enter, leave) = slab(origin, direction.recip(), -half, half);
        let speed = direction.length();
        let (mut t, end) = (enter.max(t_min), leave.min(t_max));
        // A ray that starts inside walks along the negative distance to the way out.
        let side = self.distance(origin + direction * t).signum();
        for _ in 0..MAX_STEPS {
            if t > end {
                return None;
            }
            let distance = side * self.distance(origin + direction * t);
            t += distance / speed;
            if distance.abs() < ARRIVED_M {
                return (t > t_min && t < t_max).then_some(t);
            }
        }
        None
    }
}

/// Parameters at which a ray enters and leaves the box from `low` to `high`; `enter > leave` where it misses.
pub(super) fn slab(origin: DVec3, inverse_direction: DVec3, low: DVec3, high: DVec3) -> (f64, f64) {
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

fn ring_over(point: DVec3, inner: f64, outer: f64, half_height: f64) -> DVec2 {
    let radius = point.truncate().length();
    DVec2::new((radius - 0.5 * (inner + outer)).abs() - 0.5 * (outer - inner), point.z.abs() - half_height)
}

fn block_normal(point: DVec3, half: DVec3, round: f64) -> DVec3 {
    let over = point.abs() - half + DVec3::splat(round);
    if round > 0.0 && over.max_element() > 0.0 {
        return over.max(DVec3::ZERO) * point.signum();
    }
    if over.x >= over.y && over.x >= over.z {
        DVec3::X * point.x.signum()
    } else if over.y >= over.z {
        DVec3::Y * point.y.signum()
    } else {
        DVec3::Z * point.z.signum()
    }
}

fn cone_distance(point: DVec3, bottom: f64, top: f64, half_height: f64) -> f64 {
    let q = DVec2::new(point.truncate().length(), point.z);
    let rim = DVec2::new(top, half_height);
    let side = DVec2::new(top - bottom, 2.0 * half_height);
    let cap = DVec2::new(q.x - q.x.min(if q.y < 0.0 { bottom } else { top }), q.y.abs() - half_height);
    let along = ((rim - q).dot(side) / side.length_squared()).clamp(0.0, 1.0);
    let lateral = q - rim + side * along;
    let sign = if lateral.x < 0.0 && cap.y < 0.0 { -1.0 } else { 1.0 };
    sign * cap.length_squared().min(lateral.length_squared()).sqrt()
}

fn cone_normal(point: DVec3, bottom: f64, top: f64, half_height: f64) -> DVec3 {
    let slope = (top - bottom) / (2.0 * half_height);
    let radius = point.truncate().length();
    let from_side = (radius - (0.5 * (top + bottom) + slope * point.z)).abs() / (1.0 + slope * slope).sqrt();
    if (point.z.abs() - half_height).abs() < from_side {
        DVec3::Z * point.z.signum()
    } else {
        (point.truncate() / radius.max(f64::MIN_POSITIVE)).extend(-slope)
    }
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

#[cfg(test)]
mod tests {
    use super::super::four_cameras::crystal;
    use super::Shape;
    use glam::DVec3;
    use proptest::prelude::*;

    fn shapes() -> Vec<Shape> {
        vec![
            Shape::Sphere { radius: 0.7 },
            Shape::Block { half: DVec3::new(0.5, 0.3, 0.8), round: 0.0 },
            Shape::Block { half: DVec3::new(0.5, 0.3, 0.8), round: 0.1 },
            Shape::cylinder(0.4, 0.6),
            Shape::Cone { bottom: 0.6, top: 0.2, half_height: 0.5 },
            Shape::Cone { bottom: 0.5, top: 0.0, half_height: 0.5 },
            Shape::Torus { major: 0.6, minor: 0.2 },
            Shape::Ring { inner: 0.3, outer: 0.7, half_height: 0.1 },
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
        fn nothing_lies_before_the_first_hit(
            origin in prop::array::uniform3(-3.0..3.0_f64),
            aim in prop::array::uniform3(-0.6..0.6_f64),
        ) {
            let (origin, direction) = (DVec3::from(origin), DVec3::from(aim) - DVec3::from(origin));
            for shape in shapes() {
                let end = shape.hit(origin, direction, 0.0, f64::INFINITY).unwrap_or(3.0);
                let side = shape.distance(origin).signum();
                for step in 1..200 {
                    let point = origin + direction * (end * f64::from(step) / 200.0);
                    prop_assert!(side * shape.distance(point) > -1e-6, "{shape:?} was passed through at {point}");
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
        let from_left = |shape: &Shape| shape.hit(DVec3::new(-2.0, 0.0, 0.0), DVec3::X, 0.0, f64::INFINITY);
        let expected = [1.3, 1.5, 1.5, 1.6, 1.6, 1.75, 1.2, 1.3];
        for (shape, expected) in shapes().iter().zip(expected) {
            assert!((from_left(shape).unwrap() - expected).abs() < 1e-9, "{shape:?}");
        }
    }
}
