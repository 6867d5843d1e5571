//! Accuracy of models of fewer views: measured at the given truth, or at some of the views that were not chosen.

use crate::trial::{MeanEstimate, Trial, Workbench};
use crate::truth::{self, Fold, Truth};
use overlook_engine::capture::{Capture, TruthView};
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::settings::Settings;

/// Most views that are held out as truth.
const LEFT_OUT: usize = 8;

/// Accuracy and size of a model of some of the views.
#[derive(Clone, Copy, Debug)]
pub(super) struct SubsetResult {
    /// PSNR over pixels that some view saw, holes filled, dB.
    pub(super) psnr_filled_db: MeanEstimate,
    pub(super) samples: u64,
    pub(super) bytes: u64,
}

/// The capture and the truth that subsets of its views are measured on.
pub(super) struct AccuracyTest {
    fold: Fold,
    settings: Settings,
    /// Names of the views that are held out as truth.
    pub(super) left_out: Vec<String>,
}

impl AccuracyTest {
    /// Loads the truth: the given views, or else some of the views that were not `chosen`. `None` if no view has a known pixel.
    /// `capture` must be corrected already.
    pub(super) fn new(
        capture: &Capture,
        truth: &Truth,
        chosen: &[usize],
        settings: &Settings,
        job: &Job,
    ) -> Result<Option<Self>> {
        let (rest, views, left_out) = match truth {
            Truth::Views(views) => (capture.clone(), views.clone(), Vec::new()),
            Truth::HoldOut => {
                let others: Vec<usize> =
                    (0..capture.cameras.len()).filter(|view| !chosen.contains(view)).collect();
                let name = |nth: usize| capture.cameras[others[nth]].name.clone();
                let left_out: Vec<String> = truth::evenly_spaced(others.len(), LEFT_OUT).map(name).collect();
                let (rest, views) = truth::split(capture, &left_out)?;
                (rest, views, left_out)
            }
        };
        job.start("Loading the truth", views.len());
        let views: Vec<TruthView> = truth::masked_one_by_one(&rest, views, job)?;
        let fold = Fold { held_out: None, capture: rest, classes: vec![None; views.len()], views };
        let is_any = !fold.views.is_empty();
        Ok(is_any.then(|| Self { fold, settings: settings.clone(), left_out }))
    }

    /// Number of views that a model may be made of.
    pub(super) fn views(&self) -> usize {
        self.fold.capture.cameras.len()
    }

    /// Measures a model of the named views; without names, of all views that are not held out.
    pub(super) fn of(&self, names: Option<Vec<String>>, job: &Job) -> Result<SubsetResult> {
        let trial = Trial { cameras: names, ..Trial::new("fewer views", self.settings.clone()) };
        // Each subset is a capture of its own: nothing of the one before can be used again.
        let result = Workbench::on(vec![self.fold.clone()], &self.settings).measure(&trial, job)?;
        let of_vantage = |views: &Vec<(String, crate::metrics::Scores)>| {
            views.iter().map(|(_, scores)| scores.psnr_all_db).collect()
        };
        let vantages: Vec<Vec<f64>> = result.vantages.iter().map(of_vantage).collect();
        Ok(SubsetResult {
            psnr_filled_db: MeanEstimate::over_vantages(&vantages),
            samples: result.samples,
            bytes: result.bytes,
        })
    }
}
