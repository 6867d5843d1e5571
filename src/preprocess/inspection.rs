//! Everything preprocessing knows about one frame, for the eye: classes, rates, verdicts, witnesses.

use std::sync::Arc;

use rayon::prelude::*;

use super::layer::{Layer, Level, NO_SAMPLE};
use super::pruning::{Dispute, Rig};
use super::registration::{Outcome, SameSurface};
use super::{SampleSet, Span};
use crate::capture::{Camera, Frame};
use crate::grid::Grid;
use crate::settings::Settings;

/// What a pixel is over time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum PixelClass {
    /// No depth: takes part in nothing.
    Invalid,
    /// The same over all frames.
    Background,
    /// A sample of this frame alone.
    Foreground,
    /// The same over some frames, but not over all.
    Lasting,
}

/// Why a sample was kept or dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum Rule {
    /// Not a sample: the pixel has no depth.
    NoSample,
    /// Kept: no other camera sees this surface point.
    OnlyWitness,
    /// Kept: every other camera that sees the point samples it less densely (or equally, and comes later), or its sample is
    /// blended or its normal unknown, and this one's is not.
    BestRate,
    /// Kept: a better sample exists but was itself dropped for one that does not see this point (coverage guarantee), or is
    /// one of a longer span where those may not stand.
    Coverage,
    /// Kept: pruning is off.
    PruningOff,
    /// Dropped: the witness samples the point at a higher rate.
    LowerRate,
    /// Dropped: equal rates, and the witness belongs to an earlier camera.
    Tie,
    /// Dropped: an earlier camera shows the point (first-camera-wins).
    LaterCamera,
    /// Dropped: blended across a silhouette, and the witness is clean.
    MixedYields,
    /// Dropped: the normal is unknown, so that the rate is a guess, and the witness's is known.
    UnsureYields,
    /// Dropped: blended across a silhouette, and the settings drop all such samples. There is no witness.
    MixedDropped,
}

impl Rule {
    /// Every rule.
    pub const ALL: [Self; 11] = [
        Self::NoSample,
        Self::OnlyWitness,
        Self::BestRate,
        Self::Coverage,
        Self::PruningOff,
        Self::LowerRate,
        Self::Tie,
        Self::LaterCamera,
        Self::MixedYields,
        Self::UnsureYields,
        Self::MixedDropped,
    ];

    /// Name in reports and JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::NoSample => "no_sample",
            Self::OnlyWitness => "only_witness",
            Self::BestRate => "best_rate",
            Self::Coverage => "coverage",
            Self::PruningOff => "pruning_off",
            Self::LowerRate => "lower_rate",
            Self::Tie => "tie",
            Self::LaterCamera => "later_camera",
            Self::MixedYields => "mixed_yields",
            Self::UnsureYields => "unsure_yields",
            Self::MixedDropped => "mixed_dropped",
        }
    }

    /// The rule as a sentence for people.
    #[must_use]
    pub fn sentence(self) -> &'static str {
        match self {
            Self::NoSample => "No sample: the pixel has no depth.",
            Self::OnlyWitness => "Kept: no other camera has a sample of this point throughout its span.",
            Self::BestRate => "Kept: no clean sample of this point with a known normal is denser.",
            Self::Coverage => {
                "Kept: the better sample does not stand: it was dropped for one that does not see this point, or lives in a longer span, which is not asked."
            }
            Self::PruningOff => "Kept: pruning is off.",
            Self::LowerRate => "Dropped: the witness samples this point more densely.",
            Self::Tie => "Dropped: equal rates, and the witness belongs to an earlier camera.",
            Self::LaterCamera => "Dropped: an earlier camera shows this point.",
            Self::MixedYields => {
                "Dropped: its color is blended across a silhouette, and the witness is clean."
            }
            Self::UnsureYields => "Dropped: its normal is not known, and the witness's is.",
            Self::MixedDropped => "Dropped: its color is blended across a silhouette.",
        }
    }

    /// Whether samples under this rule stay.
    #[must_use]
    pub fn keeps(self) -> bool {
        matches!(self, Self::OnlyWitness | Self::BestRate | Self::Coverage | Self::PruningOff)
    }
}

/// The verdict on one pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Verdict {
    /// The rule that decided.
    pub rule: Rule,
    /// Level of the witness, see [`FrameInspection::path`]; [`NO_SAMPLE`] where there is none.
    pub witness_level: Level,
    /// Camera of the witness; [`Verdict::NO_CAMERA`] where there is none.
    pub witness_camera: u16,
    /// Pixel of the witness, `y * width + x`; 0 where there is none.
    pub witness_pixel: u32,
}

