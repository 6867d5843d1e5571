//! Whether a sample of one camera is in a region: the region made ready for many samples of that camera.

use glam::{DAffine3, DMat3, DQuat, DVec3, EulerRot};
use half::f16;

use super::drawn_area::DrawnArea;
use super::region::Region;
use super::seen::Seen;
use crate::capture::{Camera, Intrinsics, PixelSide, ValueChannel};
use crate::color::{linear_from_srgb, srgb_from_linear};
use crate::samples::VoteCounts;

/// A region for samples of one camera.
#[derive(Clone, Debug)]
pub(super) enum RegionTest {
    Constant(bool),
    Box {
        box_from_world: DAffine3,
        half_size: DVec3,
    },
    Sphere {
        center: DVec3,
        radius_squared: f64,
    },
    HalfSpace {
        point: DVec3,
        normal: DVec3,
    },
    Depth {
        from: f64,
        to: f64,
    },
    Pixels(DrawnArea),
    View {
        camera_from_world: DAffine3,
        lens: Intrinsics,
        area: DrawnArea,
        depth: Option<[f64; 2]>,
    },
    /// By its place in a list of regions that depend on other samples.
    Marked(usize),
    Doubtful,
    Contradicted,
    ConfirmedByFewerThan(u32),
    SeenByOneCamera,
    Angle {
        most_cosine: f64,
        least_cosine: f64,
    },
    Value {
        channel: usize,
        from: f64,
        to: f64,
    },
    /// Between two linear colors, channel by channel.
    Color {
        low: [f32; 3],
        high: [f32; 3],
    },
    Any(Vec<Self>),
    All(Vec<Self>),
    Not(Box<Self>),
}

/// What regions are made ready for.
#[derive(Clone, Copy)]
pub(super) struct RegionContext<'a> {
    /// Whose samples are asked about.
    pub(super) camera: &'a Camera,
    /// The channels of their values.
    pub(super) channels: &'a [ValueChannel],
    /// The regions that depend on other samples, as [`Seen::marks`] knows them; one that is not among them holds nothing.
    pub(super) marked: &'a [Region],
}

impl RegionTest {
    /// For samples of one camera. Parts that are the same for all of its samples are decided here.
    pub(super) fn new(region: &Region, context: RegionContext<'_>) -> Self {
        let RegionContext { camera, channels, marked } = context;
        match region {
            asks if asks.asks_other_samples() => {
                let at = marked.iter().position(|known| known == asks);
                at.map_or(Self::Constant(false), Self::Marked)
            }
            Region::Box { center, half_size, rotation_degrees } => {
                let [x, y, z] = rotation_degrees.map(f64::to_radians);
                let turned = DMat3::from_quat(DQuat::from_euler(EulerRot::XYZEx, x, y, z));
                let world_from_box = DAffine3::from_mat3_translation(turned, DVec3::from(*center));
                Self::Box { box_from_world: world_from_box.inverse(), half_size: DVec3::from(*half_size) }
            }
            Region::Sphere { center, radius } => {
                Self::Sphere { center: DVec3::from(*center), radius_squared: radius * radius }
            }
            Region::HalfSpace { point, normal } => {
                Self::HalfSpace { point: DVec3::from(*point), normal: DVec3::from(*normal) }
            }
            Region::Depth { from, to } => Self::Depth { from: *from, to: *to },
            Region::Footprint { from, to } if camera.intrinsics.is_orthographic() => {
                // The same at any depth, but for what is at infinity.
                let width = camera.intrinsics.pixel_width(1.0, PixelSide::Longer);
                let is_within = (*from..=*to).contains(&width);
                if is_within { Self::Depth { from: 0.0, to: f64::MAX } } else { Self::Constant(false) }
            }
            Region::Footprint { from, to } => {
                let width = camera.intrinsics.pixel_width(1.0, PixelSide::Longer);
                Self::Depth { from: from / width, to: to / width }
            }
            Region::Cameras(names) => Self::Constant(names.contains(&camera.name)),
            Region::Pixels { camera: name, outline, strokes, .. } if *name == camera.name => {
                Self::Pixels(DrawnArea::new(outline, strokes))
            }
            Region::View { viewpoint, outline, strokes, depth, .. } => Self::View {
                camera_from_world: viewpoint.camera_from_world(),
                lens: viewpoint.lens(),
                area: DrawnArea::new(outline, strokes),
                depth: *depth,
            },
            Region::Doubtful => Self::Doubtful,
            Region::Contradicted => Self::Contradicted,
            Region::ConfirmedByFewerThan(count) => Self::ConfirmedByFewerThan(*count),
            Region::SeenByOneCamera => Self::SeenByOneCamera,
            Region::Angle { from, to } => Self::Angle {
                most_cosine: from.min(180.0).to_radians().cos(),
                least_cosine: to.min(180.0).to_radians().cos(),
            },
            Region::Value { name, from, to } => {
                let channel = channels.iter().position(|channel| channel.name == *name);
                let ready = |channel| Self::Value { channel, from: *from, to: *to };
                channel.map_or(Self::Constant(false), ready)
            }
            Region::Color { linear, tolerance } => {
                let bounds = linear.map(|channel| bounds_of_color(channel as f32, *tolerance as f32));
                Self::Color { low: bounds.map(|[low, _]| low), high: bounds.map(|[_, high]| high) }
            }
            Region::Pixels { .. }
            | Region::SameSurface { .. }
            | Region::Grow { .. }
            | Region::Shrink { .. } => Self::Constant(false),
            Region::Any(parts) => Self::combined(parts, context, true),
            Region::All(parts) => Self::combined(parts, context, false),
            Region::Without(parts) => {
                let first = parts.first().map_or(Self::Constant(false), |first| Self::new(first, context));
                let rest = Self::combined(parts.get(1..).unwrap_or_default(), context, true);
                Self::simplified(vec![first, rest.inverted()], false)
            }
            Region::Not(part) => Self::new(part, context).inverted(),
        }
    }

