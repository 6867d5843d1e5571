//! Pairs of views: by how much of one the other sees, or where nothing is known.

use glam::DVec3;
use rayon::prelude::*;

use crate::capture::camera::Camera;
use crate::capture::sighting::tolerances::OVERLAPS;
use crate::capture::sighting::{Sighting, look};
use crate::grid::Grid;

/// A view is compared with this many others at most, in captures of more than [`FEW`].
const MOST_TARGETS: usize = 8;
/// All pairs are compared in captures of up to this many views.
const FEW: usize = 10;
/// Two views overlap where one sees this share of the other's points.
const LEAST_SHARE: f64 = 0.08;

/// The share of some points in world space that a view sees. Poses may be far off, as before the alignment.
pub(crate) fn share_seen(
    points_in_world: impl Iterator<Item = DVec3>,
    camera: &Camera,
    inverse_depth: &Grid<f32>,
) -> f64 {
    let (mut seen, mut all) = (0, 0);
    for point in points_in_world {
        all += 1;
        seen += u32::from(look(camera, inverse_depth, point, OVERLAPS) == Sighting::Same);
    }
    f64::from(seen) / f64::from(all.max(1))
}

/// The pairs of source and target that overlap, by the share that the target sees of the source. Where views are many, each is paired
/// with some that see most of it and some that see less, so that all hang together.
pub(crate) fn pairs_by_share(views: usize, share: impl Fn(usize, usize) -> f64 + Sync) -> Vec<[usize; 2]> {
    let most = if views <= FEW { views } else { MOST_TARGETS };
    let of_source = |source: usize| {
        let mut shares: Vec<(f64, usize)> = (0..views)
            .filter(|target| *target != source)
            .map(|target| (share(source, target), target))
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
    let pairs: Vec<Vec<[usize; 2]>> = (0..views).into_par_iter().map(of_source).collect();
    pairs.into_iter().flatten().collect()
}

/// The most pairs where nothing is known of the views.
const MOST_PAIRS: usize = 16;

/// Pairs of views where poses and depth may be misread, so that no overlap is known: all pairs of a few views; otherwise pairs at
/// distances of 1, 3, 10 and 30 in their order, spread over all of them.
pub(crate) fn pairs_by_number(views: usize) -> Vec<(usize, usize)> {
    if views * views.saturating_sub(1) <= MOST_PAIRS {
        return (0..views).flat_map(|a| (0..views).filter(move |b| *b != a).map(move |b| (a, b))).collect();
    }
    let mut pairs = Vec::new();
    let all: Vec<(usize, usize)> = (0..views).flat_map(|a| (a + 1..views).map(move |b| (a, b))).collect();
    if all.len() <= MOST_PAIRS {
        pairs = all;
    } else {
        let strides: Vec<usize> = [1, 3, 10, 30].into_iter().filter(|stride| *stride < views).collect();
        let each = MOST_PAIRS / strides.len();
        for stride in strides {
            let starts = views - stride;
            pairs.extend((0..each).map(|k| k * starts / each).map(|start| (start, start + stride)));
        }
        pairs.dedup();
    }
    // Every other one backward, so that no direction of motion is preferred.
    pairs.iter().enumerate().map(|(index, &(a, b))| if index % 2 == 0 { (a, b) } else { (b, a) }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_are_few_distinct_and_of_two_views_each() {
        for views in 0..80 {
            let pairs = pairs_by_number(views);
            assert!(pairs.len() <= MOST_PAIRS && (views < 2 || pairs.len() >= 2), "{views}");
            assert!(pairs.iter().all(|&(a, b)| a != b && a < views && b < views), "{views}");
            let distinct: std::collections::HashSet<_> = pairs.iter().collect();
            assert_eq!(distinct.len(), pairs.len(), "{views}");
        }
    }
}
