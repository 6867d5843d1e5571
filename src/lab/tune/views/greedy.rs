//! The fewest views that show a share of all seen surfaces, and the order of the other views by what each adds.
//!
//! Source: [`GreedyCover`]. What differs: a view is dropped again if the others show everything that it shows, and each surface counts
//! once, however many views saw it. A surface that n views show has a point in each of them, so each point weighs 1/n.

use super::visibility::{ShownOf, ShownPoints, all_bits, common_bits};
use overlook_engine::capture::{Addition, CoveredSet, GreedyCover};

/// Weight of a point that a single view shows. It is a multiple of 1 to 16, so that weights are whole and sums do not depend on their
/// order.
const WEIGHT: u64 = 720_720;

/// What all views show.
pub(super) struct Coverage {
    shown: Vec<ShownPoints>,
    /// Weight of every point of every view.
    weights: Vec<Vec<u64>>,
    /// Weight of all points together.
    pub(super) total: u64,
}

impl Coverage {
    /// Weighs the points; `counts` has the number of points of each [`SeenPoints`](super::surface_points::SeenPoints).
    pub(super) fn new(shown: Vec<ShownPoints>, counts: &[usize]) -> Self {
        let mut weights: Vec<Vec<u64>> = counts.iter().map(|count| vec![0; *count]).collect();
        for of in shown.iter().flatten() {
            common_bits(&of.bits, &of.bits).for_each(|nth| weights[of.seen][nth] += 1);
        }
        // At least the view that saw a point shows it.
        weights.iter_mut().flatten().for_each(|views| *views = WEIGHT / (*views).max(1));
        Self { total: weights.iter().flatten().sum(), weights, shown }
    }

    /// All views that add a point, in order, and the number of needed ones, which come first. The needed views together show at least
    /// `goal` of [`Coverage::total`]; without any one of them they would show less.
    pub(super) fn order(&self, goal: u64) -> (Vec<Addition>, usize) {
        let mut missing = self.all_points();
        let mut found = self.by_what_each_adds(0..self.shown.len(), &mut missing, goal);
        let mut needed = self.without_needless(found.iter().map(|addition| addition.view).collect(), goal);
        needed.sort_unstable();
        missing = self.all_points();
        found = self.by_what_each_adds(needed.iter().copied(), &mut missing, self.total);
        let count = found.len();
        let others = (0..self.shown.len()).filter(|view| needed.binary_search(view).is_err());
        found.extend(self.by_what_each_adds(others, &mut missing, self.total));
        (found, count)
    }

    fn all_points(&self) -> Vec<Vec<u64>> {
        self.weights.iter().map(|weights| all_bits(weights.len())).collect()
    }

    /// Takes the view that adds most, again and again, until the views taken have added `goal` or no view adds anything.
    fn by_what_each_adds(
        &self,
        views: impl Iterator<Item = usize>,
        missing: &mut [Vec<u64>],
        goal: u64,
    ) -> Vec<Addition> {
        let mut missing = Missing { coverage: self, points: missing };
        let mut additions = GreedyCover::new(&mut missing, views).take_while(|addition| addition.added > 0);
        let (mut order, mut sum) = (Vec::new(), 0);
        while sum < goal
            && let Some(addition) = additions.next()
        {
            sum += addition.added;
            order.push(addition);
        }
        order
    }

    /// For each view the weight of the points that it alone shows.
    pub(super) fn alone(&self) -> Vec<u64> {
        let views: Vec<usize> = (0..self.shown.len()).collect();
        let shown_by = self.shown_by(&views);
        views.into_iter().map(|view| self.alone_of(view, &shown_by)).collect()
    }

    /// How many of these views show each point.
    fn shown_by(&self, views: &[usize]) -> Vec<Vec<u32>> {
        let mut shown_by: Vec<Vec<u32>> = self.weights.iter().map(|weights| vec![0; weights.len()]).collect();
        for of in views.iter().flat_map(|view| &self.shown[*view]) {
            common_bits(&of.bits, &of.bits).for_each(|nth| shown_by[of.seen][nth] += 1);
        }
        shown_by
    }

    /// The weight of the points that a view shows and that are shown by one view.
    fn alone_of(&self, view: usize, shown_by: &[Vec<u32>]) -> u64 {
        let of = |of: &ShownOf| -> u64 {
            let points = common_bits(&of.bits, &of.bits).filter(|nth| shown_by[of.seen][*nth] == 1);
            points.map(|nth| self.weights[of.seen][nth]).sum()
        };
        self.shown[view].iter().map(of).sum()
    }

