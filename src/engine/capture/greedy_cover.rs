//! Views in the order of what each adds to those taken before it.
//!
//! Purpose: the fewest views that show everything cannot be found in reasonable time. Taking one after the other by what it adds needs
//! few more.
//!
//! Source: G. Nemhauser, L. Wolsey, M. Fisher, *An Analysis of Approximations for Maximizing Submodular Set Functions*, 1978: the first
//! views show at least 1 − 1/e of what the best choice of as many shows. V. Chvátal, *A Greedy Heuristic for the Set-Covering Problem*,
//! 1979: showing everything takes more views than the fewest by a factor that hardly grows. M. Minoux, *Accelerated Greedy Algorithms
//! for Maximizing Submodular Set Functions*, 1978: what a view adds never grows, so that most views need not be looked at again.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The part of a whole that the views taken so far show.
pub trait CoveredSet {
    /// What a view would add. It never grows when another view is taken.
    fn added_by(&self, view: usize) -> u64;

    /// Takes a view: from now on all that it shows is shown.
    fn take(&mut self, view: usize);
}

/// A view, and what it adds to those taken before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Addition {
    /// Its index.
    pub view: usize,
    /// In the unit of [`CoveredSet::added_by`].
    pub added: u64,
}

/// Takes a view at each step: the one that adds most, of equal ones the first. Ends when all views are taken.
pub struct GreedyCover<'a, S> {
    shown: &'a mut S,
    /// Each view that is left, with what it added when it was last looked at.
    at_most: BinaryHeap<(u64, Reverse<usize>)>,
}

impl<'a, S: CoveredSet> GreedyCover<'a, S> {
    /// Views are taken among `views`, which are different indices.
    pub fn new(shown: &'a mut S, views: impl Iterator<Item = usize>) -> Self {
        let at_most = views.map(|view| (shown.added_by(view), Reverse(view))).collect();
        Self { shown, at_most }
    }
}

impl<S: CoveredSet> Iterator for GreedyCover<'_, S> {
    type Item = Addition;

    fn next(&mut self) -> Option<Addition> {
        loop {
            let (_, Reverse(view)) = self.at_most.pop()?;
            let now = (self.shown.added_by(view), Reverse(view));
            if self.at_most.peek().is_some_and(|next| *next > now) {
                self.at_most.push(now);
                continue;
            }
            self.shown.take(view);
            return Some(Addition { view, added: now.0 });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points as bits; each view shows some.
    struct Bits {
        views: Vec<u64>,
        taken: u64,
    }

    impl CoveredSet for Bits {
        fn added_by(&self, view: usize) -> u64 {
            (self.views[view] & !self.taken).count_ones().into()
        }

        fn take(&mut self, view: usize) {
            self.taken |= self.views[view];
        }
    }

    /// The same without a shortcut: each view is looked at in each step.
    fn plain(mut bits: Bits) -> Vec<Addition> {
        let mut left: Vec<usize> = (0..bits.views.len()).collect();
        let mut order = Vec::new();
        while let Some(best) = left.iter().copied().max_by_key(|view| (bits.added_by(*view), Reverse(*view)))
        {
            order.push(Addition { view: best, added: bits.added_by(best) });
            bits.take(best);
            left.retain(|view| *view != best);
        }
        order
    }

    proptest::proptest! {
        #[test]
        fn views_come_in_the_order_in_which_looking_at_each_one_every_time_puts_them(
            views in proptest::collection::vec(0..1_u64 << 12, 0..20),
        ) {
            let mut bits = Bits { views: views.clone(), taken: 0 };
            let order: Vec<Addition> = GreedyCover::new(&mut bits, 0..views.len()).collect();
            proptest::prop_assert_eq!(order, plain(Bits { views, taken: 0 }));
        }
    }
}
