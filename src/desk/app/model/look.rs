//! Display of linear color in both views: exposure, offset, tone curve, channel and background; and the histogram of a picture.
//!
//! Source of the order and of the names: *tev*, the image viewer of Müller. The filmic curve is the fit of Narkowicz (*ACES filmic tone
//! mapping curve*, 2015), the curve for bright scenes that of Reinhard et al. (*Photographic tone reproduction for digital images*,
//! 2002) on luminance.

use std::collections::BTreeSet;

use glam::DVec3;

pub(crate) use crate::ways_out::figure::Unit;
use overlook_engine::capture::ValueChannel;
use overlook_engine::render::{Picture, ValueColors};
use overlook_engine::settings::{Colormap, ValueScale};

/// How linear values become displayed ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) enum ToneCurve {
    #[default]
    Srgb,
    Gamma,
    Filmic,
    Reinhard,
    FalseColor,
}

impl ToneCurve {
    /// Every curve in the order of the panel: its name, and what it does.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 5] = [
        (Self::Srgb, "sRGB", "The standard curve of displays; what is brighter than white is cut off."),
        (Self::Gamma, "Gamma", "A power curve of your own; what is brighter than white is cut off."),
        (Self::Filmic, "Filmic", "Rolls bright light off as film does (ACES)."),
        (Self::Reinhard, "Reinhard", "Brings any brightness below white, and keeps its color."),
        (Self::FalseColor, "False color", "Stops above and below middle gray (18 %), from −6 to 6."),
    ];
}

/// What is shown of a color.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) enum Channel {
    #[default]
    Color,
    Red,
    Green,
    Blue,
    Luminance,
}

impl Channel {
    /// Every channel in the order of the panel: its name, and what it shows.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 5] = [
        (Self::Color, "RGB", "All three channels."),
        (Self::Red, "R", "Red alone, in gray."),
        (Self::Green, "G", "Green alone, in gray."),
        (Self::Blue, "B", "Blue alone, in gray."),
        (Self::Luminance, "Luminance", "How bright a person sees it (Rec.709)."),
    ];
}

/// The background: the color of pixels at infinity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) enum Background {
    #[default]
    Recorded,
    Transparent,
    Solid([u8; 3]),
}

/// How both views show color.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub(crate) struct Display {
    /// Stops: 1 is twice as bright.
    pub exposure: f32,
    /// Added after the exposure.
    pub offset: f32,
    /// For [`ToneCurve::Gamma`].
    pub gamma: f32,
    pub curve: ToneCurve,
    pub channel: Channel,
    pub background: Background,
    /// Whether cut-off values, and values that are no numbers, are marked.
    pub marks_clipped: bool,
    /// The look of scalar values, where the live view shows them.
    pub values: ValueLook,
}

impl Default for Display {
    fn default() -> Self {
        Self {
            exposure: 0.0,
            offset: 0.0,
            gamma: 2.2,
            curve: ToneCurve::default(),
            channel: Channel::default(),
            background: Background::default(),
            marks_clipped: false,
            values: ValueLook::default(),
        }
    }
}

impl Display {
    /// Whether color is shown as recorded.
    pub(crate) fn is_neutral(&self) -> bool {
        *self == Self { gamma: self.gamma, values: self.values, ..Self::default() }
    }

    /// Whether a pixel is left out of what is written: the background, or nothing at all, where the background is transparent.
    pub(crate) fn leaves_out(&self, rendered: &Picture, at: (usize, usize)) -> bool {
        let is_empty = rendered.inverse_depth[at] == 0.0 || !rendered.shows(at);
        is_empty && self.background == Background::Transparent
    }
}

/// Stops that the exposure may have.
pub(crate) const EXPOSURES: std::ops::RangeInclusive<f32> = -10.0..=10.0;

/// Bars of the histogram of a picture.
pub(crate) const LEVELS: usize = 64;

/// How bright a picture is.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PictureHistogram {
    /// Pixels by their displayed red, green and blue, from black to white.
    pub counts: [[u32; LEVELS]; 3],
    /// Pixels with a channel at white.
    pub at_white: u32,
    /// Pixels with every channel at black.
    pub at_black: u32,
    /// Pixels with a channel that is no finite number.
    pub not_finite: u32,
    pub pixels: u32,
    /// The linear value that one pixel in a hundred exceeds.
    pub bright: f32,
}

impl PictureHistogram {
    /// The exposure at which all but the brightest hundredth lies below white, in steps of a tenth of a stop.
    pub(crate) fn exposure(&self) -> f32 {
        if self.bright <= 0.0 || !self.bright.is_finite() {
            return 0.0;
        }
        let stops = (-self.bright.log2() * 10.0).floor() / 10.0;
        stops.clamp(*EXPOSURES.start(), *EXPOSURES.end())
    }
}

