//! Lens distortion: where a lens puts what a pinhole would put elsewhere.
//!
//! Source: `OpenCV`'s camera model (radial with up to six coefficients, tangential with two) and its fisheye model (Kannala,
//! Brandt: A Generic Camera Model and Calibration Method, PAMI 2006); COLMAP's `FOV` (Devernay, Faugeras: Straight Lines Have to Be
//! Straight, 2001). Coordinates are those of the image plane at z = 1.

use glam::{DMat2, DVec2};

/// How a lens differs from a pinhole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Distortion {
    model: DistortionModel,
    /// Beyond this distance from the axis, undistorted, the model folds back: such rays are not seen.
    max_radius: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum DistortionModel {
    /// `(1 + k1 r² + k2 r⁴ + k3 r⁶) / (1 + k4 r² + k5 r⁴ + k6 r⁶)`, and `p1`, `p2`.
    RadialTangential { k: [f64; 6], p: [f64; 2] },
    /// `θ (1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸)`.
    Fisheye([f64; 4]),
    /// `atan(2 r tan(ω/2)) / ω`.
    FieldOfView(f64),
}

/// Rays farther from the axis than this are not looked at: 84°.
const FARTHEST: f64 = 10.0;
/// Steps in which a model is followed outward.
const STEPS: usize = 4000;

impl Distortion {
    /// Radial coefficients `k1` to `k6` and tangential ones; `None` where all are 0.
    pub(crate) fn radial_tangential(k: [f64; 6], p: [f64; 2]) -> Option<Self> {
        let is_bent = k.iter().chain(&p).any(|value| *value != 0.0);
        is_bent.then(|| Self::new(DistortionModel::RadialTangential { k, p }))
    }

    /// A fisheye; also with all coefficients 0 it is no pinhole.
    pub(crate) fn fisheye(k: [f64; 4]) -> Self {
        Self::new(DistortionModel::Fisheye(k))
    }

    /// COLMAP's `FOV`; `None` where it is 0.
    pub(crate) fn field_of_view(omega: f64) -> Option<Self> {
        (omega != 0.0).then(|| Self::new(DistortionModel::FieldOfView(omega)))
    }

    fn new(model: DistortionModel) -> Self {
        let radius = |step: usize| FARTHEST * step as f64 / STEPS as f64;
        let folds = (1..=STEPS).find(|step| model.radius(radius(*step)) <= model.radius(radius(step - 1)));
        Self { model, max_radius: folds.map_or(FARTHEST, |step| radius(step - 1)) }
    }

    /// Where the lens puts a ray; `None` where it does not see it.
    pub(crate) fn distort(&self, ideal: DVec2) -> Option<DVec2> {
        let squared = ideal.length_squared();
        let is_seen = squared <= self.max_radius * self.max_radius;
        let r = squared.sqrt();
        let scaled = if r > 0.0 { ideal * (self.model.radius(r) / r) } else { DVec2::ZERO };
        let tangential = match self.model {
            DistortionModel::RadialTangential { p: [p1, p2], .. } => {
                let (x, y) = (ideal.x, ideal.y);
                DVec2::new(
                    2.0 * p1 * x * y + p2 * (squared + 2.0 * x * x),
                    p1 * (squared + 2.0 * y * y) + 2.0 * p2 * x * y,
                )
            }
            _ => DVec2::ZERO,
        };
        is_seen.then_some(scaled + tangential)
    }

    /// The ray that the lens puts here; `None` if no ray arrives here.
    pub(crate) fn undistort(&self, distorted: DVec2) -> Option<DVec2> {
        const ITERATIONS: usize = 20;
        const CLOSE: f64 = 1e-10;
        const STEP: f64 = 1e-6;
        let target = distorted.length();
        let mut ideal =
            if target > 0.0 { distorted * (self.ideal_radius(target)? / target) } else { distorted };
        // What the tangential part leaves is small, and vanishes in a step or two of Newton's.
        for _ in 0..ITERATIONS {
            let at = self.distort(ideal)?;
            let off = at - distorted;
            if off.length_squared() < CLOSE * CLOSE {
                return Some(ideal);
            }
            let across =
                [DVec2::X, DVec2::Y].map(|axis| Some((self.distort(ideal + STEP * axis)? - at) / STEP));
            let [Some(by_x), Some(by_y)] = across else { return None };
            ideal -= DMat2::from_cols(by_x, by_y).inverse() * off;
        }
        (self.distort(ideal)?.distance(distorted) < 1e-6).then_some(ideal)
    }

