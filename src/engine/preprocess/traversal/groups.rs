//! Which cameras are worked on together, and which layers they are compared with meanwhile, within memory.
//!
//! ```text
//! all layers fit              one group of all cameras, one part of all layers
//! those of neighbors fit      groups of neighbors, each with one part: all that may see their samples
//! else                        groups of cameras whose samples fit beside a few layers, each with all other layers, part by part
//! ```

use std::collections::BTreeSet;

use rayon::prelude::*;

use crate::capture::Capture;
use crate::capture::overlap::{DepthBounds, OverlapGraph};
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::pruning::{Statuses, no_statuses};
use crate::preprocess::temporal::{TemporalScan, all_frames};
use crate::settings::Settings;

/// Cameras that are worked on together.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CameraGroup {
    /// Those that are worked on.
    pub(super) cameras: Vec<usize>,
    /// All cameras that may see their samples, ascending, in parts: the layers of a part are held at a time.
    pub(super) parts: Vec<Vec<usize>>,
}

/// What cameras take in memory, bytes.
pub(super) struct CameraBytes<'a> {
    /// Bytes of each camera's layer.
    pub(super) layers: &'a [usize],
    /// Bytes of each camera's samples while they are worked on.
    pub(super) samples: &'a [usize],
    /// How much may be taken, unless a single camera takes more.
    pub(super) bound: usize,
}

/// Layers that are held at a time where not all fit. With fewer, what is known of each sample is taken up more often; with more, there is
/// room for fewer samples, and layers are read more often.
pub(super) const LAYERS_AT_A_TIME: usize = 4;

/// Groups of all cameras.
pub(super) fn groups_within(pairs: &OverlapGraph<'_>, bytes: &CameraBytes<'_>) -> Vec<CameraGroup> {
    let count = pairs.cameras().len();
    let needs = |camera: usize| {
        let others = pairs.others(camera).map(|(other, _)| bytes.layers[other]);
        bytes.samples[camera] + bytes.layers[camera] + others.sum::<usize>()
    };
    if (0..count).all(|camera| needs(camera) <= bytes.bound) {
        return neighbors_within(pairs, bytes);
    }
    let cameras: Vec<usize> = (0..count).collect();
    let room = bytes.bound.saturating_sub(layers_at_a_time(bytes.layers));
    let in_parts = |cameras: Vec<usize>| {
        let parts = parts_beside(pairs, bytes.layers, &cameras);
        CameraGroup { cameras, parts }
    };
    chunks_within(&cameras, bytes.samples, room).into_iter().map(in_parts).collect()
}

/// All cameras that may see the samples of some, and these, in parts of a few layers.
pub(super) fn parts_beside(pairs: &OverlapGraph<'_>, layers: &[usize], cameras: &[usize]) -> Vec<Vec<usize>> {
    let others = cameras.iter().flat_map(|camera| pairs.others(*camera).map(|(other, _)| other));
    let compared: BTreeSet<usize> = others.chain(cameras.iter().copied()).collect();
    let compared: Vec<usize> = compared.into_iter().collect();
    chunks_within(&compared, layers, layers_at_a_time(layers))
}

/// Bytes of the layers that are held at a time.
fn layers_at_a_time(layers: &[usize]) -> usize {
    layers.iter().copied().max().unwrap_or(0) * LAYERS_AT_A_TIME
}

/// Cuts cameras into pieces that take no more than `bound` together, or are of one camera.
pub(super) fn chunks_within(cameras: &[usize], bytes: &[usize], bound: usize) -> Vec<Vec<usize>> {
    let mut chunks: Vec<Vec<usize>> = Vec::new();
    let mut taken = 0_usize;
    for &camera in cameras {
        taken = taken.saturating_add(bytes[camera]);
        match chunks.last_mut() {
            Some(chunk) if taken <= bound => chunk.push(camera),
            _ => {
                taken = bytes[camera];
                chunks.push(vec![camera]);
            }
        }
    }
    chunks
}

/// Groups of neighbors, each with all that may see their samples.
fn neighbors_within(pairs: &OverlapGraph<'_>, bytes: &CameraBytes<'_>) -> Vec<CameraGroup> {
    let mut groups = Vec::new();
    pairs.groups(|nearest| {
        let (mut held, mut held_bytes, mut taken) = (BTreeSet::new(), 0, 0);
        for &camera in nearest {
            let others = pairs.others(camera).map(|(other, _)| other).chain([camera]);
            let more: Vec<usize> = others.filter(|other| !held.contains(other)).collect();
            held_bytes +=
                bytes.samples[camera] + more.iter().map(|other| bytes.layers[*other]).sum::<usize>();
            if taken > 0 && held_bytes > bytes.bound {
                break;
            }
            held.extend(more);
            taken += 1;
        }
        let cameras = nearest[..taken].to_vec();
        groups.push(CameraGroup { cameras, parts: vec![held.into_iter().collect()] });
        taken
    });
    groups
}