impl Verdict {
    /// In place of a witness's camera where there is no witness.
    pub const NO_CAMERA: u16 = u16::MAX;

    /// A verdict without a witness.
    #[must_use]
    pub fn without_witness(rule: Rule) -> Self {
        Self { rule, witness_level: NO_SAMPLE, witness_camera: Self::NO_CAMERA, witness_pixel: 0 }
    }

    /// Whether the sample stays.
    #[must_use]
    pub fn is_kept(self) -> bool {
        self.rule.keeps()
    }
}

/// One camera at the inspected frame.
#[derive(Clone, Debug)]
pub struct CameraInspection {
    /// The recorded picture.
    pub frame: Arc<Frame>,
    /// Over how many frames each pixel is the same, in words.
    pub class: Arc<Grid<PixelClass>>,
    /// The level of each pixel's sample, an index into [`FrameInspection::path`]; [`NO_SAMPLE`] where there is none.
    pub level: Arc<Grid<Level>>,
    /// Why each pixel was kept or dropped.
    pub verdict: Grid<Verdict>,
    /// Where the rate model not in use names another camera as the best-sampled than the model in use, by pixel.
    pub disputes: Vec<Dispute>,
    /// World-space normals that were used, given or estimated; zero where there is none.
    pub normal_in_world: Arc<Grid<[f32; 3]>>,
    /// Footprint of each pixel on its surface in the unit of the rate model, smaller is better sampled; infinite where
    /// there is no sample. The ratio of two footprints is `r`.
    pub footprint: Arc<Grid<f32>>,
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
    pub(super) layers: Arc<Vec<Layer>>,
    pub(super) settings: Settings,
}

/// What one camera says about a sample of another: a row of the pixel's argument.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairArgument {
    /// The camera that was asked.
    pub camera: usize,
    /// What it says.
    pub outcome: Outcome,
    /// `log₂ r`, negative where the asking sample is denser; NaN unless both show the same surface point.
    pub log2_ratio: f32,
}

impl FrameInspection {
    /// The cameras, in the capture's order.
    fn rig_cameras(&self) -> &[Camera] {
        &self.samples.cameras
    }

    /// log₂ r of every pixel of `camera` against camera `against`, or against whichever other camera samples the point
    /// best: negative where `camera` samples more densely; NaN where the other does not see the same surface point. Samples
    /// count however long their spans are.
    #[must_use]
    pub fn log2_sampling_ratio(&self, camera: usize, against: Option<usize>) -> Grid<f32> {
        let rig = Rig::new(self.rig_cameras());
        let limits = SameSurface::new(&self.settings);
        let layer = &self.layers[camera];
        let (width, height) = (layer.width, layer.height());
        let values = (0..height)
            .into_par_iter()
            .flat_map_iter(|y| {
                let (rig, limits) = (&rig, &limits);
                (0..width).map(move |x| {
                    (0..self.layers.len())
                        .filter(|&other| other != camera && against.is_none_or(|only| only == other))
                        .map(|other| self.ask(rig, limits, camera, other, x, y).log2_ratio)
                        // f32::max passes NaN over, so silence counts for nothing.
                        .fold(f32::NAN, f32::max)
                })
            })
            .collect();
        Grid::from_vec(width, height, values)
    }

    /// What every other camera says about the sample at `(x, y)` of `camera`; empty where there is no sample.
    #[must_use]
    pub fn argument(&self, camera: usize, x: usize, y: usize) -> Vec<PairArgument> {
        let layer = &self.layers[camera];
        if x >= layer.width || y >= layer.height() || layer.inverse_depth[y * layer.width + x] < 0.0 {
            return Vec::new();
        }
        let rig = Rig::new(self.rig_cameras());
        let limits = SameSurface::new(&self.settings).at_level(layer.level[y * layer.width + x]);
        (0..self.layers.len())
            .filter(|&other| other != camera)
            .map(|other| self.ask(&rig, &limits, camera, other, x, y))
            .collect()
    }

    fn ask(
        &self,
        rig: &Rig<'_>,
        limits: &SameSurface,
        camera: usize,
        other: usize,
        x: usize,
        y: usize,
    ) -> PairArgument {
        let (layer, target) = (&self.layers[camera], &self.layers[other]);
        let pixel = y * layer.width + x;
        let outcome = if layer.inverse_depth[pixel] < 0.0 {
            Outcome::NoDepth
        } else {
            rig.registration(camera, other).explain(layer, target, x, y, limits)
        };
        let log2_ratio = match outcome {
            Outcome::Same(found) => (layer.footprint[pixel] / target.footprint[found as usize]).log2(),
            _ => f32::NAN,
        };
        PairArgument { camera: other, outcome, log2_ratio }
    }
}
