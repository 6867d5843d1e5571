//! One setting: preprocessed, stored, rendered, scored.

mod baselines;
mod budget;
mod compare;
mod paired;
mod rival_trial;
mod workbench;

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::metrics::{ClassErrors, ClassMap, Scores};
use crate::rivals::Rival;
use crate::scoring::{Evaluation, ViewScore, render_view};
pub use budget::{Fineness, Measured, levels};
pub(crate) use budget::{TimeLeft, coarse_to_fine};
pub use compare::{MethodComparison, MethodScore, compare, compare_each};
use overlook_engine::capture::{Frame, TruthView};
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::render::Picture;
use overlook_engine::settings::{CaptureSettings, Fill, Kernel, RenderSettings, Settings};
pub use paired::{MeanEstimate, PairedDifference, ViewAccuracy};
use workbench::ViewModel;
pub use workbench::Workbench;

/// What is done to the samples after pruning.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Thinning {
    /// Nothing.
    None,
    /// As many as the reference keeps, chosen at random.
    Random,
    /// As many as the reference keeps, one for each cube of a grid.
    VoxelGrid,
    /// Tolerances are lowered until at least as many stay as the reference keeps; of these, as many at random.
    Tolerance,
}

/// A setting to measure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// A short name of what is special about it.
    pub label: String,
    /// Everything that can be set.
    pub settings: Settings,
    /// What is done after pruning.
    pub thinning: Thinning,
    /// Names of the cameras that a model is made of; `None` for all.
    pub cameras: Option<Vec<String>>,
    /// A method of others that is measured instead; of the settings, it uses only the filling of holes.
    pub rival: Option<Rival>,
}

impl Trial {
    /// Settings as they are, on all cameras.
    #[must_use]
    pub fn new(label: impl Into<String>, settings: Settings) -> Self {
        Self { label: label.into(), settings, thinning: Thinning::None, cameras: None, rival: None }
    }

    /// What the trial's samples depend on: all but the painting.
    fn model_key(&self) -> ModelKey {
        let settings = Settings {
            render: RenderSettings::default(),
            capture: CaptureSettings::default(),
            ..self.settings.clone()
        };
        (settings, self.thinning, self.cameras.clone())
    }
}

/// See [`Trial::model_key`].
type ModelKey = (Settings, Thinning, Option<Vec<String>>);

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
fn scores_by_vantage(views: &[TruthView], evaluation: &Evaluation) -> Vec<Vec<(String, Scores)>> {
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

/// What a trial shows at one view.
pub struct ShownView {
    /// The view's own name.
    pub file_path: String,
    /// Holes filled.
    pub picture: Arc<Picture>,
    /// Masked to what the cameras saw.
    pub truth: Frame,
    /// Classes of its error.
    pub classes: Option<Arc<ClassMap>>,
    /// Over all pixels that some camera saw.
    pub psnr_filled_db: f64,
}

impl Workbench {
    /// Renders a trial of ours at the view of this name; `None` if no view has it.
    ///
    /// # Errors
    /// As [`Workbench::measure`].
    pub(crate) fn show(&mut self, trial: &Trial, file_path: &str, job: &Job) -> Result<Option<ShownView>> {
        let Some(found) = self.view_and_samples(trial, file_path, job)? else { return Ok(None) };
        let ViewModel { view, classes, samples } = found;
        let Some(truth) = view.truth.as_ref().map(|load| load()).transpose()? else { return Ok(None) };
        let filling = RenderSettings { fill: Fill::PushPull, ..trial.settings.render.clone() };
        let renderer = self.renderer(filling.backend)?;
        let painted = render_view(renderer, &samples, &view, classes.as_deref(), &filling, job)?;
        let psnr_filled_db = painted.score.scores.map_or(f64::NAN, |scores| scores.psnr_all_db);
        Ok(Some(ShownView {
            file_path: view.file_path,
            picture: painted.picture,
            truth,
            classes,
            psnr_filled_db,
        }))
    }
}
