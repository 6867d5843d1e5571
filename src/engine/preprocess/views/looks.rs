//! What is measured of all views before any of their samples is decided.

use std::sync::Arc;

use rayon::prelude::*;

use super::neighborhoods::neighborhood_order;
use super::window::LayerWindow;
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::agreement::{noise_of_camera, where_most_are_noisy};
use crate::preprocess::diagnostics::{DepthReading, Misfits};
use crate::preprocess::noise::NoiseBetween;
use crate::preprocess::registration::CameraPairs;

/// At most this many views are compared to find out whether depth was misread, spread over all views.
const LOOKED_AT: usize = 32;
/// Each is compared with at most this many views that see it.
const LOOKED_AT_BESIDE: usize = 16;

/// The noise of every view as others see it.
pub(super) fn noise_between(
    pairs: &CameraPairs<'_>,
    window: &mut LayerWindow<'_>,
    job: &Job,
) -> Result<Vec<Option<Arc<NoiseBetween>>>> {
    let mut noise = vec![None; pairs.cameras().len()];
    let order = neighborhood_order(pairs);
    for group in window.groups(&order, |camera| pairs.others(camera).map(|(other, _)| other)) {
        window.hold(&group.held, job)?;
        let of_camera = |&camera: &usize| (camera, noise_of_camera(pairs, &window.layers, camera));
        let of_group: Vec<_> = group.cameras.par_iter().map(of_camera).collect();
        for (camera, found) in of_group {
            noise[camera] = found;
        }
    }
    Ok(where_most_are_noisy(noise))
}

/// Whether depth would fit better if it were read otherwise.
pub(super) fn better_reading(
    pairs: &CameraPairs<'_>,
    window: &mut LayerWindow<'_>,
    job: &Job,
) -> Result<Option<DepthReading>> {
    let cameras = pairs.cameras();
    let mut misfits = Misfits::new();
    for nth in 0..cameras.len().min(LOOKED_AT) {
        let source = nth * cameras.len() / cameras.len().min(LOOKED_AT);
        let targets: Vec<usize> = if cameras.len() <= LOOKED_AT {
            (0..cameras.len()).filter(|target| *target != source).collect()
        } else {
            let others = pairs.others(source);
            let step = others.len().div_ceil(LOOKED_AT_BESIDE).max(1);
            others.map(|(target, _)| target).step_by(step).collect()
        };
        let held: Vec<usize> = targets.iter().copied().chain([source]).collect();
        window.hold(&held, job)?;
        misfits.add(cameras, &window.layers, source, &targets);
    }
    Ok(misfits.better())
}
