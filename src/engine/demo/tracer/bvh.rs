//! A bounding volume hierarchy over placed solids: nearest hit, and solids near a point.
//!
//! Source: Jeffrey Goldsmith and John Salmon, *Automatic Creation of Object Hierarchies for Ray Tracing* (1987), the
//! surface area heuristic. What differs: a demo scene has a few hundred solids, so every split of every axis is weighed.

use glam::DVec3;

use super::hits::slab;

/// An axis-aligned box, from the corner with the least to the one with the greatest coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Aabb {
    pub(crate) low: DVec3,
    pub(crate) high: DVec3,
}

impl Aabb {
    fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    fn center(&self) -> DVec3 {
        0.5 * (self.low + self.high)
    }

    fn distance_squared(&self, point: DVec3) -> f64 {
        (self.low - point).max(point - self.high).max(DVec3::ZERO).length_squared()
    }

    fn is_met_by(&self, ray: &BoundsRay, t_max: f64) -> bool {
        let (enter, leave) = slab(ray.origin, ray.inverse_direction, self.low, self.high);
        enter <= leave && leave > 0.0 && enter < t_max
    }

    fn half_area(&self) -> f64 {
        let size = self.high - self.low;
        size.x * size.y + size.y * size.z + size.z * size.x
    }
}

/// A ray prepared for tests against boxes.
struct BoundsRay {
    origin: DVec3,
    inverse_direction: DVec3,
}

/// A leaf holds `count > 0` items from `first` in `order`; an inner node has its children at `first` and `first + 1`.
#[derive(Clone, Copy, Debug)]
struct BvhNode {
    bounds: Aabb,
    first: u32,
    count: u32,
}

/// The hierarchy; items are known by their index in the slice it was built from.
#[derive(Debug)]
pub(crate) struct Bvh {
    nodes: Vec<BvhNode>,
    order: Vec<u32>,
}

const LEAF_ITEMS: usize = 1;
/// Entries of the stack of nodes yet to visit; splits keep to [`MAX_DEPTH`].
const STACK: usize = 64;
/// Below this depth nodes are split at the median.
const MAX_DEPTH: usize = 24;

impl Bvh {
    /// Builds over the boxes of all items.
    pub(crate) fn new(items: &[Aabb]) -> Self {
        let mut order: Vec<u32> = (0..items.len() as u32).collect();
        let mut nodes = Vec::with_capacity(2 * items.len() + 1);
        if !items.is_empty() {
            nodes.push(BvhNode { bounds: items[0], first: 0, count: 0 });
            BvhBuilder { items, order: &mut order, nodes: &mut nodes }.split(0, 0, items.len(), 0);
        }
        Self { nodes, order }
    }

    /// Calls `test(item, t_max)` for items whose box the ray meets before `t_max`, nearer boxes first; a returned `t`
    /// becomes the new `t_max`.
    pub(crate) fn for_each_before(
        &self,
        origin: DVec3,
        direction: DVec3,
        mut t_max: f64,
        mut test: impl FnMut(usize, f64) -> Option<f64>,
    ) {
        let ray = BoundsRay { origin, inverse_direction: direction.recip() };
        self.visit(
            |node, t_max: &mut f64| node.bounds.is_met_by(&ray, *t_max),
            |node| (node.bounds.center() - origin).dot(direction),
            &mut t_max,
            |item, t_max| {
                if let Some(t) = test(item, *t_max) {
                    *t_max = t;
                }
            },
        );
    }

    /// Calls `found` for items whose box comes within `radius` of `point`.
    pub(crate) fn for_each_near(&self, point: DVec3, radius: f64, mut found: impl FnMut(usize)) {
        self.visit(
            |node, ()| node.bounds.distance_squared(point) <= radius * radius,
            |_| 0.0,
            &mut (),
            |item, ()| found(item),
        );
    }

    fn visit<S>(
        &self,
        enter: impl Fn(&BvhNode, &mut S) -> bool,
        rank: impl Fn(&BvhNode) -> f64,
        state: &mut S,
        mut item: impl FnMut(usize, &mut S),
    ) {
        let mut stack = [0_u32; STACK];
        let mut depth = usize::from(!self.nodes.is_empty());
        while depth > 0 {
            depth -= 1;
            let node = &self.nodes[stack[depth] as usize];
            if !enter(node, state) {
                continue;
            }
            let first = node.first as usize;
            if node.count > 0 {
                for index in &self.order[first..first + node.count as usize] {
                    item(*index as usize, state);
                }
            } else {
                let nearer = usize::from(rank(&self.nodes[first + 1]) < rank(&self.nodes[first]));
                stack[depth] = (first + 1 - nearer) as u32;
                stack[depth + 1] = (first + nearer) as u32;
                depth += 2;
            }
        }
    }
}

