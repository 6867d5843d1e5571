//! The pictures of both views: what they can show, what they were made from, and what their colors mean.

use std::sync::Arc;
use std::time::Duration;

use egui::{ColorImage, Rect, Vec2};

use crate::app::model::look::{Display, PictureHistogram, ShownCameras};
use crate::app::model::motion_budget::MotionQuality;
use crate::app::model::same::Same;
use crate::app::model::texture::Texture;
use overlook_engine::capture::Camera;
use overlook_engine::grid::Grid;
use overlook_engine::preprocess::inspect::FrameInspection;
use overlook_engine::render::gpu::ScreenTexture;
use overlook_engine::render::{Painter, Picture, RenderStats, Vantage};
use overlook_engine::samples::SampleSet;
use overlook_engine::settings::RenderSettings;
use overlook_engine::store::playback::Playback;

/// What the colors of the right view mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) enum ColorBy {
    Picture,
    Camera,
    Agreement,
    Span,
    SamplingRate,
    Value,
}

impl ColorBy {
    /// Every choice in the order of the menu: its name, and what it shows.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 6] = [
        (Self::Picture, "Picture", "The scene, rendered from the kept samples."),
        (Self::Camera, "Camera", "Each pixel in the color of the camera whose sample it shows."),
        (Self::Agreement, "Agreement", AGREEMENT),
        (Self::Span, "Motion", MOTION),
        (
            Self::SamplingRate,
            "Sampling",
            "Distance between samples over distance between pixels: purple where samples are denser than pixels, orange where pixels are denser.",
        ),
        (
            Self::Value,
            "Value",
            "A scalar value of the samples, as the capture gave it; the Color panel chooses which, and its colors.",
        ),
    ];
}

/// How the live view shows pixels that no sample reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) enum HoleDisplay {
    #[serde(alias = "Dimmed")]
    Filled,
    Hatched,
}

impl HoleDisplay {
    /// Every choice in the order of the toolbar: its name, and what it shows.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 2] = [
        (
            Self::Filled,
            "Fill",
            "Pixels that no sample reached get invented colors, continued from the background (H).",
        ),
        (Self::Hatched, "Show", "Pixels that no sample reached are hatched, over what fills them (H)."),
    ];

    /// The other of both.
    pub(crate) fn other(self) -> Self {
        match self {
            Self::Filled => Self::Hatched,
            Self::Hatched => Self::Filled,
        }
    }
}

/// What a right picture was made from; a picture with an equal key is the same picture.
#[derive(Clone, PartialEq)]
pub(crate) struct LiveKey {
    pub scene: u64,
    pub samples: Same<SampleSet>,
    /// The reader of the frame's samples from a file; `None` if all are in memory.
    pub playback: Option<Same<Playback>>,
    /// Where from, and when.
    pub vantage: Vantage,
    pub settings: RenderSettings,
    pub color_by: ColorBy,
    /// What was found at the frame, where colors tell of agreement; `None` while it is worked out, and for stores.
    pub inspection: Option<Same<FrameInspection>>,
    pub holes: HoleDisplay,
    pub display: Display,
    pub cameras: ShownCameras,
    /// Dark or light, as holes use a color of the theme.
    pub dark: bool,
    /// Whether the next picture follows at once: then its pixels are not read back, and may stay on the GPU.
    pub in_motion: bool,
    /// What it keeps of the settings while the view moves; `None` at rest.
    pub quality: Option<MotionQuality>,
    /// Its pixels along one pixel of a picture in motion.
    pub per_coarse_pixel: f64,
}

impl LiveKey {
    /// Width of the stripes over holes, pixels: on the screen as wide in motion as at rest.
    pub(crate) fn stripe(&self) -> usize {
        (STRIPE * self.per_coarse_pixel).round().max(1.0) as usize
    }
}

/// Width of the stripes over holes, pixels of a picture in motion.
const STRIPE: f64 = 6.0;

/// The right picture.
pub(crate) struct LivePicture {
    /// The rendered samples. For a store played from disk: those of this frame that the vantage needs.
    pub samples: Arc<SampleSet>,
    /// Columns and rows.
    pub size: [usize; 2],
    pub pixels: PixelSource,
    /// How bright it is; `None` where its colors are no picture's, and in motion.
    pub histogram: Option<PictureHistogram>,
    pub stats: RenderStats,
    /// How many of the holes show the background in a direction in which cameras saw it; 0 while pixels stay on the graphics card.
    pub sky_holes: u64,
    /// From the request to the finished picture, reading included.
    pub took: Duration,
    pub painter: Painter,
    /// Why the renderer of the settings did not paint.
    pub notice: Option<String>,
    /// What could not be read of a store played from disk so far, one line each.
    pub damage: Vec<String>,
}

