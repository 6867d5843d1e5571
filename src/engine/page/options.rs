//! What a page is made with.

use glam::DAffine3;
use serde::Serialize;

use crate::capture::Intrinsics;

/// The saved camera path of a page: a pose for each frame of a run of them.
#[derive(Clone, Debug, PartialEq)]
pub struct PagePath {
    /// Index of the frame of the first pose.
    pub first_frame: usize,
    /// Camera space to world space, frame by frame.
    pub poses: Vec<DAffine3>,
    /// The lens along the whole path.
    pub lens: Intrinsics,
}

/// What the colors of a page mean, where they are those of a scalar value.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PageScalarBar {
    /// Name and unit of the value.
    pub title: String,
    /// 8-bit sRGB, evenly spaced from the low end of the range to the high one.
    pub colors: Vec<[u8; 3]>,
    /// What is written where: shares of the bar's length, 0 to 1, ascending.
    pub ticks: Vec<(f64, String)>,
}

/// What a page says beside the scene, and how large it may be.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PageOptions {
    /// The title; the name of the capture if there is none.
    pub title: Option<String>,
    /// A text of the author, plain; empty lines part its paragraphs.
    pub text: Option<String>,
    /// Frames a second; not positive: 24.
    pub frames_per_second: f64,
    /// What its colors mean, where the samples have those of a value: see [`colored_samples`](crate::render::colored_samples).
    pub scalar_bar: Option<PageScalarBar>,
    /// The camera path.
    pub path: Option<PagePath>,
    /// Most bytes of the file; what costs least is made coarser until it fits.
    pub at_most: Option<u64>,
}
