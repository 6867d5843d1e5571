//! Everything preprocessing knows about one frame, for display: classes, rates, verdicts, witnesses.

use std::sync::{Arc, OnceLock};

use rayon::prelude::*;

use crate::capture::Frame;
use crate::capture::overlap::OverlapGraph;
use crate::grid::Grid;
use crate::preprocess::agreement::{SampleAgreement, VoteTest, VotedRun};
use crate::preprocess::layers::CameraLayer;
use crate::preprocess::pruning::{Verdict, lanes_at};
use crate::preprocess::registration::{Outcome, PixelRun, SameSurface, SourceRun};
use crate::preprocess::temporal::{PixelClass, ROOT, SpanLevel};
use crate::samples::{SampleSet, Span};
use crate::settings::Settings;
use crate::simd::LANES;

/// One camera at the inspected frame.
#[derive(Clone, Debug)]
pub struct CameraInspection {
    /// The recorded picture.
    pub frame: Arc<Frame>,
    /// Over how many frames each pixel is the same, in words.
    pub class: Arc<Grid<PixelClass>>,
    /// The level of each pixel's sample, an index into [`FrameInspection::path`];
    /// [`NO_SAMPLE`](crate::preprocess::temporal::NO_SAMPLE) without a sample.
    pub level: Arc<Grid<SpanLevel>>,
    /// Why each pixel was kept or dropped.
    pub verdict: Grid<Verdict>,
    /// World-space normals that were used, given or estimated; zero where the normal is not known.
    pub normal_in_world: Arc<Grid<[f32; 3]>>,
}

/// Whether other cameras agree with each pixel of a camera; `None` where it has no depth.
type AgreementGrid = Grid<Option<SampleAgreement>>;

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
    /// Per camera, once it was needed.
    pub(crate) agreement: Arc<Vec<OnceLock<Arc<AgreementGrid>>>>,
}

impl FrameInspection {
    /// Whether it was read from a store: then nothing is known of what source pictures show beside each other, and what compares them
    /// finds no camera that shows a pixel's point.
    #[must_use]
    pub fn is_of_store(&self) -> bool {
        self.layers.is_empty()
    }

    /// Of every pixel of a camera, that nothing is known.
    pub(super) fn unknown<T: Clone>(&self, camera: usize, value: T) -> Grid<T> {
        let (width, height) = self.cameras[camera].verdict.size();
        Grid::filled(width, height, value)
    }

    /// log₂ r of every pixel of `camera` against camera `against`, or against whichever other camera samples the point
    /// best: negative where `camera` samples more densely; NaN where the other does not see the same surface point. Samples
    /// count however long their spans are.
    #[must_use]
    pub fn log2_sampling_ratio(&self, camera: usize, against: Option<usize>) -> Grid<f32> {
        if self.is_of_store() {
            return self.unknown(camera, f32::NAN);
        }
        let pairs = OverlapGraph::complete(&self.samples.cameras);
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
                        .map(|other| self.log2_ratio(pairs, limits, camera, y * width + x, other))
                        // f32::max ignores NaN, so a camera that does not see the point changes nothing.
                        .fold(f32::NAN, f32::max)
                })
            })
            .collect();
        Grid::from_vec(width, height, values)
    }

    /// Whether other cameras agree with the sample of each pixel of `camera`, whether or not the settings drop contradicted samples;
    /// `None` without depth. It is worked out once.
    #[must_use]
    pub fn agreement(&self, camera: usize) -> Arc<Grid<Option<SampleAgreement>>> {
        self.agreement[camera].get_or_init(|| Arc::new(self.asked_about(camera))).clone()
    }

    /// Lets all other cameras vote on every sample of `camera`.
    fn asked_about(&self, camera: usize) -> AgreementGrid {
        if self.is_of_store() {
            return self.unknown(camera, None);
        }
        let pairs = OverlapGraph::complete(&self.samples.cameras);
        let votes = VoteTest::new(&self.settings, ROOT);
        let (layer, margin) = (&self.layers[camera], self.settings.pruning.agreement_margin);
        let (width, height) = (layer.width, layer.height());
        let others = || (0..self.layers.len()).filter(|&other| other != camera);
        let of_row = |row: usize| {
            let mut found = vec![None; width];
            for column in (0..width).step_by(LANES) {
                for level in 0..self.path.len() as SpanLevel {
                    let asked = lanes_at(layer, (column, row), |at| at == level);
                    if asked == 0 {
                        continue;
                    }
                    let block = PixelRun::<LANES>::new(layer, column, row, asked);
                    let (votes, mut voted) = (votes.at_level(level), VotedRun::NONE);
                    for other in others().filter(|&other| !self.layers[other].geometry.is_empty()) {
                        let target = &self.layers[other];
                        let registration = pairs.registration(camera, other);
                        let source = SourceRun::of_layer(layer, &block);
                        let pixel = row * width + column;
                        let is_thin = |lane| votes.is_thin(layer, pixel + lane, registration);
                        votes.add(registration, source, target, asked, is_thin, &mut voted);
                    }
                    for lane in (0..LANES).filter(|lane| asked >> lane & 1 == 1) {
                        found[column + lane] = Some(SampleAgreement::of(
                            voted.counts(lane),
                            margin,
                            layer.packed_colors[row * width + column + lane].is_flying(),
                        ));
                    }
                }
            }
            found
        };
        Grid::from_vec(width, height, (0..height).into_par_iter().flat_map_iter(of_row).collect())
    }

    /// `log₂ r` of the pixel against camera `other`, negative where the pixel is denser; NaN unless both show the same surface point.
    fn log2_ratio(
        &self,
        pairs: &OverlapGraph<'_>,
        limits: &SameSurface,
        camera: usize,
        pixel: usize,
        other: usize,
    ) -> f32 {
        let (layer, target) = (&self.layers[camera], &self.layers[other]);
        if layer.inverse_depth[pixel] < 0.0 {
            return f32::NAN;
        }
        let (x, y) = (pixel % layer.width, pixel / layer.width);
        match limits.test(pairs.registration(camera, other), layer, x, y, target) {
            Outcome::Same(found) => (layer.footprint[pixel] / target.footprint[found as usize]).log2(),
            _ => f32::NAN,
        }
    }
}