/// What building needs besides the range it splits.
struct BvhBuilder<'a> {
    items: &'a [Aabb],
    order: &'a mut [u32],
    nodes: &'a mut Vec<BvhNode>,
}

impl BvhBuilder<'_> {
    fn bounds(&self, order: &[u32]) -> Aabb {
        order.iter().map(|item| self.items[*item as usize]).reduce(Aabb::union).unwrap_or(self.items[0])
    }

    fn split(&mut self, node: usize, start: usize, end: usize, depth: usize) {
        let bounds = self.bounds(&self.order[start..end]);
        if end - start <= LEAF_ITEMS {
            self.nodes[node] = BvhNode { bounds, first: start as u32, count: (end - start) as u32 };
            return;
        }
        let middle = start + self.best_split(start, end, depth);
        let first = self.nodes.len();
        self.nodes.extend([self.nodes[node]; 2]);
        self.nodes[node] = BvhNode { bounds, first: first as u32, count: 0 };
        self.split(first, start, middle, depth + 1);
        self.split(first + 1, middle, end, depth + 1);
    }

    /// Sorts the range along the best axis and gives the number of items for the first child.
    fn best_split(&mut self, start: usize, end: usize, depth: usize) -> usize {
        let count = end - start;
        let mut best = (f64::INFINITY, 0, count / 2);
        for axis in 0..3 {
            self.sort(start, end, axis);
            let order = &self.order[start..end];
            let mut areas_after = vec![0.0; count];
            let mut bounds = self.items[order[count - 1] as usize];
            for split in (1..count).rev() {
                bounds = bounds.union(self.items[order[split] as usize]);
                areas_after[split] = bounds.half_area();
            }
            let mut bounds = self.items[order[0] as usize];
            for split in 1..count {
                bounds = bounds.union(self.items[order[split - 1] as usize]);
                let cost = bounds.half_area() * split as f64 + areas_after[split] * (count - split) as f64;
                if cost < best.0 {
                    best = (cost, axis, split);
                }
            }
        }
        self.sort(start, end, best.1);
        if depth < MAX_DEPTH { best.2 } else { count / 2 }
    }

    fn sort(&mut self, start: usize, end: usize, axis: usize) {
        let items = self.items;
        self.order[start..end].sort_by(|a, b| {
            let center = |item: &u32| items[*item as usize].center()[axis];
            center(a).total_cmp(&center(b)).then(a.cmp(b))
        });
    }
}

#[cfg(test)]
mod tests {
    use super::{Aabb, Bvh};
    use crate::demo::ALL;
    use crate::demo::tracer::world::World;
    use glam::DVec3;
    use proptest::prelude::*;

    fn nearest_by_brute_force(world: &World, origin: DVec3, direction: DVec3) -> Option<f64> {
        (0..world.solids.len())
            .filter_map(|index| world.hit_solid(index, origin, direction, f64::INFINITY))
            .min_by(f64::total_cmp)
    }

    #[test]
    fn the_hierarchy_finds_the_hit_that_trying_every_solid_finds() {
        for scene in ALL {
            let world = scene.world(0.3);
            for index in 0..400 {
                let angle = f64::from(index) * 2.399_963;
                let origin = DVec3::new(1.7 * angle.cos(), -1.9, 0.4 + 0.004 * f64::from(index));
                let target = DVec3::new(0.9 * (angle * 3.0).sin(), 0.4 * (angle * 7.0).cos(), 0.9);
                let direction = target - origin;
                let found = world.hit((origin, direction)).map(|hit| hit.t);
                assert_eq!(found, nearest_by_brute_force(&world, origin, direction));
            }
        }
    }

    #[test]
    fn an_empty_hierarchy_is_never_met() {
        let empty = Bvh::new(&[]);
        empty.for_each_near(DVec3::ZERO, 1e9, |_| panic!("there is nothing to find"));
    }

    proptest! {
        #[test]
        fn all_boxes_near_a_point_are_found(
            lows in prop::collection::vec(prop::array::uniform3(-5.0..5.0_f64), 1..60),
            point in prop::array::uniform3(-5.0..5.0_f64),
            radius in 0.1..3.0_f64,
        ) {
            let boxes: Vec<Aabb> = lows
                .into_iter()
                .map(|low| Aabb { low: low.into(), high: DVec3::from(low) + DVec3::splat(0.5) })
                .collect();
            let point = DVec3::from(point);
            let mut found = Vec::new();
            Bvh::new(&boxes).for_each_near(point, radius, |item| found.push(item));
            found.sort_unstable();
            let near = |b: &Aabb| b.distance_squared(point) <= radius * radius;
            let expected: Vec<usize> = (0..boxes.len()).filter(|index| near(&boxes[*index])).collect();
            prop_assert!(expected.iter().all(|item| found.contains(item)));
        }
    }
}
