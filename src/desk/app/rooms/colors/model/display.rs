//! Display of linear color in both views: exposure, offset, tone curve, channel and background; and the histogram of a picture.
//!
//! Source of the order and of the names: *tev*, the image viewer of Müller. The filmic curve is the fit of Narkowicz (*ACES filmic tone
//! mapping curve*, 2015), the curve for bright scenes that of Reinhard et al. (*Photographic tone reproduction for digital images*,
//! 2002) on luminance.

use super::value_look::ValueLook;
use overlook_engine::render::Picture;

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
    /// Of [`ToneCurve::Gamma`].
    pub gamma: f32,
    pub curve: ToneCurve,
    pub channel: Channel,
    pub background: Background,
    /// Whether cut-off values, and values that are no numbers, are marked.
    pub marks_clipped: bool,
    /// Of scalar values, where the live view shows them.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exposure_that_fits_brings_bright_pixels_just_below_white() {
        let histogram = |bright| PictureHistogram {
            counts: [[0; LEVELS]; 3],
            at_white: 0,
            at_black: 0,
            not_finite: 0,
            pixels: 1,
            bright,
        };
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
}
