//! What is measured of all cameras before any of their samples is decided.

use std::sync::Arc;

use rayon::prelude::*;

use super::groups::CameraGroup;
use super::window::LayerWindow;
use crate::capture::overlap::OverlapGraph;
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::agreement::{NoiseLattice, where_most_are_noisy};
use crate::preprocess::diagnostics::{DepthReading, Misfits};
use crate::preprocess::noise::NoiseBetween;

/// At most this many cameras are compared to find out whether depth was misread, spread over all.
const LOOKED_AT: usize = 32;
/// Each is compared with at most this many that see it.
const LOOKED_AT_BESIDE: usize = 16;

/// The noise of every camera as the others see it, from some samples of each.
pub(super) fn noise_between(
    pairs: &OverlapGraph<'_>,
    window: &mut LayerWindow<'_>,
    groups: &[CameraGroup],
    mut lattices: Vec<NoiseLattice>,
    job: &Job,
) -> Result<Vec<Option<Arc<NoiseBetween>>>> {
    for group in groups {
        let mut is_worked_on = vec![false; lattices.len()];
        group.cameras.iter().for_each(|camera| is_worked_on[*camera] = true);
        for part in &group.parts {
            window.hold(part, job)?;
            let layers = &window.layers;
            let lattices = lattices.par_iter_mut().enumerate().filter(|(camera, _)| is_worked_on[*camera]);
            lattices.for_each(|(camera, lattice)| lattice.compare(pairs, camera, layers, part));
        }
    }
    Ok(where_most_are_noisy(lattices.into_par_iter().map(NoiseLattice::noise).collect()))
}

/// Whether depth would fit better if it were read otherwise.
pub(super) fn better_reading(
    pairs: &OverlapGraph<'_>,
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
