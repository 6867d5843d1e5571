//! A bounding volume hierarchy over placed solids: nearest hit, solids near a point, solids along a widening ray.
//!
//! Source: Steven Rubin and Turner Whitted, *A 3-dimensional representation for fast rendering of complex scenes*
//! (1980). What differs: a demo scene has a few hundred solids and is rebuilt for every frame, so the median split of
//! the longest axis is enough.

use glam::DVec3;

use super::shapes::slab;

/// An axis-aligned box, from the corner with the least to the one with the greatest coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    pub(super) low: DVec3,
    pub(super) high: DVec3,
}

impl Bounds {
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

    /// Distances along the unit vector `direction` between which a cone from `origin` that widens by `spread` per
    /// meter may touch the box; the first exceeds the second where it never does.
    pub(super) fn cone_span(&self, origin: DVec3, direction: DVec3, spread: f64) -> (f64, f64) {
        let grown = self.grown(spread * self.farthest(origin));
        slab(origin, direction.recip(), grown.low, grown.high)
    }

    fn grown(&self, by: f64) -> Self {
        Self { low: self.low - DVec3::splat(by), high: self.high + DVec3::splat(by) }
    }

    fn farthest(&self, point: DVec3) -> f64 {
        (point - self.low).abs().max((point - self.high).abs()).length()
    }
}

/// A ray prepared for tests against boxes.
struct BoundsRay {
    origin: DVec3,
    inverse_direction: DVec3,
}

/// A leaf holds `count > 0` items from `first` in `order`; an inner node has its children at `first` and `first + 1`.
#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Bounds,
    first: u32,
    count: u32,
}

/// The hierarchy; items are known by their index in the slice it was built from.
#[derive(Clone, Debug)]
pub(super) struct Bvh {
    nodes: Vec<Node>,
    order: Vec<u32>,
}

const LEAF_ITEMS: usize = 2;
/// Deep enough for 2³² items split at the median.
const STACK: usize = 64;

impl Bvh {
    /// Builds over the boxes of all items.
    pub(super) fn new(items: &[Bounds]) -> Self {
        let mut order: Vec<u32> = (0..items.len() as u32).collect();
        let mut nodes = Vec::with_capacity(2 * items.len() + 1);
        if !items.is_empty() {
            nodes.push(Node { bounds: items[0], first: 0, count: 0 });
            build(items, &mut order, &mut nodes, 0, (0, items.len()));
        }
        Self { nodes, order }
    }

    /// Calls `test(item, t_max)` for items whose box the ray meets before `t_max`, nearer boxes first; a returned `t`
    /// becomes the new `t_max`.
    pub(super) fn for_each_before(
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
    pub(super) fn for_each_near(&self, point: DVec3, radius: f64, mut found: impl FnMut(usize)) {
        self.visit(
            |node, ()| node.bounds.distance_squared(point) <= radius * radius,
            |_| 0.0,
            &mut (),
            |item, ()| found(item),
        );
    }

    /// Calls `found` for items whose box meets a cone from `origin` along the unit vector `direction` that widens by
    /// `spread` per meter; stops once `found` gives `false`.
    pub(super) fn for_each_in_cone(
        &self,
        origin: DVec3,
        direction: DVec3,
        spread: f64,
        mut found: impl FnMut(usize) -> bool,
    ) {
        let ray = BoundsRay { origin, inverse_direction: direction.recip() };
        let mut going = true;
        self.visit(
            |node, going: &mut bool| {
                let margin = spread * node.bounds.farthest(origin);
                *going && node.bounds.grown(margin).is_met_by(&ray, f64::INFINITY)
            },
            |_| 0.0,
            &mut going,
            |item, going| *going = *going && found(item),
        );
    }

    fn visit<S>(
        &self,
        enter: impl Fn(&Node, &mut S) -> bool,
        rank: impl Fn(&Node) -> f64,
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

fn build(items: &[Bounds], order: &mut [u32], nodes: &mut Vec<Node>, node: usize, range: (usize, usize)) {
    let (start, end) = range;
    let bounds =
        order[start..end].iter().map(|item| items[*item as usize]).reduce(Bounds::union).unwrap_or(items[0]);
    if end - start <= LEAF_ITEMS {
        nodes[node] = Node { bounds, first: start as u32, count: (end - start) as u32 };
        return;
    }
    let size = bounds.high - bounds.low;
    let axis = if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    order[start..end].sort_by(|a, b| {
        let center = |item: &u32| items[*item as usize].center()[axis];
        center(a).total_cmp(&center(b)).then(a.cmp(b))
    });
    let middle = usize::midpoint(start, end);
    let first = nodes.len();
    nodes.push(nodes[node]);
    nodes.push(nodes[node]);
    nodes[node] = Node { bounds, first: first as u32, count: 0 };
    build(items, order, nodes, first, (start, middle));
    build(items, order, nodes, first + 1, (middle, end));
}
