//! The account that preprocessing gives of itself.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::Span;

/// One camera's part of a [`Report`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CameraReport {
    /// The camera's name.
    pub name: String,
    /// Pixels of all its frames.
    pub pixels: u64,
    /// Pixels without depth, over all frames.
    pub invalid: u64,
    /// Pixels that are static over the whole sequence.
    pub background_pixels: u64,
    /// Samples kept for all frames together.
    pub background_kept: u64,
    /// Foreground pixels, summed over frames.
    pub foreground_pixels: u64,
    /// Foreground samples kept, summed over frames.
    pub foreground_kept: u64,
    /// Measured color noise: standard deviation over time of static pixels, 8-bit sRGB steps, median over the picture.
    pub color_noise_steps: f32,
    /// Measured depth noise: relative standard deviation over time of static pixels.
    pub depth_noise_relative: f32,
}

/// Samples kept in one span.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SpanReport {
    /// The frames.
    pub span: Span,
    /// Samples kept, all cameras.
    pub samples: u64,
}

/// The account that preprocessing gives of itself. Written into the store and printed by `preprocess --json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Per camera, in the capture's order.
    pub cameras: Vec<CameraReport>,
    /// Per span that holds samples, longest first.
    pub spans: Vec<SpanReport>,
    /// Foreground samples kept at each frame, all cameras.
    pub foreground_per_frame: Vec<u64>,
    /// Pixels of all frames of all cameras.
    pub samples_in: u64,
    /// Samples kept.
    pub samples_kept: u64,
    /// Samples dropped, per rule; `static` counts the repetitions that a background sample stands for.
    pub pruned: BTreeMap<String, u64>,
    /// `witnesses[loser][winner]`: samples of camera `loser` for which a sample of camera `winner` stands.
    pub witnesses: Vec<Vec<u64>>,
    /// All input pixels as 8-bit color and 32-bit depth.
    pub bytes_raw: u64,
    /// The kept samples in memory.
    pub bytes_memory: u64,
    /// Wall-clock seconds of the whole preprocessing.
    pub seconds: f64,
}
