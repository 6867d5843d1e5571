//! The solids that demo scenes are made of: signed distances and exact normals. Ray hits are in `hits`.
//!
//! Source: the distance functions are those collected by Inigo Quilez, *Distance functions* (2008–).
//!
//! Everything here is in the solid's own space; sizes are in meters.

use std::sync::Arc;

use glam::{DVec2, DVec3, DVec4};

/// A solid around the origin of its own space.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum SolidShape {
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

/// See [`SolidShape::Sphere`].
pub(crate) fn sphere(radius: f64) -> SolidShape {
    SolidShape::Sphere { radius }
}

/// See [`SolidShape::Block`].
pub(crate) fn block(half: impl Into<DVec3>, round: f64) -> SolidShape {
    SolidShape::Block { half: half.into(), round }
}

/// See [`SolidShape::Cone`].
pub(crate) fn cone(bottom: f64, top: f64, half_height: f64) -> SolidShape {
    SolidShape::Cone { bottom, top, half_height }
}

/// A cylinder along z.
pub(crate) fn cylinder(radius: f64, half_height: f64) -> SolidShape {
    cone(radius, radius, half_height)
}

/// See [`SolidShape::Torus`].
pub(crate) fn torus(major: f64, minor: f64) -> SolidShape {
    SolidShape::Torus { major, minor }
}

impl SolidShape {
    /// Half extents of a box around the origin that holds the solid, m.
    pub(crate) fn half_extents(&self) -> DVec3 {
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
    /// For [`SolidShape::Convex`] it is the largest distance to a face's plane: exact inside and above faces, too small
    /// beside edges.
    pub(crate) fn distance(&self, point: DVec3) -> f64 {
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
    pub(crate) fn normal(&self, point: DVec3) -> DVec3 {
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
