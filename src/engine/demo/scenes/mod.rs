//! The built-in scenes.

pub(crate) mod crystal;
pub(crate) mod four_cameras;
pub(crate) mod nine_cameras;
pub(crate) mod orrery;
mod props;

use glam::DVec3;

use crate::capture::{Camera, Intrinsics};

/// A place to look from; world space, meters.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SceneVantage {
    pub(crate) name: &'static str,
    pub(crate) eye: DVec3,
    pub(crate) target: DVec3,
    /// Horizontal angle of view.
    pub(crate) angle_x_deg: f64,
}

/// A place at `eye` that looks at `target`, both in world space, meters, with a horizontal angle of view in degrees.
pub(crate) fn vantage(name: &'static str, eye: [f64; 3], target: [f64; 3], angle_x_deg: f64) -> SceneVantage {
    SceneVantage { name, eye: eye.into(), target: target.into(), angle_x_deg }
}

/// The cameras of a scene: named ones, the arcs of further ones, and viewpoints without a camera.
#[derive(Clone, Debug)]
pub(crate) struct SceneCameras {
    /// The scene's own cameras; the last is the close-up.
    pub(crate) cameras: Vec<SceneVantage>,
    /// Vantages between the cameras, the first of them the home of a live view.
    pub(crate) novel: Vec<SceneVantage>,
    /// What further cameras look at.
    pub(crate) target: DVec3,
    /// Smallest and largest distance of further cameras from `target`, m.
    pub(crate) distance: (f64, f64),
    /// Azimuths of further cameras around `target`, degrees from x toward y.
    pub(crate) azimuth_deg: (f64, f64),
    /// Elevations of further cameras above `target`, degrees.
    pub(crate) elevation_deg: (f64, f64),
}

impl SceneCameras {
    /// The first `count` cameras.
    pub(crate) fn cameras(&self, count: usize, size: (u32, u32)) -> Vec<Camera> {
        let named = self.cameras.iter().take(count).map(|vantage| vantage.camera(size));
        let further = (self.cameras.len()..count).map(|index| self.further(index, size));
        named.chain(further).collect()
    }

    /// A camera beyond the named ones: places are spread evenly by an additive recurrence (Martin Roberts, *The
    /// Unreasonable Effectiveness of Quasirandom Sequences*, 2018), so that any count covers the scene.
    fn further(&self, index: usize, size: (u32, u32)) -> Camera {
        let number = (index - self.cameras.len() + 1) as f64;
        let between =
            |range: (f64, f64), step: f64| range.0 + (range.1 - range.0) * (0.5 + number * step).fract();
        let (sin_a, cos_a) = between(self.azimuth_deg, 0.819_172_513).to_radians().sin_cos();
        let (sin_e, cos_e) = between(self.elevation_deg, 0.671_043_607).to_radians().sin_cos();
        let outward = DVec3::new(cos_e * cos_a, cos_e * sin_a, sin_e);
        let eye = self.target + outward * between(self.distance, 0.549_700_478);
        let angle_x_deg = self.cameras.first().map_or(50.0, |first| first.angle_x_deg);
        let name = format!("extra{}", index - self.cameras.len());
        Camera::look_at(name, intrinsics(size, angle_x_deg), eye, self.target, DVec3::Z)
    }
}

impl SceneVantage {
    /// The camera that looks from here.
    pub(crate) fn camera(&self, size: (u32, u32)) -> Camera {
        Camera::look_at(self.name, intrinsics(size, self.angle_x_deg), self.eye, self.target, DVec3::Z)
    }
}

fn intrinsics(size: (u32, u32), angle_x_deg: f64) -> Intrinsics {
    Intrinsics::from_horizontal_angle(size.0, size.1, angle_x_deg.to_radians())
}