    /// The radius that the lens puts at `target`, by false position (the Illinois rule), which
    /// stays within bounds: the model rises up to `max_radius`.
    fn ideal_radius(&self, target: f64) -> Option<f64> {
        let (mut low, mut high) = (0.0, self.max_radius);
        if let DistortionModel::RadialTangential { k: [k1, ..], p } = self.model
            && p == [0.0; 2]
            && k1.abs() * target * target < 1e-12
        {
            return Some(target);
        }
        if self.model.radius(high) < target {
            // The tangential part may bring it within reach.
            return (self.model.radius(high) > 0.98 * target).then_some(high);
        }
        let (mut off_low, mut off_high) = (-target, self.model.radius(high) - target);
        let mut was_below = None;
        for _ in 0..100 {
            let between = high - off_high * (high - low) / (off_high - off_low);
            let off = self.model.radius(between) - target;
            if off.abs() < 1e-13 * target {
                return Some(between);
            }
            // An end that stays a second time counts half, so that both ends move.
            let is_below = off < 0.0;
            let share = if was_below == Some(is_below) { 0.5 } else { 1.0 };
            if is_below {
                (low, off_low, off_high) = (between, off, share * off_high);
            } else {
                (high, off_high, off_low) = (between, off, share * off_low);
            }
            was_below = Some(is_below);
        }
        Some(0.5 * (low + high))
    }
}

impl DistortionModel {
    /// The distance from the axis where the lens puts a ray at distance `r`, without the tangential part.
    fn radius(&self, r: f64) -> f64 {
        match *self {
            Self::RadialTangential { k, .. } => {
                let s = r * r;
                let up = 1.0 + s * (k[0] + s * (k[1] + s * k[2]));
                let down = 1.0 + s * (k[3] + s * (k[4] + s * k[5]));
                r * up / down
            }
            Self::Fisheye(k) => {
                let theta = r.atan();
                let s = theta * theta;
                theta * (1.0 + s * (k[0] + s * (k[1] + s * (k[2] + s * k[3]))))
            }
            Self::FieldOfView(omega) => (2.0 * r * (0.5 * omega).tan()).atan() / omega,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn models() -> Vec<Distortion> {
        vec![
            Distortion::radial_tangential([0.2624, -0.9531, 1.1633, 0.0, 0.0, 0.0], [-0.0054, 0.0026])
                .unwrap(),
            Distortion::radial_tangential([-0.3, 0.1, 0.0, 0.01, 0.0, 0.0], [0.001, 0.0]).unwrap(),
            Distortion::fisheye([0.05, -0.01, 0.0, 0.0]),
            Distortion::field_of_view(0.9).unwrap(),
        ]
    }

    #[test]
    fn undistorting_is_the_inverse_of_distorting() {
        for lens in models() {
            for step in 0..200 {
                let ideal = DVec2::from_angle(f64::from(step)) * (0.004 * f64::from(step));
                let Some(distorted) = lens.distort(ideal) else { continue };
                let back = lens.undistort(distorted).unwrap();
                assert!(back.distance(ideal) < 1e-8, "{lens:?} {ideal} {back}");
            }
        }
    }

    #[test]
    fn rays_that_a_model_folds_back_are_not_seen() {
        let folding = Distortion::radial_tangential([-0.5, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0; 2]).unwrap();
        assert!(folding.distort(DVec2::new(0.8, 0.0)).is_some());
        assert_eq!(folding.distort(DVec2::new(0.9, 0.0)), None, "r (1 − r²/2) falls beyond 0.816");
        assert_eq!(folding.undistort(DVec2::new(0.6, 0.0)), None);
        assert!(Distortion::radial_tangential([0.0; 6], [0.0; 2]).is_none());
    }
}