    /// Drops each view whose absence leaves the others at the goal; `views` must reach it together. The view with the smallest weight
    /// of points that it alone shows is tried first.
    fn without_needless(&self, mut views: Vec<usize>, goal: u64) -> Vec<usize> {
        let mut shown_by = self.shown_by(&views);
        let all = shown_by.iter().flatten().zip(self.weights.iter().flatten());
        let mut sum: u64 = all.filter(|(views, _)| **views > 0).map(|(_, weight)| weight).sum();
        let mut least_first: Vec<(u64, usize)> =
            views.iter().map(|view| (self.alone_of(*view, &shown_by), *view)).collect();
        least_first.sort_unstable();
        for (_, view) in least_first {
            let lost = self.alone_of(view, &shown_by);
            if sum - lost >= goal {
                sum -= lost;
                for of in &self.shown[view] {
                    common_bits(&of.bits, &of.bits).for_each(|nth| shown_by[of.seen][nth] -= 1);
                }
                views.retain(|other| *other != view);
            }
        }
        views
    }
}

/// The points that the views taken so far do not show.
struct Missing<'a> {
    coverage: &'a Coverage,
    points: &'a mut [Vec<u64>],
}

impl CoveredSet for Missing<'_> {
    fn added_by(&self, view: usize) -> u64 {
        let weights = &self.coverage.weights;
        let of = |of: &ShownOf| -> u64 {
            common_bits(&of.bits, &self.points[of.seen]).map(|nth| weights[of.seen][nth]).sum()
        };
        self.coverage.shown[view].iter().map(of).sum()
    }

    fn take(&mut self, view: usize) {
        for of in &self.coverage.shown[view] {
            let points = self.points[of.seen].iter_mut().zip(&of.bits);
            points.for_each(|(missing, shown)| *missing &= !shown);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Views that show some of the points of one view that has six, given as bits.
    fn of_six(bits: &[u64]) -> Coverage {
        let views = bits.iter().map(|bits| vec![ShownOf { seen: 0, bits: vec![*bits] }]).collect();
        Coverage::new(views, &[6])
    }

    fn views((order, needed): &(Vec<Addition>, usize)) -> (Vec<usize>, usize) {
        (order.iter().map(|addition| addition.view).collect(), *needed)
    }

    #[test]
    fn the_view_that_adds_most_comes_first_and_one_that_adds_nothing_does_not_come() {
        let all = of_six(&[0b00_0011, 0b11_1100, 0b01_1000, 0b00_0110]);
        let found = all.order(all.total);
        assert_eq!(views(&found), (vec![1, 0], 2));
        assert_eq!(found.0.iter().map(|addition| addition.added).sum::<u64>(), all.total);
        assert!(found.0[0].added > found.0[1].added);
        assert_eq!(all.alone(), [WEIGHT, WEIGHT, 0, 0], "the other points are shown by several");
        assert_eq!(views(&all.order(all.total / 2)).1, 1, "as many as are asked for, and then the others");
        assert_eq!(views(&all.order(all.total / 2)).0.len(), 2);
    }

    #[test]
    fn a_view_is_dropped_again_that_others_made_needless() {
        // The first shows the most, but the others are needed for the rest, and show what it shows as well.
        let all = of_six(&[0b01_1110, 0b00_0111, 0b11_1000]);
        assert_eq!(views(&all.order(all.total)), (vec![1, 2], 2));
    }

    #[test]
    fn of_equal_views_the_first_is_taken_and_a_surface_that_many_saw_counts_once() {
        let twins = of_six(&[0b11_1111, 0b11_1111, 0b11_1111]);
        assert_eq!(twins.order(twins.total).0, [Addition { view: 0, added: twins.total }]);
        // Three views saw the first point and have one of it each; a fourth saw two points that no other did.
        let shown = (0..3).map(|_| (0..3).map(|seen| ShownOf { seen, bits: vec![1] }).collect());
        let shown: Vec<ShownPoints> = shown.chain([vec![ShownOf { seen: 3, bits: vec![0b11] }]]).collect();
        let all = Coverage::new(shown, &[1, 1, 1, 2]);
        assert_eq!(
            all.order(all.total).0,
            [Addition { view: 3, added: 2 * WEIGHT }, Addition { view: 0, added: WEIGHT }]
        );
    }
}
