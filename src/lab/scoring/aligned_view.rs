//! A view scored at the pose and exposure that its own true picture shows.
//!
//! Purpose: the held-out pictures of a recording have wrong poses and exposures, as its cameras do. Scored at these, a better model may
//! look worse. Only the pose and one gain per channel are taken from the true picture. Source: none; [`align_view`] finds the pose, and
//! the gains are median ratios.

use std::sync::Arc;

use super::view::{AlignedScore, Evaluation, painted};
use crate::metrics::Pair;
use half::f16;
use overlook_engine::alignment::align_view;
use overlook_engine::capture::{Camera, Frame, TruthView, Values};
use overlook_engine::error::Result;
use overlook_engine::grid::Grid;
use overlook_engine::job::Job;
use overlook_engine::median::median_f32;
use overlook_engine::render::{NO_IMAGE, Picture, Renderer};
use overlook_engine::samples::SampleSet;
use overlook_engine::settings::RenderSettings;

/// Renderings that are compared with the true picture, one after the other from where it seems to have been taken.
const ROUNDS: usize = 2;

/// Adds to each view with a true picture its score once it is aligned, and to the mean theirs. `samples_for` gives the samples that
/// are seen from a camera at the frame of a view.
///
/// # Errors
/// Those of rendering and of `samples_for`, and `Cancelled`.
pub fn add_aligned(
    evaluation: &mut Evaluation,
    renderer: &mut Renderer,
    views: &[&TruthView],
    settings: &RenderSettings,
    mut samples_for: impl FnMut(&TruthView, &Camera) -> Result<Arc<SampleSet>>,
    job: &Job,
) -> Result<()> {
    job.start("Aligning views", views.len());
    let mut all = Vec::new();
    for (score, view) in evaluation.views.iter_mut().zip(views) {
        job.check()?;
        if score.scores.is_some() {
            score.aligned = aligned_score(renderer, view, settings, &mut samples_for, job)?;
            all.extend(score.aligned.map(|aligned| aligned.psnr_db));
        }
        job.advance(1);
    }
    evaluation.mean.psnr_aligned_db = (!all.is_empty()).then(|| all.iter().sum::<f64>() / all.len() as f64);
    Ok(())
}

/// The score of a view with a true picture once it is aligned; `None` where it has none.
fn aligned_score(
    renderer: &mut Renderer,
    view: &TruthView,
    settings: &RenderSettings,
    samples_for: &mut impl FnMut(&TruthView, &Camera) -> Result<Arc<SampleSet>>,
    job: &Job,
) -> Result<Option<AlignedScore>> {
    let Some(truth) = &view.truth else { return Ok(None) };
    let truth = truth()?;
    let mut aligned = view.clone();
    let mut picture = painted(renderer, &samples_for(view, &view.camera)?, view, settings, job)?.0;
    for _ in 0..ROUNDS {
        let camera = align_view(&aligned.camera, as_frame(&picture), &truth, job)?;
        if camera == aligned.camera {
            break;
        }
        aligned.camera = camera;
        picture = painted(renderer, &samples_for(&aligned, &aligned.camera)?, &aligned, settings, job)?.0;
    }
    let log_gains = log_gains(&picture, &truth);
    let mut picture = Picture::clone(&picture);
    let gains = log_gains.map(|gain| gain.exp() as f32);
    for color in picture.color.as_mut_slice() {
        *color = std::array::from_fn(|channel| color[channel] * gains[channel]);
    }
    let scores = Pair::new(&picture, &truth)?.scores();
    let [now, then] = [&aligned.camera, &view.camera].map(|camera| camera.world_from_camera);
    let turn = glam::DQuat::from_mat3(&(now.matrix3 * then.matrix3.transpose()));
    Ok(Some(AlignedScore {
        psnr_db: scores.psnr_db,
        psnr_all_db: scores.psnr_all_db,
        ssim: scores.ssim,
        degrees: turn.to_scaled_axis().length().to_degrees(),
        distance: now.translation.distance(then.translation),
        stops: log_gains.map(|gain| gain / std::f64::consts::LN_2),
    }))
}

/// What was painted, without what was filled in.
fn as_frame(picture: &Picture) -> Frame {
    let (width, height) = picture.color.size();
    let sampled = picture.image.as_slice().iter().zip(picture.inverse_depth.as_slice());
    let depth = sampled.map(|(image, depth)| if *image == NO_IMAGE { -1.0 } else { *depth });
    Frame {
        color: picture.color.map(|color| color.map(f16::from_f32)),
        inverse_depth: Grid::from_vec(width, height, depth.collect()),
        normal_in_world: None,
        depth_step_relative: 0.0,
        values: Values::default(),
    }
}

/// Colors that a ratio is measured at, linear: neither dark nor possibly clipped.
const USABLE: std::ops::Range<f32> = 0.01..0.85;

/// Logarithms of the median ratios of the true colors to the painted ones, per channel.
fn log_gains(picture: &Picture, truth: &Frame) -> [f64; 3] {
    let pixels = || picture.color.as_slice().iter().zip(truth.color.as_slice()).zip(picture.image.as_slice());
    std::array::from_fn(|channel| {
        let ratio = |((painted, truth), image): ((&[f32; 3], &[f16; 3]), &u32)| {
            let (painted, truth) = (painted[channel], f32::from(truth[channel]));
            let usable = *image != NO_IMAGE && USABLE.contains(&painted) && USABLE.contains(&truth);
            usable.then(|| truth / painted)
        };
        let mut ratios: Vec<f32> = pixels().filter_map(ratio).collect();
        median_f32(&mut ratios).map_or(0.0, |ratio| f64::from(ratio).ln())
    })
}
