//! What the explanation of a pixel consists of: the evidence of each camera, and the chain of witnesses.

use glam::{DVec2, DVec3};

use crate::preprocess::pruning::Verdict;
use crate::preprocess::registration::Outcome;
use crate::preprocess::temporal::PixelClass;
use crate::samples::{Vote, VoteCounts};

/// What one camera shows of a surface point. Lengths are in the capture's unit; what is not known is NaN.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraEvidence {
    /// Index of the camera.
    pub camera: usize,
    /// Whether it sees the point; `None` for the camera whose own pixel is explained.
    pub outcome: Option<Outcome>,
    /// Its vote on the sample; `None` for the camera whose own pixel is explained.
    pub vote: Option<Vote>,
    /// Where the point falls in its picture, pixels; `None` behind the camera. It may be outside the picture.
    pub position: Option<DVec2>,
    /// The pixel there, `y * width + x`; `None` outside the picture.
    pub pixel: Option<u32>,
    /// Planar z that the point has for this camera; infinite at infinity.
    pub depth_expected: f64,
    /// Planar z that the camera recorded there; infinite at infinity.
    pub depth_found: f64,
    /// Side of the larger of the two pixels on the surface: the footprint that distances are measured in.
    pub footprint: f64,
    /// Distance from the point to the tangent plane found there, in footprints.
    pub plane_distance_footprints: f64,
    /// Angle between the line of sight and the normal found there.
    pub incidence_degrees: f64,
    /// Angle between the point's normal and the one found there.
    pub normal_angle_degrees: f64,
    /// Largest difference of a color channel, 8-bit sRGB steps.
    pub color_difference_steps: f64,
    /// The paper's `r` of the pixel against this camera's: below 1 where the pixel is sampled more densely.
    pub paper_r: f64,
    /// The ratio by footprints, which know focal length and resolution: their longest sides where these decide, else their areas.
    pub footprint_r: f64,
    /// Whether the sample found there is a mixed pixel, so that it yields to clean ones, however dense.
    pub is_mixed: bool,
    /// Whether the normal found there is not known: the sample yields to samples whose normal is.
    pub is_unsure: bool,
    /// What became of the pixel found there; `None` outside the picture.
    pub verdict: Option<Verdict>,
}

impl CameraEvidence {
    /// The row of a camera in which nothing was looked up.
    pub(super) fn not_found(camera: usize) -> Self {
        Self {
            camera,
            outcome: None,
            vote: None,
            position: None,
            pixel: None,
            depth_expected: f64::NAN,
            depth_found: f64::NAN,
            footprint: f64::NAN,
            plane_distance_footprints: f64::NAN,
            incidence_degrees: f64::NAN,
            normal_angle_degrees: f64::NAN,
            color_difference_steps: f64::NAN,
            paper_r: f64::NAN,
            footprint_r: f64::NAN,
            is_mixed: false,
            is_unsure: false,
            verdict: None,
        }
    }
}

/// One step from a sample to its witness.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChainLink {
    /// Index of the camera.
    pub camera: usize,
    /// Its pixel, `y * width + x`.
    pub pixel: u32,
    /// What became of it.
    pub verdict: Verdict,
}

/// Why one pixel was kept or dropped at one frame.
#[derive(Clone, Debug, PartialEq)]
pub struct PixelExplanation {
    /// Index of the camera.
    pub camera: usize,
    /// Column.
    pub x: usize,
    /// Row.
    pub y: usize,
    /// Index of the frame.
    pub frame: usize,
    /// The surface point; `None` at infinity and where there is no depth.
    pub point_in_world: Option<DVec3>,
    /// What the pixel is over time.
    pub class: PixelClass,
    /// The verdict, worked out from what the other cameras show and what was decided there.
    pub verdict: Verdict,
    /// How many other cameras confirm the sample and how many look past it, whether or not the settings let them vote.
    pub votes: VoteCounts,
    /// Whether it is a flying pixel, in the air between foreground and background: then its own camera looks past it, too.
    pub is_flying: bool,
    /// Whether it is kept as a doubtful sample, which is shown where there is nothing else.
    pub is_doubtful: bool,
    /// Index of the camera whose kept sample shows the point; `None` where nothing does.
    pub winner: Option<usize>,
    /// One per camera, in the capture's order; empty where the pixel has no depth.
    pub evidence: Vec<CameraEvidence>,
    /// From the pixel to the sample that represents it. Where the coverage rule kept it, the chain passes the better
    /// sample, which was dropped, to the sample that this one was dropped for.
    pub chain: Vec<ChainLink>,
}

/// What the same-surface test compares for one sample and one other camera that has depth there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairQuantities {
    /// The outcome of the test.
    pub outcome: Outcome,
    /// The least depth tolerance at which the depths agree, pixel footprints: what the measured noise explains is granted.
    pub depth_tolerance_needed: f32,
    /// See [`CameraEvidence::normal_angle_degrees`]; NaN where either normal is unknown.
    pub normal_angle_degrees: f32,
    /// See [`CameraEvidence::color_difference_steps`].
    pub color_difference_steps: f32,
}