    fn combined(parts: &[Region], context: RegionContext<'_>, is_any: bool) -> Self {
        Self::simplified(parts.iter().map(|part| Self::new(part, context)).collect(), is_any)
    }

    /// Leaves out parts that decide nothing.
    fn simplified(mut parts: Vec<Self>, is_any: bool) -> Self {
        if parts.iter().any(|part| matches!(part, Self::Constant(value) if *value == is_any)) {
            return Self::Constant(is_any);
        }
        parts.retain(|part| !matches!(part, Self::Constant(_)));
        match (parts.len(), is_any) {
            (0, _) => Self::Constant(!is_any),
            (1, _) => parts.swap_remove(0),
            (_, true) => Self::Any(parts),
            (_, false) => Self::All(parts),
        }
    }

    fn inverted(self) -> Self {
        match self {
            Self::Constant(value) => Self::Constant(!value),
            Self::Not(part) => *part,
            other => Self::Not(Box::new(other)),
        }
    }

    pub(super) fn contains(&self, seen: &Seen<'_>) -> bool {
        match self {
            Self::Constant(value) => *value,
            Self::Box { box_from_world, half_size } => {
                // Comparisons with what is not finite are false, as those of the sky have to be.
                box_from_world.transform_point3(seen.point_in_world).abs().cmple(*half_size).all()
            }
            Self::Sphere { center, radius_squared } => {
                (seen.point_in_world - center).length_squared() <= *radius_squared
            }
            Self::HalfSpace { point, normal } if seen.depth.is_finite() => {
                (seen.point_in_world - point).dot(*normal) >= 0.0
            }
            Self::HalfSpace { normal, .. } => seen.direction_in_world.dot(*normal) > 0.0,
            Self::Depth { from, to } => (*from..=*to).contains(&seen.depth),
            Self::Pixels(area) => area.contains(seen.pixel),
            Self::Marked(at) => seen.is_marked(*at),
            Self::View { camera_from_world, lens, area, depth } => {
                let is_sky = !seen.depth.is_finite();
                let in_camera = if is_sky {
                    camera_from_world.transform_vector3(seen.direction_in_world)
                } else {
                    camera_from_world.transform_point3(seen.point_in_world)
                };
                let is_in_range =
                    depth.is_none_or(|[from, to]| !is_sky && (from..=to).contains(&in_camera.z));
                is_in_range && lens.project(in_camera).is_some_and(|pixel| area.contains(pixel))
            }
            Self::Doubtful => seen.is_doubtful,
            Self::Contradicted => seen.votes.contradict(1, false),
            Self::ConfirmedByFewerThan(count) => seen.votes.confirm < *count,
            Self::SeenByOneCamera => seen.votes == VoteCounts::default(),
            Self::Angle { most_cosine, least_cosine } => {
                let toward_camera = -seen.direction_in_world.normalize_or_zero();
                let cosine = seen.normal_in_world.dot(toward_camera);
                seen.normal_in_world != DVec3::ZERO && (*least_cosine..=*most_cosine).contains(&cosine)
            }
            // A comparison with a missing value is false.
            Self::Value { channel, from, to } => {
                seen.values.get(*channel).is_some_and(|value| (*from..=*to).contains(&f64::from(*value)))
            }
            Self::Color { low, high } => {
                let color = seen.color.map(f16::to_f32);
                (0..3).all(|channel| (low[channel]..=high[channel]).contains(&color[channel]))
            }
            Self::Any(parts) => parts.iter().any(|part| part.contains(seen)),
            Self::All(parts) => parts.iter().all(|part| part.contains(seen)),
            Self::Not(part) => !part.contains(seen),
        }
    }

    /// Whether it asks for normals.
    pub(super) fn asks_for_normals(&self) -> bool {
        match self {
            Self::Angle { .. } => true,
            Self::Any(parts) | Self::All(parts) => parts.iter().any(Self::asks_for_normals),
            Self::Not(part) => part.asks_for_normals(),
            _ => false,
        }
    }
}

/// The lowest and the highest linear value of a channel whose encoded value is within so many steps of 1/255 of that of `linear`. The curve
/// rises everywhere, so that samples are compared without being encoded.
fn bounds_of_color(linear: f32, tolerance: f32) -> [f32; 2] {
    let (encoded, reach) = (srgb_from_linear(linear), tolerance / 255.0);
    // Below black all is encoded alike.
    let low = if encoded <= reach { f32::NEG_INFINITY } else { linear_from_srgb(encoded - reach) };
    // Encoding and back may miss the value itself by what was rounded.
    [low.min(linear), linear_from_srgb(encoded + reach).max(linear)]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_channel_is_near_where_its_encoded_value_is(
            linear in -0.2..3.0_f32,
            other in -0.2..3.0_f32,
            tolerance in 0.0..80.0_f32,
        ) {
            let [low, high] = bounds_of_color(linear, tolerance);
            prop_assert!((low..=high).contains(&linear));
            let steps = 255.0 * (srgb_from_linear(linear) - srgb_from_linear(other)).abs();
            if (steps - tolerance).abs() > 1e-2 {
                prop_assert_eq!((low..=high).contains(&other), steps < tolerance, "{} steps", steps);
            }
        }
    }
}
