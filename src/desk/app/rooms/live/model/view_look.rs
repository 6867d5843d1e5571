//! The surroundings of the live view's picture (guides, the cameras that are on, a measured distance), and commands for them.

use std::collections::BTreeSet;

use glam::DVec3;

/// Which picture's frame is drawn in the live view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) enum FrameGuide {
    #[default]
    Off,
    Camera,
    Export,
}

impl FrameGuide {
    /// Every choice in the order of the panel: its name, and what it shows.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 3] = [
        (Self::Off, "Off", "No frame."),
        (Self::Camera, "Camera", "What the camera that the lens was taken from sees; the rest is darkened."),
        (Self::Export, "Export", "What exported pictures and videos show; the rest is darkened."),
    ];
}

/// What is drawn over the live view's picture to find one's way.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default)]
#[expect(clippy::struct_excessive_bools, reason = "switches of the panel, each by its name")]
pub(crate) struct Guides {
    /// Whose frame is shown.
    pub frame: FrameGuide,
    /// Whether the picture has the shape of that frame, of the camera's where none is shown.
    pub locks_aspect: bool,
    pub axes: bool,
    pub grid: bool,
    /// Whether cameras are drawn with their pictures.
    pub pictures: bool,
}

impl Default for Guides {
    fn default() -> Self {
        Self { frame: FrameGuide::Off, locks_aspect: false, axes: true, grid: false, pictures: true }
    }
}

/// The cameras whose samples the live view shows.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct ShownCameras {
    pub off: BTreeSet<usize>,
    /// The only one that is shown, whatever is off.
    pub solo: Option<usize>,
}

impl ShownCameras {
    /// Whether a camera's samples are shown.
    pub(crate) fn shows(&self, camera: usize) -> bool {
        self.solo.map_or_else(|| !self.off.contains(&camera), |solo| solo == camera)
    }

    /// Shows or leaves out the samples of one.
    pub(crate) fn switch(&mut self, camera: usize, on: bool) {
        if on {
            self.off.remove(&camera);
        } else {
            self.off.insert(camera);
        }
    }

    /// Whether all are.
    pub(crate) fn shows_all(&self) -> bool {
        self.off.is_empty() && self.solo.is_none()
    }
}

/// The directions that may be up, with name and help. `None` is the one of the capture.
pub(crate) const UP_DIRECTIONS: [(Option<DVec3>, &str, &str); 7] = [
    (None, "As recorded", "Up as in the capture's files."),
    (Some(DVec3::X), "+X", UP_HELP),
    (Some(DVec3::NEG_X), "−X", UP_HELP),
    (Some(DVec3::Y), "+Y", UP_HELP),
    (Some(DVec3::NEG_Y), "−Y", UP_HELP),
    (Some(DVec3::Z), "+Z", UP_HELP),
    (Some(DVec3::NEG_Z), "−Z", UP_HELP),
];

const UP_HELP: &str = "The axis of the world that points up. Choose it if a capture is shown on its side: orbiting, the horizon and the ground \
     follow it. The choice is remembered with the capture; for other windows write \"up\" into the manifest, as in \"up\": [0, 1, 0].";

/// The unit of the scene's lengths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Unit {
    #[default]
    Meters,
    Centimeters,
    Millimeters,
    None,
}

impl Unit {
    /// Every unit: its name, and what it means.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 4] = [
        (Self::Meters, "m", "One unit of the scene is a meter."),
        (Self::Centimeters, "cm", "One unit of the scene is a centimeter."),
        (Self::Millimeters, "mm", "One unit of the scene is a millimeter."),
        (Self::None, "units", "The scene has no unit of length."),
    ];

    /// Its name.
    pub(crate) fn name(self) -> &'static str {
        Self::ALL.iter().find(|(unit, ..)| *unit == self).map_or("", |(_, name, _)| name)
    }

    /// A length with its unit.
    pub(crate) fn length(self, length: f64) -> String {
        format!("{} {}", crate::app::model::text::significant(length), self.name())
    }
}

/// A distance that is measured between two points.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Ruler {
    /// Whether clicks pick points.
    pub active: bool,
    /// World space; two at most.
    pub points: Vec<DVec3>,
}

impl Ruler {
    /// The distance, in units of the scene; `None` before both points are picked.
    pub(crate) fn distance(&self) -> Option<f64> {
        let [a, b] = self.points.as_slice() else { return None };
        Some((*a - *b).length())
    }

    /// Lets clicks pick points, or no longer.
    pub(crate) fn measure(&mut self, active: bool) {
        *self = Self { active, points: Vec::new() };
    }

    /// Takes a point; a third one begins anew.
    pub(crate) fn pick(&mut self, point_in_world: DVec3) {
        if self.points.len() > 1 {
            self.points.clear();
        }
        self.points.push(point_in_world);
    }
}

/// Slowest and fastest flight, in the speed of a first run.
pub(crate) const FLY_SPEEDS: std::ops::RangeInclusive<f64> = 0.01..=100.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_third_point_begins_a_new_distance() {
        let mut ruler = Ruler::default();
        ruler.pick(DVec3::ZERO);
        assert_eq!(ruler.distance(), None);
        ruler.pick(DVec3::new(3.0, 4.0, 0.0));
        assert_eq!(ruler.distance(), Some(5.0));
        ruler.pick(DVec3::X);
        assert_eq!((ruler.distance(), ruler.points.len()), (None, 1));
        assert_eq!(
            (Unit::Meters.length(1.5), Unit::None.length(0.25)),
            ("1.50 m".into(), "0.25 units".into())
        );
    }

    #[test]
    fn a_camera_alone_is_shown_even_where_it_is_off() {
        let mut cameras = ShownCameras { off: [1].into(), solo: None };
        assert_eq!([0, 1, 2].map(|camera| cameras.shows(camera)), [true, false, true]);
        cameras.solo = Some(1);
        assert_eq!([0, 1, 2].map(|camera| cameras.shows(camera)), [false, true, false]);
    }
}
