//! The rule that chooses among measured settings: the simplest that surely gives up next to nothing.
//!
//! Purpose: no more model than the scene needs, and never more than a stated loss of accuracy. A setting is good enough if it gives
//! up less than a bound in dB against the most accurate one, with 95 % confidence, by their differences vantage by vantage
//! ([`PairedDifference`]).
//!
//! Source: the simplest within one standard error, of Breiman, Friedman, Olshen and Stone, *Classification and Regression Trees*, 1984.
//! What differs: the error is that of the difference, the bound is in dB, and the confidence is that of all comparisons together
//! (Bonferroni), because the simplest of many is easily a lucky one. If there are too few vantages to choose by, the first settings of
//! the search stay, unless they are plainly worse.

use crate::trial::{PairedDifference, ViewAccuracy};

/// The risk of taking any setting that gives up more than the bound.
const RISK: f64 = 0.05;

/// A measured setting.
#[derive(Clone, Copy, Debug)]
pub(super) struct CandidateSetting<'a> {
    pub(super) views: &'a [ViewAccuracy],
    /// Mean accuracy, dB.
    pub(super) psnr_filled_db: f64,
    /// The smaller the simpler.
    pub(super) cost: (u64, u64),
}

/// What may be given up.
#[derive(Clone, Copy, Debug)]
pub(super) struct LossRule {
    /// The bound, dB.
    pub(super) at_most_db: f64,
    /// Settings that are compared with the best, all in all.
    pub(super) comparisons: usize,
}

/// Why a setting was chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reason {
    /// It is the simplest that is good enough.
    Simplest,
    /// Nothing but the best is surely good enough, and the search began with it.
    CannotTell,
}

impl LossRule {
    /// Whether the setting surely gives up no more than the bound.
    pub(super) fn is_good_enough(&self, views: &[ViewAccuracy], best: &[ViewAccuracy]) -> bool {
        let risk = RISK / self.comparisons.max(1) as f64;
        PairedDifference::between(best, views)
            .is_some_and(|loss| loss.upper_bound_db(risk) <= self.at_most_db)
    }

    /// Whether the setting is not plainly worse: its loss and one standard error of it stay within the bound.
    fn may_stay(&self, views: &[ViewAccuracy], best: &[ViewAccuracy]) -> bool {
        PairedDifference::between(best, views)
            .is_some_and(|loss| loss.db.mean + loss.db.standard_error <= self.at_most_db)
    }

