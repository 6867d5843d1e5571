//! What a trial gave.

use super::paired::ViewAccuracy;
use crate::metrics::{ClassErrors, Scores};
use crate::scoring::{Evaluation, ViewScore};
use overlook_engine::capture::TruthView;
use overlook_engine::settings::Kernel;

/// What a trial gave; means over folds, with the units of [`Point`](crate::sweep::Point).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrialResult {
    /// Names and scores of the views of every vantage of every fold, frame by frame.
    pub(crate) vantages: Vec<Vec<(String, Scores)>>,
    /// Over all pixels of all views together.
    pub(crate) class_errors: ClassErrors,
    /// `None` if no vantage is seen at two frames.
    pub(crate) flicker_steps: Option<f64>,
    pub(crate) samples: u64,
    pub(crate) bytes: u64,
    pub(crate) bytes_record: u64,
    pub(crate) bytes_memory: u64,
    pub(crate) samples_shared: u64,
    pub(crate) spans: u64,
    /// Median over all views.
    pub(crate) milliseconds: f64,
    pub(crate) load_of_others: Option<f64>,
    /// Mean number of samples that are projected for a view.
    pub(crate) samples_painted: f64,
    /// With the scan.
    pub(crate) seconds_preprocess: f64,
}

impl TrialResult {
    /// Accuracy view by view, vantage after vantage.
    pub(crate) fn accuracy_by_view(&self) -> Vec<ViewAccuracy> {
        let vantages = self.vantages.iter().enumerate();
        let views = vantages.flat_map(|(vantage, views)| {
            views.iter().map(move |(name, scores)| ViewAccuracy {
                file_path: name.clone(),
                vantage,
                psnr_filled_db: scores.psnr_all_db,
            })
        });
        views.collect()
    }
}

/// Names and scores of the views of each vantage, which follow each other.
pub(super) fn scores_by_vantage(views: &[TruthView], evaluation: &Evaluation) -> Vec<Vec<(String, Scores)>> {
    let scored: Vec<_> = views.iter().zip(&evaluation.views).collect();
    let vantages = scored.chunk_by(|(before, _), (after, _)| before.camera == after.camera);
    let scored = |(view, score): &(&TruthView, &ViewScore)| Some((view.file_path.clone(), score.scores?));
    vantages.map(|vantage| vantage.iter().filter_map(scored).collect()).collect()
}

/// Work of a kernel per sample, the same on every machine: ranks of measured times.
pub(crate) fn kernel_cost(kernel: Kernel) -> f64 {
    match kernel {
        Kernel::Point => 1.0,
        Kernel::Block => 4.0,
        Kernel::Surfel => 6.0,
        Kernel::Gather => 7.0,
    }
}