/// A capture, and what is known of it.
#[derive(Clone, Copy)]
pub(super) struct Recording<'a> {
    pub(super) capture: &'a Capture,
    pub(super) scan: &'a TemporalScan,
    pub(super) settings: &'a Settings,
    /// Bytes that layers and the samples that are worked on may take, unless those of a single camera take more.
    pub(super) bound: usize,
}

/// The share of the memory setting that layers take, and what is held of all cameras beside them: numerator and denominator.
const SHARE: (usize, usize) = (3, 4);

impl<'a> Recording<'a> {
    /// With layers in a share of the memory setting.
    pub(super) fn new(capture: &'a Capture, scan: &'a TemporalScan, settings: &'a Settings) -> Self {
        // Whether each sample is kept is held of all cameras.
        let statuses: usize = capture.cameras.iter().map(|camera| camera.intrinsics.pixel_count()).sum();
        let share = settings.capture.memory_bytes() / SHARE.1 * SHARE.0;
        Self { capture, scan, settings, bound: share.saturating_sub(statuses) }
    }

    /// Whether there are samples of all frames only.
    pub(super) fn is_of_one_moment(&self) -> bool {
        self.scan.frames == 1 && self.scan.spans.is_some()
    }

    /// What each camera saw throughout, as a few boxes.
    pub(super) fn depth_bounds(&self, job: &Job) -> Result<Vec<DepthBounds>> {
        let of_camera = |camera: usize| {
            job.check()?;
            let spans = self.scan.spans.as_ref();
            let samples = spans.map(|spans| spans.get(camera, all_frames(self.scan.frames))).transpose()?;
            let samples = samples.flatten().unwrap_or_default();
            let depths = samples.pixels.iter().copied().zip(samples.inverse_depth.iter().copied());
            Ok(DepthBounds::new(self.capture.cameras[camera].intrinsics.size(), depths))
        };
        (0..self.capture.cameras.len()).into_par_iter().map(of_camera).collect()
    }

    /// Nothing is decided yet.
    pub(super) fn no_statuses(&self) -> Statuses {
        no_statuses(self.capture.cameras.iter().map(|camera| camera.intrinsics.pixel_count()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::{Camera, Intrinsics};
    use glam::DVec3;

    #[test]
    fn views_along_a_way_are_held_in_bounded_groups_with_all_that_see_their_samples() {
        let count = 60;
        let lens = Intrinsics::from_horizontal_angle(8, 8, 1.0);
        let cameras: Vec<Camera> = (0..count)
            .map(|index| {
                let eye = DVec3::X * (index * 37 % count) as f64;
                Camera::look_at(index.to_string(), lens, eye, eye + DVec3::Y, DVec3::Z)
            })
            .collect();
        let bounds = DepthBounds::new((8, 8), (0..64).map(|pixel| (pixel, 1.0 / 3.0)));
        let pairs = OverlapGraph::of_depths(&cameras, &vec![bounds; count]);
        let others = |camera: usize| pairs.others(camera).map(|(other, _)| other);
        let most = (0..count).map(|camera| others(camera).len()).max().unwrap() + 1;
        assert!((3..10).contains(&most));
        let (layers, samples) = (vec![10; count], vec![0; count]);
        let of_bound = |bound| {
            let bytes = CameraBytes { layers: &layers, samples: &samples, bound };
            let groups = neighbors_within(&pairs, &bytes);
            let mut all: Vec<usize> = groups.iter().flat_map(|group| group.cameras.clone()).collect();
            all.sort_unstable();
            assert_eq!(all, (0..count).collect::<Vec<_>>());
            groups
        };
        let groups = of_bound(150);
        assert!(groups.len() < 10);
        for group in &groups {
            let held = &group.parts[0];
            assert!(held.len() <= 15 && held.is_sorted());
            assert!(group.cameras.iter().all(|camera| others(*camera).all(|other| held.contains(&other))));
        }
        assert!(of_bound(1).iter().all(|group| group.parts[0].len() <= most), "a view with all that see it");
    }

    #[test]
    fn chunks_hold_every_camera_once_and_no_more_than_fits_unless_one_alone_does_not() {
        let bytes = [5, 5, 5, 30, 1, 1];
        assert_eq!(
            chunks_within(&[0, 1, 2, 3, 4, 5], &bytes, 10),
            [vec![0, 1], vec![2], vec![3], vec![4, 5]]
        );
    }
}
