//! Whether a correction pays: judged by samples that took no part in finding it.

use glam::{DAffine3, DQuat};
use rayon::prelude::*;

use super::color_lens::UNKNOWNS;
use super::solver::{PairWeighing, Problem, Weighing, loss};

/// The loss of samples that took no part, without and with a correction.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Judgment {
    /// Mean loss without and with the correction: 0 where cameras agree, 1 where they have nothing in common.
    pub(crate) before: f64,
    pub(crate) after: f64,
    /// Standard error of the difference, over samples or the regions that they lie in.
    pub(crate) standard_error: f64,
    /// Samples that judged.
    pub(crate) samples: usize,
}

/// A correction pays where the loss falls by more than this many standard errors, and by this share.
const STANDARD_ERRORS: f64 = 2.0;
const LEAST_FALL: f64 = 0.01;
/// Beyond doubt is what makes the loss fall by more than this many, and by half.
const STANDARD_ERRORS_BEYOND_DOUBT: f64 = 5.0;
/// Standard errors for poses: noisy and curved surfaces ask for more false corrections of them than of anything else.
const STANDARD_ERRORS_OF_POSES: f64 = 2.5;
/// From this many on it may well pay, and is not given up.
const STANDARD_ERRORS_OF_DOUBT: f64 = 1.5;
/// Fewer samples judge nothing.
const LEAST_SAMPLES: usize = 50;

impl Judgment {
    pub(crate) fn pays(&self) -> bool {
        self.pays_by(STANDARD_ERRORS)
    }

    /// Whether it pays so much that nothing else explains it.
    pub(crate) fn is_beyond_doubt(&self) -> bool {
        self.pays_by(STANDARD_ERRORS_BEYOND_DOUBT) && self.after < 0.5 * self.before
    }

    fn pays_by(&self, standard_errors: f64) -> bool {
        let fall = self.before - self.after;
        self.samples >= LEAST_SAMPLES
            && fall > standard_errors * self.standard_error
            && fall > LEAST_FALL * self.before
    }

    /// Compares losses without and with a correction, one pair for each independent sample.
    pub(crate) fn of(losses: &[[f64; 2]]) -> Self {
        let apart: Vec<(usize, [f64; 2])> = losses.iter().copied().enumerate().collect();
        Self::of_regions(&apart, losses.len())
    }

    /// Compares samples in `regions`, each with the number of its region: samples of one region are not independent.
    pub(crate) fn of_regions(losses: &[(usize, [f64; 2])], regions: usize) -> Self {
        let n = losses.len().max(1) as f64;
        let [before, after] = [0, 1].map(|which| losses.iter().map(|(_, loss)| loss[which]).sum::<f64>() / n);
        let fall = before - after;
        let mut away = vec![None; regions];
        for (region, loss) in losses {
            *away[*region].get_or_insert(0.0) += loss[0] - loss[1] - fall;
        }
        let count = away.iter().flatten().count() as f64;
        let square: f64 = away.iter().flatten().map(|away: &f64| away * away).sum();
        let standard_error = (square * count / (count - 1.0).max(1.0)).sqrt() / n;
        Self { before, after, standard_error, samples: losses.len() }
    }

    fn reversed(self) -> Self {
        Self { before: self.after, after: self.before, ..self }
    }
}

/// The region of each sample, and its loss before and after.
type Losses = Vec<(usize, [f64; 2])>;

/// The loss of samples that took no part, with other poses and with the poses found.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PoseJudgment {
    /// By distances and pictures together.
    pub(crate) all: Judgment,
    pub(crate) distances: Judgment,
}

