//! The order in which views are worked on, and groups of them that fit into memory with all views that matter to them.

use std::collections::VecDeque;

use crate::preprocess::registration::CameraPairs;

/// Views that are worked on together.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ViewGroup {
    /// Those that are worked on.
    pub(super) cameras: Vec<usize>,
    /// These and all that may see their samples, ascending.
    pub(super) held: Vec<usize>,
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

/// Cuts an order into groups. Those that a group holds take no more than `bound` together, or than a single view does with all that it
/// needs: memory that is taken once may be used throughout.
pub(super) fn groups<I: Iterator<Item = usize>>(
    order: &[usize],
    bytes: impl Fn(usize) -> usize,
    bound: usize,
    others: impl Fn(usize) -> I,
) -> Vec<ViewGroup> {
    let needed_by = |camera: usize| bytes(camera) + others(camera).map(&bytes).sum::<usize>();
    let bound = order.iter().map(|camera| needed_by(*camera)).fold(bound, usize::max);
    let mut groups: Vec<ViewGroup> = Vec::new();
    let mut is_held = vec![false; order.len()];
    let mut held_bytes = 0;
    for &camera in order {
        let needed = |is_held: &[bool]| -> Vec<usize> {
            others(camera).chain([camera]).filter(|other| !is_held[*other]).collect()
        };
        let mut more = needed(&is_held);
        let more_bytes: usize = more.iter().map(|other| bytes(*other)).sum();
        if groups.is_empty() || held_bytes + more_bytes > bound {
            is_held.fill(false);
            held_bytes = 0;
            more = needed(&is_held);
            groups.push(ViewGroup { cameras: Vec::new(), held: Vec::new() });
        }
        held_bytes += more.iter().map(|other| bytes(*other)).sum::<usize>();
        for other in &more {
            is_held[*other] = true;
        }
        if let Some(group) = groups.last_mut() {
            group.cameras.push(camera);
            group.held.extend(more);
        }
    }
    for group in &mut groups {
        group.held.sort_unstable();
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
        let groups = groups(&order, |_| 10, 150, of);
        assert!(groups.iter().all(|group| group.held.len() <= 15 && group.held.is_sorted()));
        assert!(groups.iter().map(|group| group.cameras.len()).sum::<usize>() == count && groups.len() < 20);
        for group in &groups {
            assert!(
                group.cameras.iter().all(|view| of(*view).chain([*view]).all(|it| group.held.contains(&it)))
            );
        }
        let tiny = super::groups(&order, |_| 10, 1, of);
        assert!(tiny.iter().all(|group| group.held.len() <= 7), "a view with all that see it, and no more");
        assert_eq!(tiny.iter().map(|group| group.cameras.len()).sum::<usize>(), count);
    }
}