/// What of the values is shown, and how.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub(crate) struct ValueLook {
    /// The number of the channel.
    pub channel: usize,
    pub map: Colormap,
    pub scale: ValueScale,
    /// Between which values colors run; `None` for the channel's own range.
    pub range: Option<[f32; 2]>,
    /// Values outside are gray; `None` where all are shown.
    pub isolated: Option<[f32; 2]>,
}

impl Default for ValueLook {
    fn default() -> Self {
        Self { channel: 0, map: Colormap::Viridis, scale: ValueScale::Linear, range: None, isolated: None }
    }
}

impl ValueLook {
    /// The channel that is shown: the first where there are fewer than chosen; `None` where there are none.
    pub(crate) fn channel_of(self, channels: &[ValueChannel]) -> Option<(usize, &ValueChannel)> {
        let index = if self.channel < channels.len() { self.channel } else { 0 };
        channels.get(index).map(|channel| (index, channel))
    }

    /// Its colors, or in words why the range has none.
    pub(crate) fn colors(self, channel: &ValueChannel) -> Result<ValueColors, String> {
        let colors = ValueColors::new(self.map, self.scale, self.range.unwrap_or(channel.range))?;
        Ok(self.isolated.map_or(colors, |isolated| colors.isolating(isolated)))
    }
}

/// Name and unit of a channel.
pub(crate) fn titled_value(channel: &ValueChannel) -> String {
    if channel.unit.is_empty() {
        channel.name.clone()
    } else {
        format!("{} ({})", channel.name, channel.unit)
    }
}

/// The scalar values of one channel of the samples that hold at a frame.
pub(crate) struct FrameValues {
    /// The number of the channel.
    pub channel: usize,
    /// Without missing and infinite ones.
    pub ascending: Vec<f32>,
}

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
        Self { frame: FrameGuide::Off, locks_aspect: false, axes: true, grid: false, pictures: false }
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
    fn the_exposure_that_fits_brings_bright_pixels_just_below_white() {
        let (counts, at_white, at_black, not_finite) = ([[0; LEVELS]; 3], 0, 0, 0);
        let histogram =
            |bright| PictureHistogram { counts, at_white, at_black, not_finite, pixels: 1, bright };
        assert_eq!(histogram(4.0).exposure(), -2.0);
        assert_eq!(histogram(0.25).exposure(), 2.0);
        assert!(histogram(5.0).exposure().exp2() * 5.0 <= 1.0);
        assert_eq!([0.0, -1.0, f32::INFINITY].map(|bright| histogram(bright).exposure()), [0.0; 3]);
    }

    #[test]
    fn a_display_that_differs_in_anything_but_an_unused_gamma_is_not_neutral() {
        assert!(Display { gamma: 3.0, ..Display::default() }.is_neutral());
        for display in [
            Display { exposure: 0.1, ..Display::default() },
            Display { channel: Channel::Red, ..Display::default() },
            Display { background: Background::Transparent, ..Display::default() },
            Display { marks_clipped: true, ..Display::default() },
        ] {
            assert!(!display.is_neutral(), "{display:?}");
        }
    }

    #[test]
    fn a_channel_that_another_scene_lacks_is_its_first_and_a_range_without_width_says_so() {
        let channels = ["p", "q"].map(|name| {
            let (name, unit) = (name.to_owned(), "Pa".to_owned());
            ValueChannel { name, unit, range: [1.0, 1.0], tolerance: 0.0, is_exact: true }
        });
        let look = ValueLook { channel: 3, ..ValueLook::default() };
        assert_eq!(look.channel_of(&channels), Some((0, &channels[0])));
        assert_eq!(look.channel_of(&[]), None);
        assert!(look.colors(&channels[0]).is_err_and(|why| why.contains("no width")));
        let wide = ValueLook { range: Some([0.0, 2.0]), isolated: Some([0.5, 1.0]), ..look };
        let colors = wide.colors(&channels[0]).unwrap();
        assert!(colors.color(0.4) == colors.color(f32::NAN) && colors.color(0.6) != colors.color(f32::NAN));
    }

    #[test]
    fn a_third_point_begins_a_new_distance() {
        let mut ruler = Ruler::default();
        ruler.pick(DVec3::ZERO);
        assert_eq!(ruler.distance(), None);
        ruler.pick(DVec3::new(3.0, 4.0, 0.0));
        assert_eq!(ruler.distance(), Some(5.0));
        ruler.pick(DVec3::X);
        assert_eq!((ruler.distance(), ruler.points.len()), (None, 1));
    }
}
