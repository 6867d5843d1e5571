//! Pictures that another program made of the same views, scored as ours are.

use std::collections::HashMap;
use std::sync::Arc;

use serde::Serialize;

use super::scoreboard::{Scoreboard, vantage_order, with_truth};
use super::view::{PaintedView, ViewCost, ViewScore, scored};
use crate::metrics::{ClassMap, ErrorByClass, Scores};
use overlook_engine::capture::transforms::{MatchedBy, OtherPictures};
use overlook_engine::capture::{Frame, TruthView};
use overlook_engine::error::{Error, Result};
use overlook_engine::grid::Grid;
use overlook_engine::job::Job;
use overlook_engine::render::{NO_IMAGE, Painter, Picture, RenderStats};

/// Scores of another program's pictures; what they cost is not known.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PictureScores {
    /// Name of the program, or of its folder.
    pub name: String,
    /// How the pictures were found to be those of the views.
    pub matched_by: MatchedBy,
    /// One by one, in the order of the views.
    pub views: Vec<PictureScore>,
    /// Mean of [`Scores::psnr_db`] over the views.
    pub psnr_db: Option<f64>,
    /// Mean of [`Scores::psnr_all_db`] over the views.
    pub psnr_all_db: Option<f64>,
    /// Mean of [`Scores::ssim`] over the views.
    pub ssim: Option<f64>,
    /// Mean of [`Scores::flip`] over the views.
    pub flip: Option<f64>,
    /// Mean of [`Scores::coverage`] over the views.
    pub coverage: Option<f64>,
    /// Root mean square change of error from frame to frame, 8-bit steps; `None` where no vantage is seen at two frames.
    pub flicker_steps: Option<f64>,
    /// Error by class, over all pixels of all views together.
    pub error_by_class: Option<ErrorByClass>,
}

/// Scores of one picture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PictureScore {
    /// The view's own name.
    pub file_path: String,
    /// Closeness to the truth; `None` where no pixel of it is known.
    #[serde(flatten)]
    pub scores: Option<Scores>,
    /// Error by class.
    pub error_by_class: Option<ErrorByClass>,
}

/// Scores the pictures of another program. Each view with known truth must have one; `on_picture` receives each.
///
/// # Errors
/// `Invalid` naming the first view without a picture; those of reading pictures; `Cancelled`.
pub fn score_pictures(
    name: &str,
    other: &OtherPictures,
    views: &[TruthView],
    classes: &[Option<Arc<ClassMap>>],
    job: &Job,
    mut on_picture: impl FnMut(&TruthView, &Picture, Option<&ClassMap>) -> Result<()>,
) -> Result<PictureScores> {
    let pictures = other.all()?;
    let places: HashMap<&str, usize> =
        views.iter().enumerate().map(|(index, view)| (view.file_path.as_str(), index)).collect();
    let known = with_truth(views, job);
    let order = vantage_order(&known);
    job.start(format!("Scoring the pictures of {name}"), order.len());
    let mut scores = Scoreboard::default();
    for &index in &order {
        job.check()?;
        let view = known[index];
        let place = places[view.file_path.as_str()];
        let load = pictures.get(place).ok_or_else(|| Error::invalid(&view.file_path, "has no picture"))?;
        let picture = Arc::new(picture_of_frame(&load()?));
        let classes = classes.get(place).and_then(Option::as_deref);
        let cost = ViewCost { stats: RenderStats::default(), painter: Painter::cpu(), notice: None };
        let painted: PaintedView = scored(view, picture.clone(), classes, cost, job)?;
        on_picture(view, &picture, classes)?;
        scores.add(view, painted);
        job.advance(1);
    }
    let evaluation = scores.finish().in_order_of_views(&order);
    let of_view = |view: ViewScore| PictureScore {
        file_path: view.file_path,
        scores: view.scores,
        error_by_class: view.error_by_class,
    };
    let mean = evaluation.mean;
    Ok(PictureScores {
        name: name.to_owned(),
        matched_by: other.matched_by,
        views: evaluation.views.into_iter().map(of_view).collect(),
        psnr_db: mean.psnr_db,
        psnr_all_db: mean.psnr_all_db,
        ssim: mean.ssim,
        flip: mean.flip,
        coverage: mean.coverage,
        flicker_steps: mean.flicker_steps,
        error_by_class: mean.error_by_class,
    })
}

/// A frame that another program rendered, as one of our pictures: a pixel without depth is a hole.
#[must_use]
pub fn picture_of_frame(frame: &Frame) -> Picture {
    let (width, height) = frame.size();
    let image = frame.inverse_depth.map(|inverse_depth| if *inverse_depth >= 0.0 { 0 } else { NO_IMAGE });
    let color: Grid<[f32; 3]> = frame.color.map(|color| color.map(half::f16::to_f32));
    Picture { color, inverse_depth: frame.inverse_depth.clone(), image, ..Picture::empty(width, height) }
}
