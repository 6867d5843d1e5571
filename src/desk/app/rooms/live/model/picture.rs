//! The picture of the live view: what it was made from, and where its pixels are.

use std::sync::Arc;
use std::time::Duration;

use egui::ColorImage;

use super::motion_budget::MotionQuality;
use super::view_look::ShownCameras;
use crate::app::model::Same;
use crate::app::model::texture::Texture;
use crate::app::rooms::colors::model::display::{Display, PictureHistogram};
use crate::app::rooms::source::model::picture::{AGREEMENT, MOTION};
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
    Filled,
    Hatched,
    /// Filled, but dimmed where that is far from any sample.
    Dimmed,
}

impl HoleDisplay {
    /// Every choice in the order of the toolbar: its name, and what it shows.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 3] = [
        (
            Self::Filled,
            "Fill",
            "Pixels that no sample reached get invented colors, continued from the background (H).",
        ),
        (Self::Hatched, "Show", "Pixels that no sample reached are hatched, over what fills them (H)."),
        (
            Self::Dimmed,
            "Dim",
            "As Fill, but what lies far from any sample is blurred, gray and dark, so that it reads as unknown.",
        ),
    ];

    /// What the key makes of it: hatched, or no longer.
    pub(crate) fn other(self) -> Self {
        match self {
            Self::Filled | Self::Dimmed => Self::Hatched,
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
    /// The cameras whose samples are shown.
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
    /// How many of the holes show the sky; 0 while pixels stay on the graphics card.
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

/// The one that is shown.
pub(crate) struct ShownCarried {
    pub camera: Camera,
    pub inverse_depth: Grid<f32>,
    pub texture: Texture,
}
