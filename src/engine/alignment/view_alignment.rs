//! Finds the pose of a picture that took no part, by its own colors beside a rendering.
//!
//! Purpose: a recording's held-out pictures have wrong poses as its cameras do; scored at those, a better model may look worse.
//! Source: as [`super::solver`], with the rendering as the one source and the picture, without its depth, as the target.

use std::sync::Arc;

use super::reference_view::ReferenceView;
use super::residuals::ProblemScale;
use super::solver::{PairWeighing, Problem, SolverStage, Weighing, loss};
use super::surface_samples::surface_samples;
use crate::capture::{Camera, Frame};
use crate::error::Result;
use crate::job::Job;
use crate::median::median;

/// Samples of the rendering that are looked for in the picture.
const SAMPLES: usize = 6000;
/// Fewer do not determine a pose.
const LEAST_SAMPLES: usize = 200;
/// Resolutions, and steps at each.
const STAGES: [(usize, usize); 4] = [(3, 6), (2, 5), (1, 5), (0, 5)];

/// The pose of `picture` by its colors beside a rendering from `camera`; the camera itself where they do not determine it.
///
/// # Errors
/// `Cancelled`.
pub fn align_view(camera: &Camera, rendering: Frame, picture: &Frame, job: &Job) -> Result<Camera> {
    // Only cameras in perspective are aligned.
    if camera.intrinsics.is_orthographic() {
        return Ok(camera.clone());
    }
    let source = ReferenceView::new(camera.clone(), Arc::new(rendering), None);
    // A picture that has no depth of its own shows nothing of where its surfaces end.
    let target = ReferenceView::without_extent(camera.clone(), Arc::new(picture.clone()), None);
    let mut samples = surface_samples(&source, SAMPLES);
    // All samples take part in finding the pose; none is left to judge it.
    for sample in &mut samples {
        sample.judges = false;
    }
    if samples.len() < LEAST_SAMPLES {
        return Ok(camera.clone());
    }
    let mut depths: Vec<f64> = samples.iter().map(|sample| sample.inverse_depth).collect();
    let inverse_depth = median(&mut depths).unwrap_or(1.0);
    let scale = ProblemScale { inverse_depth, focal: camera.intrinsics.fx };
    let mut problem = Problem {
        views: vec![source, target],
        samples: vec![samples, Vec::new()],
        pairs: vec![[0, 1]],
        scale,
        log_gains: vec![0.0; 2],
        moved: vec![[0.0; 6]; 2],
        is_free: vec![false, true],
        regions: 1,
        color_alone: true,
    };
    for (level, steps) in STAGES {
        problem.iterate(&SolverStage { gate: f64::INFINITY, level, steps }, job)?;
    }
    let weighing = problem.weighing(&SolverStage { gate: f64::INFINITY, level: 1, steps: 0 });
    let after = mean_color_loss(&problem, &weighing);
    let aligned = problem.views[1].camera.clone();
    problem.views[1].camera = camera.clone();
    let before = mean_color_loss(&problem, &weighing);
    Ok(if after < before { aligned } else { camera.clone() })
}

/// Mean loss of brightness of the one pair.
fn mean_color_loss(problem: &Problem, weighing: &Weighing) -> f64 {
    let views = problem.pair(problem.pairs[0]);
    let PairWeighing { gate, sigmas } = weighing.pairs[0];
    let terms =
        problem.samples[0].iter().filter_map(|sample| views.terms(sample, weighing.level, gate)?.color);
    let (sum, count) =
        terms.fold((0.0, 0), |(sum, count), term| (sum + loss(term.residual, sigmas[1]), count + 1));
    sum / f64::from(count.max(1))
}
