//! Estimated normals against given ones: how far off each estimator is on the capture at hand, in degrees.

use glam::Vec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::depth_view::DepthView;
use super::estimate::{MIN_CONFIDENCE, estimate_all};
use crate::capture::{Camera, Frame};
use crate::settings::{NormalEstimator, NormalSettings};

/// How far one estimator is off on one picture.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NormalErrors {
    /// Name of the estimator.
    pub estimator: String,
    /// Angle to the given normal that half of the trusted estimates stay below, degrees.
    pub median_degrees: f32,
    /// Angle that 95 % of the trusted estimates stay below, degrees.
    pub p95_degrees: f32,
    /// Share of the pixels with a given normal whose estimate is trusted, 0 to 1.
    pub trusted: f32,
}

/// Normals of another space than the poses are off by more, those of bumps and smooth shading by far less, degrees.
const WRONG_SPACE_DEGREES: f32 = 30.0;

/// With a smaller share of trusted estimates the errors show nothing.
const MIN_TRUSTED: f32 = 0.1;

/// The median angle between given normals and those of the depth, degrees, by the estimator that they fit best; `None` if the angle is
/// small enough for normals in the same space.
pub(crate) fn contradiction(errors: &[NormalErrors]) -> Option<f32> {
    let trusted = errors.iter().filter(|errors| errors.trusted >= MIN_TRUSTED);
    let best = trusted.map(|errors| errors.median_degrees).min_by(f32::total_cmp);
    best.filter(|degrees| *degrees > WRONG_SPACE_DEGREES)
}

/// The warning about cameras whose normals contradict their depth, each a name and how far, degrees; `None` without any.
pub(crate) fn normal_space_warning(cameras: &[(&str, f32)]) -> Option<String> {
    const NAMED: usize = 3;
    let least = cameras.iter().map(|(_, degrees)| *degrees).min_by(f32::total_cmp)?;
    let names: Vec<String> = cameras.iter().take(NAMED).map(|(name, _)| format!("'{name}'")).collect();
    let names = names.join(", ");
    let whose = match cameras.len() {
        1 => format!("camera {names}"),
        several if several <= NAMED => format!("cameras {names}"),
        many => format!("cameras {names} and {} more", many - NAMED),
    };
    Some(format!(
        "the normals of {whose} are not those of the depth (half are {least:.0}° off or more); name the space that they are in as \"normal_space\", \"world\" being that of transform_matrix, or write null to have them estimated"
    ))
}

/// Compares every estimator with the normals that `frame` of `camera` gives; empty where it gives none.
pub(crate) fn compare_with_given(
    frame: &Frame,
    camera: &Camera,
    settings: &NormalSettings,
) -> Vec<NormalErrors> {
    let Some(given) = &frame.normal_in_world else { return Vec::new() };
    let view = DepthView::new(frame.inverse_depth.as_slice(), camera, settings);
    let rotation = camera.world_from_camera.matrix3.as_mat3();
    NormalEstimator::ALL
        .iter()
        .filter_map(|&estimator| {
            let estimates = estimate_all(&view, estimator);
            let pairs = estimates.as_slice().par_iter().zip(given.as_slice());
            let judged = pairs.filter(|(_, given)| **given != [0.0; 3]).map(|(estimate, given)| {
                let cosine = (rotation * estimate.normal_in_camera).dot(Vec3::from(*given));
                (estimate.confidence >= MIN_CONFIDENCE).then(|| cosine.clamp(-1.0, 1.0).acos().to_degrees())
            });
            let judged: Vec<Option<f32>> = judged.collect();
            let mut angles: Vec<f32> = judged.iter().filter_map(|angle| *angle).collect();
            angles.sort_by(f32::total_cmp);
            let quantile = |share: f32| angles.get((angles.len() as f32 * share) as usize).copied();
            Some(NormalErrors {
                estimator: estimator.name().to_owned(),
                median_degrees: quantile(0.5)?,
                p95_degrees: quantile(0.95)?,
                trusted: angles.len() as f32 / judged.len() as f32,
            })
        })
        .collect()
}
