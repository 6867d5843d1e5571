//! Everything preprocessing knows about one frame, for the eye: classes, rates, verdicts, witnesses.

use std::sync::Arc;

use super::SampleSet;
use crate::capture::Frame;
use crate::grid::Grid;

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
}

/// Why a sample was kept or dropped. `docs()` gives the sentence for people.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Rule {
    /// Not a sample: the pixel has no depth.
    NoSample,
    /// Kept: no other camera sees this surface point.
    OnlyWitness,
    /// Kept: every other camera that sees the point samples it less densely (or equally, and comes later).
    BestRate,
    /// Kept: a better sample exists but was itself dropped for one that does not see this point (coverage guarantee).
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
    /// Dropped: blended across a silhouette, and the settings drop all such samples. There is no witness.
    MixedDropped,
}

/// The verdict on one pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Verdict {
    /// The rule that decided.
    pub rule: Rule,
    /// Whether the witness is a background sample.
    pub witness_is_background: bool,
    /// Camera of the witness; meaningless for kept samples.
    pub witness_camera: u16,
    /// Pixel of the witness, `y * width + x`; meaningless for kept samples.
    pub witness_pixel: u32,
}

/// One camera at the inspected frame.
#[derive(Clone, Debug)]
pub struct CameraInspection {
    /// The recorded picture.
    pub frame: Arc<Frame>,
    /// Background, foreground or nothing.
    pub class: Grid<PixelClass>,
    /// Why each pixel was kept or dropped.
    pub verdict: Grid<Verdict>,
    /// World-space normals that were used, given or estimated; zero where there is none.
    pub normal_in_world: Grid<[f32; 3]>,
    /// Footprint of each pixel on its surface in the unit of the rate model, smaller is better sampled; infinite where
    /// there is no sample. The ratio of two footprints is `r`.
    pub footprint: Grid<f32>,
}

/// All cameras at one frame.
#[derive(Clone, Debug)]
pub struct FrameInspection {
    /// Index of the frame.
    pub frame: usize,
    /// Per camera, in the capture's order.
    pub cameras: Vec<CameraInspection>,
    /// The samples kept at this frame (background and foreground), ready to be rendered.
    pub samples: Arc<SampleSet>,
}

impl FrameInspection {
    /// log₂ r of every pixel of `camera` against camera `against`, or against whichever other camera samples the point
    /// best: negative where `camera` samples more densely; NaN where the other does not see the same surface point.
    #[must_use]
    pub fn log2_sampling_ratio(&self, camera: usize, against: Option<usize>) -> Grid<f32> {
        let _ = (camera, against);
        todo!()
    }
}
