//! Which cameras are compared with which.

use rayon::prelude::*;

use super::reference_view::ReferenceView;
use super::surface_samples::SurfaceSample;
use crate::capture::sighting::tolerances::OVERLAPS;
use crate::capture::sighting::{Sighting, look};

/// A camera's samples are carried into this many others at most, in captures of more than [`FEW`] cameras.
const MOST_TARGETS: usize = 8;
/// All pairs are compared in captures of up to this many cameras.
const FEW: usize = 10;
/// Samples of a camera that measure how much another one sees of it.
const PROBES: usize = 96;
/// Two cameras overlap where one sees this share of the other's samples.
const LEAST_SHARE: f64 = 0.08;

/// The pairs of source and target that overlap. In a large capture each camera is compared with some that see most of it and some
/// that see less, so that all hang together.
pub(crate) fn overlapping_pairs(views: &[ReferenceView], samples: &[Vec<SurfaceSample>]) -> Vec<[usize; 2]> {
    let most = if views.len() <= FEW { views.len() } else { MOST_TARGETS };
    let of_source = |source: usize| {
        let mut shares: Vec<(f64, usize)> = (0..views.len())
            .filter(|target| *target != source)
            .map(|target| (share_seen(&views[source], &samples[source], &views[target]), target))
            .filter(|(share, _)| *share >= LEAST_SHARE)
            .collect();
        shares.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut chosen = Vec::new();
        // The ranks 0, 1, 2, 3, then ever farther apart.
        let (mut rank, mut gap) = (0, 1);
        while rank < shares.len() && chosen.len() < most {
            chosen.push([source, shares[rank].1]);
            if most < shares.len() && chosen.len() >= most / 2 {
                gap += 1;
            }
            rank += gap;
        }
        chosen
    };
    let pairs: Vec<Vec<[usize; 2]>> = (0..views.len()).into_par_iter().map(of_source).collect();
    pairs.into_iter().flatten().collect()
}

fn share_seen(source: &ReferenceView, samples: &[SurfaceSample], target: &ReferenceView) -> f64 {
    let step = (samples.len() / PROBES).max(1);
    let (mut seen, mut all) = (0, 0);
    for sample in samples.iter().step_by(step) {
        all += 1;
        let point = source.camera.unproject(sample.pixel, 1.0 / sample.inverse_depth);
        let sighting = look(&target.camera, &target.frame.inverse_depth, point, OVERLAPS);
        seen += u32::from(sighting == Sighting::Same);
    }
    f64::from(seen) / f64::from(all.max(1))
}
