//! Samples in space, to find those that are near a place.
//!
//! Source: k-d trees (J. L. Bentley, 1975), as a balanced array. What differs: each point reaches so far around itself, and is found from
//! where it reaches as well as by who reaches it.

/// Points of a leaf, at most.
const LEAF: usize = 16;

/// A sample as a point. Coordinates count from an origin that all share, world units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub(super) at: [f32; 3],
    /// World units.
    pub(super) reach: f32,
    /// How far it would reach if it were seen head-on, world units.
    pub(super) head_on: f32,
    /// Index of its image.
    pub(super) image: u32,
    /// Index into the planes of its image.
    pub(super) index: u32,
}

impl Point {
    pub(super) fn distance_squared(&self, at: [f32; 3]) -> f32 {
        (0..3).map(|axis| (self.at[axis] - at[axis]).powi(2)).sum()
    }
}

#[derive(Clone, Copy, Debug)]
struct Node {
    least: [f32; 3],
    most: [f32; 3],
    /// The farthest that one of its points reaches.
    reach: f32,
}

impl Node {
    fn of(points: &[Point]) -> Self {
        let empty = Self { least: [f32::INFINITY; 3], most: [f32::NEG_INFINITY; 3], reach: 0.0 };
        points.iter().fold(empty, |node, point| Self {
            least: std::array::from_fn(|axis| node.least[axis].min(point.at[axis])),
            most: std::array::from_fn(|axis| node.most[axis].max(point.at[axis])),
            reach: node.reach.max(point.reach),
        })
    }

    fn distance_squared(&self, at: [f32; 3]) -> f32 {
        let beside = |axis: usize| (self.least[axis] - at[axis]).max(at[axis] - self.most[axis]).max(0.0);
        (0..3).map(|axis| beside(axis).powi(2)).sum()
    }
}

/// Points in a balanced tree.
#[derive(Debug, Default)]
pub(super) struct PointTree {
    points: Vec<Point>,
    /// The root is at 0; the children of node `n` are `2n + 1` and `2n + 2`.
    nodes: Vec<Node>,
    /// Levels below the root.
    depth: u32,
}

impl PointTree {
    /// The same points in the same order give the same tree.
    pub(super) fn new(mut points: Vec<Point>) -> Self {
        let leaves = points.len().div_ceil(LEAF).max(1);
        let depth = leaves.next_power_of_two().trailing_zeros();
        let mut nodes = vec![Node::of(&[]); (2 << depth) - 1];
        split(&mut points, 0, depth, &mut nodes);
        Self { points, nodes, depth }
    }

    /// In the order of the tree.
    pub(super) fn points(&self) -> &[Point] {
        &self.points
    }

    /// The number of nodes; a node of points has those below it as well.
    pub(super) fn node_count(&self) -> usize {
        self.nodes.len()
    }

    /// The leaf that a point is in, by its place among [`PointTree::points`], and all nodes above it.
    pub(super) fn nodes_of(&self, point: usize) -> impl Iterator<Item = usize> {
        let mut range = 0..self.points.len();
        let mut next = Some(0);
        let mut level = 0;
        let depth = self.depth;
        std::iter::from_fn(move || {
            let node = next?;
            next = (level < depth).then(|| {
                level += 1;
                let middle = range.start + range.len() / 2;
                let is_right = point >= middle;
                range = if is_right { middle..range.end } else { range.start..middle };
                2 * node + 1 + usize::from(is_right)
            });
            Some(node)
        })
    }

    /// Calls `found` with each point within `reach` of `at`, or whose own reach holds `at`, until it gives false. Only nodes that `enters`
    /// are looked into.
    pub(super) fn for_each_near(
        &self,
        at: [f32; 3],
        reach: f32,
        enters: impl Fn(usize) -> bool,
        mut found: impl FnMut(usize) -> bool,
    ) {
        let mut open = vec![(0, 0..self.points.len(), 0)];
        while let Some((index, range, level)) = open.pop() {
            let node = &self.nodes[index];
            if range.is_empty() || node.distance_squared(at) > node.reach.max(reach).powi(2) || !enters(index)
            {
                continue;
            }
            if level < self.depth {
                let middle = range.start + range.len() / 2;
                open.push((2 * index + 2, middle..range.end, level + 1));
                open.push((2 * index + 1, range.start..middle, level + 1));
                continue;
            }
            for place in range {
                let point = &self.points[place];
                let is_near = point.distance_squared(at) <= point.reach.max(reach).powi(2);
                if is_near && !found(place) {
                    return;
                }
            }
        }
    }
}

/// Puts points into the order of a tree, and notes its nodes from `index` on.
fn split(points: &mut [Point], index: usize, levels: u32, nodes: &mut [Node]) {
    let node = Node::of(points);
    nodes[index] = node;
    if levels == 0 {
        return;
    }
    let middle = points.len() / 2;
    if points.len() > 1 {
        let sides: [f32; 3] = std::array::from_fn(|axis| node.most[axis] - node.least[axis]);
        let axis = (0..3).fold(0, |widest, axis| if sides[axis] > sides[widest] { axis } else { widest });
        points.select_nth_unstable_by(middle, |a, b| {
            a.at[axis].total_cmp(&b.at[axis]).then_with(|| (a.image, a.index).cmp(&(b.image, b.index)))
        });
    }
    let (left, right) = points.split_at_mut(middle);
    split(left, 2 * index + 1, levels - 1, nodes);
    split(right, 2 * index + 2, levels - 1, nodes);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{mix, uniform_pair};

    #[test]
    fn points_are_found_that_lie_near_and_those_that_reach_so_far() {
        let drawn = |index: u32| {
            let [[x, y], [z, reach]] = [0, 1].map(|nth| uniform_pair(mix(u64::from(2 * index + nth))));
            Point { at: [x, y, 0.2 * z], reach: 0.1 * reach, head_on: 0.1 * reach, image: 0, index }
        };
        let points: Vec<Point> = (0..1500).map(drawn).collect();
        let tree = PointTree::new(points.clone());
        for point in &points[..40] {
            let expected: Vec<u32> = points
                .iter()
                .filter(|it| it.distance_squared(point.at) <= it.reach.max(point.reach).powi(2))
                .map(|it| it.index)
                .collect();
            let mut found = Vec::new();
            tree.for_each_near(
                point.at,
                point.reach,
                |_| true,
                |place| {
                    found.push(tree.points()[place].index);
                    true
                },
            );
            found.sort_unstable();
            assert_eq!(found, expected);
        }
        let leaf = tree.nodes_of(700).last().unwrap();
        assert!(leaf >= tree.node_count() / 2, "the last of its nodes is a leaf");
        let point = tree.points()[700];
        let mut found = false;
        let above: Vec<usize> = tree.nodes_of(700).collect();
        tree.for_each_near(
            point.at,
            0.0,
            |node| above.contains(&node),
            |place| {
                found |= place == 700;
                true
            },
        );
        assert!(found, "a point is in the nodes that are said to hold it");
    }
}
