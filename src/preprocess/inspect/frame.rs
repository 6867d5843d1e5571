//! Everything preprocessing knows about one frame, for display: classes, rates, verdicts, witnesses.

use std::sync::Arc;

use rayon::prelude::*;

use crate::capture::Frame;
use crate::grid::Grid;
use crate::preprocess::layers::CameraLayer;
use crate::preprocess::pruning::{Dispute, Verdict};
use crate::preprocess::registration::{CameraPairs, Outcome, SameSurface};
use crate::preprocess::temporal::{PixelClass, SpanLevel};
use crate::samples::{SampleSet, Span};
use crate::settings::Settings;

/// One camera at the inspected frame.
#[derive(Clone, Debug)]
pub struct CameraInspection {
    /// The recorded picture.
    pub frame: Arc<Frame>,
    /// Over how many frames each pixel is the same, in words.
    pub class: Arc<Grid<PixelClass>>,
    /// The level of each pixel's sample, an index into [`FrameInspection::path`]; [`NO_SAMPLE`](crate::preprocess::temporal::NO_SAMPLE) where there is none.
    pub level: Arc<Grid<SpanLevel>>,
    /// Why each pixel was kept or dropped.
    pub verdict: Grid<Verdict>,
    /// Where the rate model not in use names another camera as the best-sampled than the model in use, by pixel.
    pub disputes: Vec<Dispute>,
    /// World-space normals that were used, given or estimated; zero where there is none.
    pub normal_in_world: Arc<Grid<[f32; 3]>>,
}

impl CameraInspection {
    /// The camera that the rate model not in use names as the best-sampled at `pixel`, `y * width + x`; `None` where both name
    /// the same.
    #[must_use]
    pub fn other_winner(&self, pixel: usize) -> Option<usize> {
        let found = self.disputes.binary_search_by_key(&(pixel as u32), |dispute| dispute.pixel);
        found.ok().map(|index| usize::from(self.disputes[index].other_camera))
    }
}

/// All cameras at one frame.
#[derive(Clone, Debug)]
pub struct FrameInspection {
    /// Index of the frame.
    pub frame: usize,
    /// The spans that contain the frame, by level: all frames first, the frame alone last.
    pub path: Vec<Span>,
    /// Per camera, in the capture's order.
    pub cameras: Vec<CameraInspection>,
    /// The samples kept at this frame (background and foreground), ready to be rendered.
    pub samples: Arc<SampleSet>,
    pub(crate) layers: Arc<Vec<CameraLayer>>,
    pub(crate) settings: Settings,
}

impl FrameInspection {
    /// log₂ r of every pixel of `camera` against camera `against`, or against whichever other camera samples the point
    /// best: negative where `camera` samples more densely; NaN where the other does not see the same surface point. Samples
    /// count however long their spans are.
    #[must_use]
    pub fn log2_sampling_ratio(&self, camera: usize, against: Option<usize>) -> Grid<f32> {
        let pairs = CameraPairs::new(&self.samples.cameras);
        let limits = SameSurface::new(&self.settings);
        let layer = &self.layers[camera];
        let (width, height) = (layer.width, layer.height());
        let values = (0..height)
            .into_par_iter()
            .flat_map_iter(|y| {
                let (pairs, limits) = (&pairs, &limits);
                (0..width).map(move |x| {
                    (0..self.layers.len())
                        .filter(|&other| other != camera && against.is_none_or(|only| only == other))
                        .map(|other| self.log2_ratio(pairs, limits, (camera, x, y), other))
                        // f32::max ignores NaN, so a camera that does not see the point changes nothing.
                        .fold(f32::NAN, f32::max)
                })
            })
            .collect();
        Grid::from_vec(width, height, values)
    }

    /// `log₂ r` of the pixel against camera `other`, negative where the pixel is denser; NaN unless both show the same surface point.
    fn log2_ratio(
        &self,
        pairs: &CameraPairs<'_>,
        limits: &SameSurface,
        (camera, x, y): (usize, usize, usize),
        other: usize,
    ) -> f32 {
        let (layer, target) = (&self.layers[camera], &self.layers[other]);
        let pixel = y * layer.width + x;
        if layer.inverse_depth[pixel] < 0.0 {
            return f32::NAN;
        }
        match limits.test(pairs.registration(camera, other), (layer, x, y), target) {
            Outcome::Same(found) => (layer.footprint[pixel] / target.footprint[found as usize]).log2(),
            _ => f32::NAN,
        }
    }
}
