//! One setting: preprocessed, stored, rendered, scored.

mod baselines;
mod budget;
mod compare;
mod machine_load;
mod paired;
mod rival_trial;
mod trial_result;
mod trial_setting;
mod workbench;

use std::sync::Arc;

use crate::metrics::ClassMap;
use crate::scoring::render_view;
pub use budget::{Fineness, Measured, levels};
pub(crate) use budget::{TimeLeft, coarse_to_fine};
pub use compare::{MethodComparison, MethodScore, compare, compare_each};
use overlook_engine::capture::Frame;
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::render::Picture;
use overlook_engine::settings::{Fill, RenderSettings};
pub use paired::{MeanEstimate, PairedDifference, ViewAccuracy};
pub use trial_result::TrialResult;
pub(crate) use trial_result::kernel_cost;
pub use trial_setting::{Thinning, Trial};
use workbench::ViewModel;
pub use workbench::Workbench;

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