    /// The index of the chosen candidate, and why. The first candidate is the one that the search began with. `None` without candidates.
    pub(super) fn choose(&self, candidates: &[CandidateSetting<'_>]) -> Option<(usize, Reason)> {
        let best = most_accurate(candidates)?;
        let good = (0..candidates.len())
            .filter(|&nth| nth == best || self.is_good_enough(candidates[nth].views, candidates[best].views));
        let chosen = good.min_by_key(|&nth| candidates[nth].cost)?;
        if chosen == best && best != 0 && self.may_stay(candidates[0].views, candidates[best].views) {
            return Some((0, Reason::CannotTell));
        }
        Some((chosen, Reason::Simplest))
    }
}

/// The most accurate candidate; of equals the simplest, of these the first.
pub(super) fn most_accurate(candidates: &[CandidateSetting<'_>]) -> Option<usize> {
    (0..candidates.len()).rev().max_by(|&a, &b| {
        let (a, b) = (&candidates[a], &candidates[b]);
        a.psnr_filled_db.total_cmp(&b.psnr_filled_db).then(b.cost.cmp(&a.cost))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial::MeanEstimate;
    use overlook_engine::random::mix;

    /// Draws from the normal distribution (Box and Muller 1958).
    struct Normal(u64);

    impl Normal {
        fn uniform(&mut self) -> f64 {
            self.0 = mix(self.0);
            (self.0 >> 11) as f64 / (1_u64 << 53) as f64
        }

        fn draw(&mut self, sigma: f64) -> f64 {
            let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
            sigma * radius * (std::f64::consts::TAU * self.uniform()).cos()
        }
    }

    /// Losses of the settings against the best, dB; measured at some vantages, which differ by 1 dB from each other, and each setting at
    /// each vantage by a tenth of that again.
    struct Draw {
        losses_db: Vec<f64>,
        costs: Vec<(u64, u64)>,
        views: Vec<Vec<ViewAccuracy>>,
    }

    impl Draw {
        fn new(seed: u64, vantages: usize) -> Self {
            let mut normal = Normal(mix(seed));
            let losses_db: Vec<f64> =
                (0..12).map(|_| [0.0, 0.05, 0.2][(3.0 * normal.uniform()) as usize]).collect();
            let costs = losses_db.iter().map(|_| ((1e6 * normal.uniform()) as u64, 0)).collect();
            let of_vantage: Vec<f64> = (0..vantages).map(|_| normal.draw(1.0)).collect();
            let mut views_of = |loss: &f64| {
                let view = |(vantage, off): (usize, &f64)| ViewAccuracy {
                    file_path: vantage.to_string(),
                    vantage,
                    psnr_filled_db: 30.0 + off - loss + normal.draw(0.1),
                };
                of_vantage.iter().enumerate().map(view).collect()
            };
            let views = losses_db.iter().map(&mut views_of).collect();
            Self { losses_db, costs, views }
        }

        fn mean(&self, nth: usize) -> MeanEstimate {
            let accuracy: Vec<f64> = self.views[nth].iter().map(|view| view.psnr_filled_db).collect();
            MeanEstimate::of(&accuracy)
        }

        fn candidates(&self) -> Vec<CandidateSetting<'_>> {
            let candidate = |nth: usize| CandidateSetting {
                views: &self.views[nth],
                psnr_filled_db: self.mean(nth).mean,
                cost: self.costs[nth],
            };
            (0..self.views.len()).map(candidate).collect()
        }

        /// What the setting gives up of the best there is, dB.
        fn given_up_db(&self, nth: usize) -> f64 {
            self.losses_db[nth] - self.losses_db.iter().copied().fold(f64::INFINITY, f64::min)
        }

        /// The simplest within one standard error over vantages of the most accurate.
        fn by_unpaired_error(&self) -> usize {
            let candidates = self.candidates();
            let best = self.mean(most_accurate(&candidates).unwrap());
            let good = (0..candidates.len())
                .filter(|&nth| candidates[nth].psnr_filled_db >= best.mean - best.standard_error);
            good.min_by_key(|&nth| candidates[nth].cost).unwrap()
        }
    }

    #[test]
    fn of_a_thousand_draws_nineteen_in_twenty_give_up_no_more_than_the_bound() {
        const DRAWS: u64 = 1000;
        let rule = LossRule { at_most_db: 0.1, comparisons: 11 };
        let (mut paired, mut unpaired) = (0, 0);
        let (mut cost, mut cost_of_best) = (0, 0);
        for seed in 0..DRAWS {
            let draw = Draw::new(seed, 3 + (seed % 13) as usize);
            let candidates = draw.candidates();
            let (chosen, _) = rule.choose(&candidates).unwrap();
            paired += u32::from(draw.given_up_db(chosen) <= 0.1);
            unpaired += u32::from(draw.given_up_db(draw.by_unpaired_error()) <= 0.1);
            cost += draw.costs[chosen].0;
            cost_of_best += draw.costs[most_accurate(&candidates).unwrap()].0;
        }
        println!("within 0.1 dB: {paired} of {DRAWS} by differences, {unpaired} by the error over vantages");
        println!("cost: {:.2} of the most accurate", cost as f64 / cost_of_best as f64);
        assert!(f64::from(paired) >= 0.95 * DRAWS as f64, "{paired}");
        assert!(f64::from(unpaired) < 0.8 * DRAWS as f64, "{unpaired}");
        assert!(cost < cost_of_best, "nothing was saved: {cost} of {cost_of_best}");
    }

    #[test]
    fn settings_that_cannot_be_told_from_the_best_stay_as_they_were() {
        let view = |vantage: usize, psnr_filled_db: f64| ViewAccuracy {
            file_path: vantage.to_string(),
            vantage,
            psnr_filled_db,
        };
        let (start, simple) = ([view(0, 30.02), view(1, 31.0)], [view(0, 29.0), view(1, 31.9)]);
        let best = [view(0, 30.1), view(1, 31.0)];
        let of = |views, psnr_filled_db, cost| CandidateSetting { views, psnr_filled_db, cost: (cost, 0) };
        let candidates = [of(&start, 30.51, 2), of(&simple, 30.45, 1), of(&best, 30.55, 3)];
        let rule = LossRule { at_most_db: 0.1, comparisons: 2 };
        assert_eq!(rule.choose(&candidates), Some((0, Reason::CannotTell)));
        // A start that is plainly worse does not stay.
        let worse = [view(0, 29.0), view(1, 30.0)];
        let candidates = [of(&worse, 29.5, 2), candidates[1], candidates[2]];
        assert_eq!(rule.choose(&candidates), Some((2, Reason::Simplest)));
        assert_eq!(rule.choose(&[]), None);
    }
}
