//! Which cameras are worked on together, and which layers they are compared with meanwhile, within memory.
//!
//! ```text
//! all layers fit              one group of all cameras, one part of all layers
//! those of neighbors fit      groups of neighbors, each with one part: all that may see their samples
//! else                        groups of cameras whose samples fit beside a few layers, each with all other layers, part by part
//! ```

use std::collections::{BTreeSet, VecDeque};

use crate::preprocess::registration::CameraPairs;

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
    /// Of each camera's layer.
    pub(super) layers: &'a [usize],
    /// Of each camera's samples while they are worked on.
    pub(super) samples: &'a [usize],
    /// How much may be taken, unless a single camera takes more.
    pub(super) bound: usize,
}

/// Layers that are held at a time where not all fit. With fewer, what is known of each sample is taken up more often; with more, there is
/// room for fewer samples, and layers are read more often.
pub(super) const LAYERS_AT_A_TIME: usize = 4;

/// Groups of all cameras.
pub(super) fn groups_within(pairs: &CameraPairs<'_>, bytes: &CameraBytes<'_>) -> Vec<CameraGroup> {
    let count = pairs.cameras().len();
    let needs = |camera: usize| {
        let others = pairs.others(camera).map(|(other, _)| bytes.layers[other]);
        bytes.samples[camera] + bytes.layers[camera] + others.sum::<usize>()
    };
    if (0..count).all(|camera| needs(camera) <= bytes.bound) {
        let order = neighborhood_order(pairs);
        return groups(&order, bytes, |camera| pairs.others(camera).map(|(other, _)| other));
    }
    let largest = bytes.layers.iter().copied().max().unwrap_or(0) * LAYERS_AT_A_TIME;
    let cameras: Vec<usize> = (0..count).collect();
    let room = bytes.bound.saturating_sub(largest);
    let group = |cameras: Vec<usize>| {
        let others = cameras.iter().flat_map(|camera| pairs.others(*camera).map(|(other, _)| other));
        let compared: BTreeSet<usize> = others.chain(cameras.iter().copied()).collect();
        let compared: Vec<usize> = compared.into_iter().collect();
        CameraGroup { cameras, parts: chunks_within(&compared, bytes.layers, largest) }
    };
    chunks_within(&cameras, bytes.samples, room).into_iter().map(group).collect()
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

/// An order in which views that may see the same come soon after each other: breadth first, from a view with few others on, those
/// with few others first (E. Cuthill and J. McKee, *Reducing the Bandwidth of Sparse Symmetric Matrices*, 1969).
pub(super) fn neighborhood_order(pairs: &CameraPairs<'_>) -> Vec<usize> {
    order_of(pairs.cameras().len(), |camera| pairs.others(camera).map(|(other, _)| other))
}

fn order_of<I: ExactSizeIterator<Item = usize>>(count: usize, others: impl Fn(usize) -> I) -> Vec<usize> {
    let degree = |camera: &usize| (others(*camera).len(), *camera);
    let mut starts: Vec<usize> = (0..count).collect();
    starts.sort_by_key(degree);
    let mut is_met = vec![false; count];
    let mut order = Vec::with_capacity(count);
    for start in starts {
        let mut queue = VecDeque::from_iter((!is_met[start]).then_some(start));
        is_met[start] = true;
        while let Some(camera) = queue.pop_front() {
            order.push(camera);
            let mut next: Vec<usize> = others(camera).filter(|other| !is_met[*other]).collect();
            next.sort_by_key(degree);
            for other in &next {
                is_met[*other] = true;
            }
            queue.extend(next);
        }
    }
    order
}

/// Cuts an order into groups, each with all others that matter to its cameras.
fn groups<I: Iterator<Item = usize>>(
    order: &[usize],
    bytes: &CameraBytes<'_>,
    others: impl Fn(usize) -> I,
) -> Vec<CameraGroup> {
    let mut groups: Vec<CameraGroup> = Vec::new();
    let mut held: Vec<usize> = Vec::new();
    let mut is_held = vec![false; order.len()];
    let mut held_bytes = 0;
    for &camera in order {
        let needed = |is_held: &[bool]| -> Vec<usize> {
            others(camera).chain([camera]).filter(|other| !is_held[*other]).collect()
        };
        let bytes_of = |more: &[usize]| {
            bytes.samples[camera] + more.iter().map(|other| bytes.layers[*other]).sum::<usize>()
        };
        let mut more = needed(&is_held);
        if groups.is_empty() || held_bytes + bytes_of(&more) > bytes.bound {
            is_held.fill(false);
            held_bytes = 0;
            held.clear();
            more = needed(&is_held);
            groups.push(CameraGroup { cameras: Vec::new(), parts: vec![Vec::new()] });
        }
        held_bytes += bytes_of(&more);
        for other in &more {
            is_held[*other] = true;
        }
        held.extend(more);
        if let Some(group) = groups.last_mut() {
            group.cameras.push(camera);
            group.parts[0].clone_from(&held);
            group.parts[0].sort_unstable();
        }
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Views along a way, each seen by those up to three steps away; `shuffled` has the view at each place.
    fn others(place: usize, shuffled: &[usize]) -> Vec<usize> {
        let near = place.saturating_sub(3)..(place + 4).min(shuffled.len());
        near.filter(|other| *other != place).map(|other| shuffled[other]).collect()
    }

    #[test]
    fn views_along_a_way_are_ordered_along_it_and_held_in_bounded_groups() {
        let count = 100;
        let shuffled: Vec<usize> = (0..count).map(|place| place * 37 % count).collect();
        let mut place_of = vec![0; count];
        shuffled.iter().enumerate().for_each(|(place, view)| place_of[*view] = place);
        let of = |view: usize| others(place_of[view], &shuffled).into_iter();
        let order = order_of(count, of);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..count).collect::<Vec<_>>());
        let strides = order.windows(2).map(|pair| place_of[pair[0]].abs_diff(place_of[pair[1]]));
        assert!(strides.max().unwrap() <= 6);
        let (layers, samples) = (vec![10; count], vec![0; count]);
        let of_bound = |bound| groups(&order, &CameraBytes { layers: &layers, samples: &samples, bound }, of);
        let groups = of_bound(150);
        let held = |group: &CameraGroup| group.parts[0].clone();
        assert!(groups.iter().all(|group| held(group).len() <= 15 && held(group).is_sorted()));
        assert!(groups.iter().map(|group| group.cameras.len()).sum::<usize>() == count && groups.len() < 20);
        for group in &groups {
            assert!(
                group.cameras.iter().all(|view| of(*view).chain([*view]).all(|it| held(group).contains(&it)))
            );
        }
        let tiny = of_bound(1);
        assert!(tiny.iter().all(|group| held(group).len() <= 7), "a view with all that see it, and no more");
        assert_eq!(tiny.iter().map(|group| group.cameras.len()).sum::<usize>(), count);
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
