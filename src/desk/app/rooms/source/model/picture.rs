//! The picture of the left view: what it can show, what it was made from, and what its colors mean.

use std::sync::Arc;

use egui::ColorImage;

use crate::app::model::Same;
use crate::app::rooms::colors::model::display::{Display, PictureHistogram};
use overlook_engine::grid::Grid;
use overlook_engine::preprocess::inspect::FrameInspection;

/// What the left view shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub(crate) enum Overlay {
    #[default]
    Color,
    Depth,
    Normals,
    SamplingRatio,
    WhoWon,
    Agreement,
    ViewDependence,
    Split,
    Tiles,
}

impl Overlay {
    /// Whether it shows what became of the pixels.
    pub(crate) fn needs_verdicts(self) -> bool {
        !matches!(self, Self::Color | Self::Depth)
    }

    /// Whether its colors are those of cameras.
    pub(crate) fn names_cameras(self) -> bool {
        self == Self::WhoWon
    }

    /// Every choice in the order of the menu: its name, and what it shows.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 9] = [
        (Self::Color, "Picture", "The picture as the camera recorded it."),
        (
            Self::WhoWon,
            "Kept by",
            "Pruned pixels in the color of the camera whose sample replaces them; kept pixels show their own picture.",
        ),
        (
            Self::SamplingRatio,
            "Sampling",
            "How densely this camera samples each point against another: purple where this one is denser, orange where the other is.",
        ),
        (Self::Agreement, "Agreement", AGREEMENT),
        (
            Self::ViewDependence,
            "View dependence",
            "How far the color of each point differs between cameras: by highlights, mirrors and different exposures.",
        ),
        (Self::Split, "Motion", MOTION),
        (
            Self::Tiles,
            "Tiles",
            "The share of samples kept in each 16 × 16 tile of the store; empty tiles cost nothing.",
        ),
        (Self::Depth, "Depth", "How far away each pixel is: light is near."),
        (Self::Normals, "Normals", "Which way each surface faces, given or estimated."),
    ];
}

/// What either view's *Motion* shows.
pub(crate) const MOTION: &str = "For how long samples are stored: once for all frames, once for several frames where they hold that long, or for this \
     frame alone.";

/// What either view's *Agreement* shows.
pub(crate) const AGREEMENT: &str =
    "Whether other cameras confirm each sample, contradict it by majority, or do neither.";

/// What a left picture was made from; a picture with an equal key is the same picture.
#[derive(Clone, PartialEq)]
pub(crate) struct SourceKey {
    pub scene: u64,
    pub camera: usize,
    pub frame: usize,
    pub overlay: Overlay,
    /// For the sampling ratio: against which camera, or the best other.
    pub against: Option<usize>,
    /// The camera that alone is shown in its color; `None` for all.
    pub isolated: Option<usize>,
    pub display: Display,
    /// Dark or light, as overlays use colors of the theme.
    pub dark: bool,
    /// The verdicts; `None` for the bare picture.
    pub inspection: Option<Same<FrameInspection>>,
}

/// What the colors of a picture mean.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Legend {
    /// Colors are colors.
    Plain,
    /// Depth from `near` to `far`, in the capture's unit, and the share of pixels without depth, 0 to 1.
    Depth { near: f32, far: f32, without: f32 },
    /// log₂ r from −[`RATIO_RANGE`] to [`RATIO_RANGE`].
    Ratio,
    /// Pixels that each camera won, and those that were kept.
    Winners {
        kept: u64,
        /// Pixels lost to each camera.
        lost_to: Vec<u64>,
        /// Pixels dropped without a witness.
        dropped: u64,
        /// Pixels without depth.
        invalid: u64,
    },
    /// Pixels per class.
    Split {
        /// The same over all frames.
        background: u64,
        /// The same over several frames.
        lasting: u64,
        /// Of this frame alone.
        foreground: u64,
        invalid: u64,
    },
    /// Pixels by the votes of the other cameras.
    Agreement { confirmed: u64, contradicted: u64, alone: u64, invalid: u64 },
    /// How far colors differ from those of other cameras, from 0 to [`VIEW_DEPENDENCE_RANGE`]. Counts pixels that differ visibly, that
    /// do not, and that no other camera shows finely enough.
    ViewDependence { visible: u64, alike: u64, unknown: u64 },
    /// Kept share of each tile, 0 to 1.
    Tiles(Grid<f32>),
}

/// Cameras that a picture shows in colors of their own where there are more than [`CROWD`]; the rest are *others*.
const NAMED: usize = 12;
const CROWD: usize = 16;

/// Cameras by the pixels that each won, most first, without those that won none; and how many of them have a color of their own.
pub(crate) fn ranked(won_by: &[u64]) -> (Vec<usize>, usize) {
    let mut ranked: Vec<usize> = (0..won_by.len()).filter(|camera| won_by[*camera] > 0).collect();
    ranked.sort_by_key(|camera| std::cmp::Reverse(won_by[*camera]));
    let named = if ranked.len() > CROWD { NAMED } else { ranked.len() };
    (ranked, named)
}

/// log₂ r at either end of the scale: eight times denser or coarser.
pub(crate) const RATIO_RANGE: f32 = 3.0;

/// 8-bit sRGB steps at the upper end of the scale of *View dependence*.
pub(crate) const VIEW_DEPENDENCE_RANGE: f32 = 32.0;

/// The left picture.
pub(crate) struct SourcePicture {
    /// Its pixels; of a very large picture every second, third, …
    pub image: Arc<ColorImage>,
    /// Columns and rows of the picture itself.
    pub size: [usize; 2],
    pub legend: Legend,
    /// How bright it is; `None` where its colors are no picture's.
    pub histogram: Option<PictureHistogram>,
}