impl PoseJudgment {
    /// Compares the poses with `then`, one for each camera, by the pairs that count.
    pub(crate) fn new(
        problem: &Problem,
        weighing: &Weighing,
        then: &[DAffine3],
        counts: impl Fn(&[usize; 2]) -> bool + Sync,
    ) -> Self {
        let of_pair = |(pair, weighed): (&[usize; 2], &PairWeighing)| {
            let (mut all, mut distances) = (Vec::new(), Vec::new());
            let views = [problem.pair_at(*pair, pair.map(|camera| then[camera])), problem.pair(*pair)];
            for sample in problem.samples[pair[0]].iter().filter(|sample| sample.judges) {
                let terms = views.each_ref().map(|views| {
                    let terms = views.terms(sample, weighing.level, f64::INFINITY);
                    terms.map_or([None; 2], |terms| [terms.distance, terms.color])
                });
                // What is not seen either way does not count.
                let [distance, color] = [0, 1].map(|kind| {
                    let of_kind = [terms[0][kind]?, terms[1][kind]?];
                    Some(of_kind.map(|term| loss(term.residual, weighed.sigmas[kind])))
                });
                distances.extend(distance.map(|loss| (sample.region, loss)));
                let sum = distance.into_iter().chain(color).reduce(|a, b| [a[0] + b[0], a[1] + b[1]]);
                all.extend(sum.map(|loss| (sample.region, loss)));
            }
            (all, distances)
        };
        let pairs = problem.pairs.par_iter().zip(&weighing.pairs).filter(|(pair, _)| counts(pair));
        let (all, distances): (Vec<Losses>, Vec<Losses>) = pairs.map(of_pair).unzip();
        let [all, distances] = [all.concat(), distances.concat()];
        let [all, distances] = [all, distances].map(|losses| Judgment::of_regions(&losses, problem.regions));
        Self { all, distances }
    }

    /// Whether cameras agree better, about where surfaces are as well: where pictures alone do, something other than poses is wrong.
    /// Cameras without depth are judged by pictures alone.
    pub(crate) fn pays(&self) -> bool {
        self.pays_by([STANDARD_ERRORS_OF_POSES; 2])
    }

    /// Whether one camera of a rig pays whose poses pay together: fewer samples judge it.
    pub(crate) fn pays_for_one(&self) -> bool {
        self.pays_by([STANDARD_ERRORS_OF_POSES, STANDARD_ERRORS_OF_DOUBT])
    }

    /// Whether cameras may agree better.
    pub(crate) fn may_pay(&self) -> bool {
        self.all.pays_by(STANDARD_ERRORS_OF_DOUBT)
    }

    /// By standard errors of all, and of distances.
    fn pays_by(&self, [all, distances]: [f64; 2]) -> bool {
        self.all.pays_by(all) && (self.distances.samples < LEAST_SAMPLES || self.distances.pays_by(distances))
    }

    /// The other poses beside these.
    pub(crate) fn reversed(self) -> Self {
        Self { all: self.all.reversed(), distances: self.distances.reversed() }
    }
}

impl Problem {
    /// Terms that one sample has on average: they are not independent.
    pub(crate) fn terms_per_sample(&self, weighing: &Weighing) -> f64 {
        let mut terms = 0;
        for (pair, weighed) in self.pairs.iter().zip(&weighing.pairs) {
            let views = self.pair(*pair);
            let of_pair = self.samples[pair[0]].iter().step_by(8);
            terms +=
                of_pair.filter(|sample| views.terms(sample, weighing.level, weighed.gate).is_some()).count();
        }
        let samples: usize = self.samples.iter().map(|samples| samples.len().div_ceil(8)).sum();
        (terms as f64 / samples.max(1) as f64).max(1.0)
    }
}

/// The poses of rigs are off by no more: radians, and typical depths. What is farther off is misread.
const MOST_TURN: f64 = 0.15;
const MOST_SHIFT: f64 = 0.15;

/// Two sensors of one device differ by less: the unknowns of a color lens, in their order.
const MOST: [f64; UNKNOWNS] = [0.18, 0.15, 0.15, 0.15, 0.12, 0.12, 0.12, 0.1, 0.1];

/// Whether the pose of a rig may be off by this change; `inverse_depth` is of a typical depth.
pub(super) fn is_of_a_rig(change: &DAffine3, inverse_depth: f64) -> bool {
    let turn = DQuat::from_mat3(&change.matrix3).to_scaled_axis().length();
    turn < MOST_TURN && change.translation.length() * inverse_depth < MOST_SHIFT
}

/// Whether two sensors of one device may differ by these unknowns of a color lens.
pub(super) fn is_of_one_device(unknowns: &[f64; UNKNOWNS]) -> bool {
    unknowns.iter().zip(MOST).all(|(value, most)| value.abs() < most)
}
