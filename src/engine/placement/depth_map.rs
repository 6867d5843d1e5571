//! What is seen from a place, in all directions: a z-buffer on the six sides of a cube.
//!
//! Source: the items of a z-buffer tell what a view shows, as H. Weghorst, G. Hooper, D. Greenberg, *Improved Computational Methods for
//! Ray Tracing*, 1984, has it. What differs: a surfel covers its own width, so that surfaces close by have no gaps; and the sides that
//! were not seen hide things as well.

use glam::{DVec3, Vec3};

use super::surfels::Surfel;

/// Columns and rows of a side: a pixel is about half a degree wide.
const SIDE: usize = 160;

/// Half of the pixels that a surfel covers, at most.
const WIDEST: f32 = 6.0;

/// A surfel is seen if it is no farther than the nearest by more than this share of its distance.
const SAME: f32 = 0.02;

/// Or if it is no farther from the tangent plane of the nearest than so many widths of the wider of both: of a slanted surface, what is
/// nearer in the same pixel is the surface itself.
const SAME_PLANE_WIDTHS: f64 = 0.75;

/// The smallest cosine of the slant at which a surfel is seen: from the side it shows nothing.
const EDGE_ON: f32 = 0.05;

/// Pixel widths at distance 1 in the middle of a side, where they are the widest.
const PIXEL: f32 = 2.0 / SIDE as f32;

/// Distance and index of the surfel that is nearest in each direction.
struct DepthMap(Vec<(f32, u32)>);

/// A surfel as it lies from a place.
struct Seen {
    side: usize,
    /// Pixels.
    x: f32,
    y: f32,
    distance: f32,
    /// Cosine of its slant; negative from behind.
    cosine: f32,
}

impl Seen {
    fn of(surfel: &Surfel, eye: DVec3) -> Option<Self> {
        let away: Vec3 = (surfel.point_in_world - eye).as_vec3();
        let distance = away.length();
        let size = away.abs();
        let axis = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let along = away[axis];
        if !(distance > 0.0 && distance.is_finite()) {
            return None;
        }
        let pixel = |other: usize| (away[(axis + other) % 3] / along.abs() + 1.0) / PIXEL;
        let side = 2 * axis + usize::from(along < 0.0);
        let cosine = -surfel.normal_in_world.dot(away) / distance;
        Some(Self { side, x: pixel(1), y: pixel(2), distance, cosine })
    }

    fn index(&self) -> usize {
        let at = |place: f32| (place.max(0.0) as usize).min(SIDE - 1);
        (self.side * SIDE + at(self.y)) * SIDE + at(self.x)
    }
}

impl DepthMap {
    fn of(surfels: &[Surfel], eye: DVec3) -> Self {
        let mut map = Self(vec![(f32::INFINITY, 0); 6 * SIDE * SIDE]);
        for (index, surfel) in (0..).zip(surfels) {
            if let Some(seen) = Seen::of(surfel, eye) {
                map.cover(&seen, index, surfel.width as f32);
            }
        }
        map
    }

    fn cover(&mut self, seen: &Seen, index: u32, width: f32) {
        // A slanted disk is as wide as it is only across its slant.
        let half = (0.5 * width * seen.cosine.abs().max(0.2) / seen.distance / PIXEL).min(WIDEST);
        let range = |place: f32| {
            let at = |place: f32| (place.max(0.0) as usize).min(SIDE - 1);
            at(place - half)..=at(place + half)
        };
        for row in range(seen.y) {
            for column in range(seen.x) {
                let nearest = &mut self.0[(seen.side * SIDE + row) * SIDE + column];
                if seen.distance < nearest.0 {
                    *nearest = (seen.distance, index);
                }
            }
        }
    }
}

/// Whether a surfel lies in the tangent plane of another one.
fn is_of_plane(surfel: &Surfel, other: &Surfel) -> bool {
    let apart = (surfel.point_in_world - other.point_in_world).dot(other.normal_in_world.as_dvec3());
    apart.abs() <= SAME_PLANE_WIDTHS * surfel.width.max(other.width)
}

/// The indices of the surfels that are seen from a place, ascending, of every first, second … one: all others only hide them.
pub(super) fn seen_from(surfels: &[Surfel], every: usize, eye: DVec3) -> Vec<u32> {
    let map = DepthMap::of(surfels, eye);
    let is_seen = |surfel: &Surfel| {
        let Some(seen) = Seen::of(surfel, eye).filter(|seen| seen.cosine > EDGE_ON) else { return false };
        let (distance, nearest) = map.0[seen.index()];
        seen.distance * (1.0 - SAME) <= distance || is_of_plane(surfel, &surfels[nearest as usize])
    };
    let counted = (0..).zip(surfels).step_by(every);
    counted.filter(|(_, surfel)| is_seen(surfel)).map(|(index, _)| index).collect()
}
