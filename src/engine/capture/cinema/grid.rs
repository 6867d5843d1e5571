//! The viewpoints of a database: a grid of angles around what the cameras look at.

use glam::DVec3;

use super::viewpoint::{DatabaseCamera, VIEW_ANGLE, axes, direction};
use crate::capture::camera::Camera;

/// Angles, evenly spread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AngleRange {
    /// The first, degrees.
    pub first: f64,
    /// The last, degrees. A whole turn has its first angle once.
    pub last: f64,
    /// How many.
    pub count: usize,
}

impl AngleRange {
    /// All of them, degrees.
    pub fn angles(self) -> impl Iterator<Item = f64> {
        let Self { first, last, count } = self;
        let is_turn = ((last - first).abs() - 360.0).abs() < 1e-9;
        let steps = if is_turn { count } else { count.saturating_sub(1) }.max(1);
        (0..count).map(move |nth| first + (last - first) * nth as f64 / steps as f64)
    }
}

/// The viewpoints at some angles around `pivot`, as far from it as the nearest of the `cameras` and with the lens of the first: each with
/// its `phi` and `theta` in degrees. Without ranges the angles are those between which the cameras stand.
#[must_use]
pub fn grid(
    cameras: &[Camera],
    pivot: DVec3,
    up: DVec3,
    ranges: [Option<AngleRange>; 2],
    counts: [usize; 2],
) -> Vec<([f64; 2], DatabaseCamera)> {
    let aside = cameras.iter().map(|camera| camera.position_in_world() - pivot);
    let radius = aside.clone().map(DVec3::length).fold(f64::INFINITY, f64::min);
    let [along, across] = axes(up);
    let azimuths: Vec<f64> =
        aside.clone().map(|at| at.dot(across).atan2(at.dot(along)).to_degrees()).collect();
    let heights: Vec<f64> = aside
        .map(|at| (at.dot(up) / at.length().max(f64::MIN_POSITIVE)).clamp(-1.0, 1.0).asin().to_degrees())
        .collect();
    let own = [range_of_turn(azimuths), range_of(heights)];
    let [phi, theta] = [0, 1].map(|nth| {
        ranges[nth].unwrap_or(AngleRange { first: own[nth][0], last: own[nth][1], count: counts[nth] })
    });
    let view_angle = cameras.first().map_or(VIEW_ANGLE, |camera| {
        let lens = camera.intrinsics.in_perspective_from(radius);
        2.0 * (0.5 * f64::from(lens.height) / lens.fy).atan().to_degrees()
    });
    let at = |phi: f64, theta: f64| DatabaseCamera {
        position: pivot + direction(phi, theta, up) * radius,
        focal_point: pivot,
        up,
        view_angle,
        parallel_scale: None,
    };
    theta.angles().flat_map(|theta| phi.angles().map(move |phi| ([phi, theta], at(phi, theta)))).collect()
}

/// The least and the largest of some angles.
fn range_of(angles: Vec<f64>) -> [f64; 2] {
    angles
        .into_iter()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], angle| [least.min(angle), most.max(angle)])
}

/// The shortest way around a circle that passes all of some angles.
fn range_of_turn(mut angles: Vec<f64>) -> [f64; 2] {
    angles.sort_by(f64::total_cmp);
    let Some((first, last)) = angles.first().copied().zip(angles.last().copied()) else { return [0.0, 0.0] };
    let gaps = angles.windows(2).map(|pair| (pair[1] - pair[0], [pair[1], pair[0] + 360.0]));
    let widest = gaps.chain([(first + 360.0 - last, [first, last])]).max_by(|a, b| a.0.total_cmp(&b.0));
    widest.map_or([first, last], |(_, range)| range)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::camera::Intrinsics;

    #[test]
    fn angles_are_spread_evenly_and_a_turn_ends_before_it_begins_again() {
        let all = |first, last, count| AngleRange { first, last, count }.angles().collect::<Vec<_>>();
        assert_eq!(all(-10.0, 10.0, 3), [-10.0, 0.0, 10.0]);
        assert_eq!(all(0.0, 360.0, 4), [0.0, 90.0, 180.0, 270.0]);
        assert_eq!(all(5.0, 9.0, 1), [5.0]);
    }

    #[test]
    fn viewpoints_lie_between_the_cameras_also_where_they_stand_across_half_a_turn() {
        let lens = Intrinsics::from_horizontal_angle(64, 48, 1.0);
        let camera = |phi: f64, theta: f64| {
            Camera::look_at("c", lens, direction(phi, theta, DVec3::Z) * 5.0, DVec3::ZERO, DVec3::Z)
        };
        let cameras = [camera(170.0, 10.0), camera(-160.0, 30.0), camera(180.0, 20.0)];
        let views = grid(&cameras, DVec3::ZERO, DVec3::Z, [None, None], [3, 2]);
        let angles: Vec<[f64; 2]> = views.iter().map(|(angles, _)| angles.map(f64::round)).collect();
        assert_eq!(
            angles,
            [[170.0, 10.0], [185.0, 10.0], [200.0, 10.0], [170.0, 30.0], [185.0, 30.0], [200.0, 30.0]]
        );
        for (_, view) in views {
            assert!((view.position.length() - 5.0).abs() < 1e-9);
            let focal = view.focal_length_px(48.0).unwrap();
            assert!((focal - lens.fy).abs() < 1e-9, "{focal}");
        }
    }
}
