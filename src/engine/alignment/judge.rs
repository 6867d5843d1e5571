//! Whether a correction pays: judged by samples that took no part in finding it.

use glam::DAffine3;

use super::solver::{Problem, Weighing, loss};

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
    /// Whether pictures alone agree better by as much; true where nothing else judged.
    pub(crate) pictures_pay: bool,
}

/// A correction pays where the loss falls by more than this many standard errors, and by this share.
const STANDARD_ERRORS: f64 = 2.0;
const LEAST_FALL: f64 = 0.01;
/// Fewer samples judge nothing.
const LEAST_SAMPLES: usize = 50;

impl Judgment {
    pub(crate) fn pays(&self) -> bool {
        let fall = self.before - self.after;
        self.pictures_pay
            && self.samples >= LEAST_SAMPLES
            && fall > STANDARD_ERRORS * self.standard_error
            && fall > LEAST_FALL * self.before
    }

    /// Of losses without and with a correction, one pair for each independent sample.
    pub(crate) fn of(losses: &[[f64; 2]]) -> Self {
        let apart: Vec<(usize, [f64; 2])> = losses.iter().copied().enumerate().collect();
        Self::of_regions(&apart, losses.len())
    }

    /// The same of samples that lie in so many regions, each with the number of its own: those of one region are not independent.
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
        Self { before, after, standard_error, samples: losses.len(), pictures_pay: true }
    }

    /// Of one camera's pose beside `then`, all others being corrected.
    pub(crate) fn of_pose(problem: &Problem, weighing: &Weighing, camera: usize, then: DAffine3) -> Self {
        let mut uncorrected = problem.views[camera].clone();
        uncorrected.camera.world_from_camera = then;
        let (mut losses, mut pictures) = (Vec::new(), Vec::new());
        let pairs = problem.pairs.iter().zip(&weighing.pairs);
        for (pair, weighed) in pairs.filter(|(pair, _)| pair.contains(&camera)) {
            let now = problem.pair(*pair);
            let views = pair.map(|index| if index == camera { &uncorrected } else { &problem.views[index] });
            let gains = pair.map(|index| problem.log_gains[index]);
            let before = super::residuals::PairOfViews::new(views, gains, problem.scale, problem.color_alone);
            for sample in problem.samples[pair[0]].iter().filter(|sample| sample.judges) {
                // A sample that no camera sees either way does not count.
                let [before, after] = [&before, &now].map(|views| {
                    let terms = views.terms(sample, weighing.level, f64::INFINITY);
                    terms.map_or([None; 2], |terms| [terms.distance, terms.color])
                });
                // What is not seen either way does not count.
                let [distance, color] = [0, 1].map(|kind| {
                    let terms = [before[kind]?, after[kind]?];
                    Some(terms.map(|term| loss(term.residual, weighed.sigmas[kind])))
                });
                pictures.extend(color.map(|loss| (sample.region, loss)));
                let both = distance.into_iter().chain(color);
                let sum = both.reduce(|a, b| [a[0] + b[0], a[1] + b[1]]);
                losses.extend(sum.map(|loss| (sample.region, loss)));
            }
        }
        // Distances alone may agree better for the bias of planes through curved or noisy surfaces.
        let pictures_pay = Self::of_regions(&pictures, problem.regions).pays();
        Self { pictures_pay, ..Self::of_regions(&losses, problem.regions) }
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