/// Where the pixels of a picture are.
pub(crate) enum PixelSource {
    /// On the device that draws the window.
    OnAdapter(ScreenTexture),
    InMemory {
        image: Arc<ColorImage>,
        /// What the renderer gave: depths, and whose samples are shown.
        rendered: Arc<Picture>,
    },
}

impl LivePicture {
    /// What the renderer gave; `None` while pictures in motion stay on the graphics card.
    pub(crate) fn rendered(&self) -> Option<&Arc<Picture>> {
        match &self.pixels {
            PixelSource::InMemory { rendered, .. } => Some(rendered),
            PixelSource::OnAdapter(_) => None,
        }
    }
}

/// What is to be carried.
#[derive(Clone, PartialEq)]
pub(crate) struct CarryKey {
    pub scene: u64,
    pub picture: Same<LivePicture>,
    /// Where the picture was taken from.
    pub from: Camera,
    pub to: Camera,
}

/// A live picture as another viewpoint shows it.
pub(crate) struct CarriedLook {
    pub image: Arc<ColorImage>,
    pub inverse_depth: Grid<f32>,
}

/// The [`CarriedLook`] that is shown.
pub(crate) struct ShownCarried {
    pub camera: Camera,
    pub inverse_depth: Grid<f32>,
    pub texture: Texture,
}

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
    /// Pixels that are kept, that are lost to each camera, that are dropped without a witness, and that have no depth.
    Winners { kept: u64, lost_to: Vec<u64>, dropped: u64, invalid: u64 },
    /// Pixels of each class of *Motion* (all frames, several, one) or *Agreement* (confirmed, contradicted, neither); and without depth.
    Classes { counts: [u64; 3], invalid: u64 },
    /// How far colors differ from those of other cameras, from 0 to [`VIEW_DEPENDENCE_RANGE`]. Counts pixels that differ visibly, that
    /// do not, and that no other camera shows finely enough.
    ViewDependence { visible: u64, alike: u64, unknown: u64 },
    /// The ratio of two sampling rates, and the share of pixels that no other camera shows.
    Ratio { unknown: f32 },
    /// Kept share of each tile, 0 to 1.
    Tiles(Grid<f32>),
}

/// Cameras that a picture shows in colors of their own where there are more than [`CROWD`]; the rest are *others*.
const NAMED: usize = 12;
const CROWD: usize = 16;

/// Cameras that won pixels, most first, and how many of them have a color of their own.
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

/// Largest magnification.
const MOST: f32 = 64.0;

/// The part of a picture that a view shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PictureZoom {
    /// Magnification beyond fitting the view, 1 to 64.
    pub zoom: f32,
    /// The picture's point in the middle of the view, as shares of its size.
    pub center: Vec2,
}

impl Default for PictureZoom {
    /// The whole picture.
    fn default() -> Self {
        Self { zoom: 1.0, center: Vec2::splat(0.5) }
    }
}

impl PictureZoom {
    /// Magnified by `zoom` about `center`, as far as that is possible.
    pub(crate) fn new(zoom: f32, center: Vec2) -> Self {
        Self { zoom: zoom.clamp(1.0, MOST), center: center.clamp(Vec2::ZERO, Vec2::splat(1.0)) }
    }

    /// The area of a picture of `size` in the view `canvas`.
    pub(crate) fn placed(self, size: Vec2, canvas: Rect) -> Rect {
        let drawn = size * (canvas.width() / size.x).min(canvas.height() / size.y) * self.zoom;
        Rect::from_min_size(canvas.center() - drawn * self.center, drawn)
    }

    /// Shifted by shares of the picture's size, where it does not fit the view.
    #[must_use]
    pub(crate) fn shifted(self, share: Vec2) -> Self {
        if self.zoom > 1.0 { Self::new(self.zoom, self.center - share) } else { self }
    }

    /// Zoomed by the wheel: the point at `at`, as shares of the picture's size, stays under the pointer.
    #[must_use]
    pub(crate) fn scrolled(self, scroll: f32, at: Vec2) -> Self {
        let zoom = (self.zoom * (scroll * 0.005).exp()).clamp(1.0, MOST);
        if zoom <= 1.0 {
            Self::default()
        } else {
            Self::new(zoom, at - (at - self.center) * (self.zoom / zoom))
        }
    }
}
