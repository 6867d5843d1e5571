//! Scores of views, and their means.

use serde::Serialize;

use crate::evaluate::metrics::Scores;
use crate::render::Painter;

/// What one view cost and, where its truth is known, how close to it the picture came.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ViewScore {
    /// The view's own name.
    pub file_path: String,
    /// Closeness to the truth; `None` where no pixel of it is known.
    #[serde(flatten)]
    pub scores: Option<Scores>,
    /// Wall-clock milliseconds of painting.
    pub milliseconds: f64,
    /// Samples that were projected.
    pub samples: u64,
    /// What painted.
    #[serde(flatten)]
    pub painter: Painter,
}

/// Means over views.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct MeanScore {
    /// See [`Scores::psnr_db`]; `None` where no view has truth.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub psnr_db: Option<f64>,
    /// See [`Scores::psnr_all_db`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub psnr_all_db: Option<f64>,
    /// See [`Scores::ssim`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ssim: Option<f64>,
    /// See [`Scores::ms_ssim`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ms_ssim: Option<f64>,
    /// See [`Scores::flip`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flip: Option<f64>,
    /// See [`Scores::silhouette_steps`]; over the views that have silhouettes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub silhouette_steps: Option<f64>,
    /// Root mean square change of error from frame to frame, 8-bit steps; `None` where no vantage is seen at two frames.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flicker_steps: Option<f64>,
    /// See [`Scores::coverage`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coverage: Option<f64>,
    /// See [`ViewScore::milliseconds`].
    pub milliseconds: f64,
    /// See [`ViewScore::samples`].
    pub samples: f64,
}

/// Scores of several views.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Evaluation {
    /// One by one, in the order of the views.
    pub views: Vec<ViewScore>,
    /// On average.
    pub mean: MeanScore,
    /// A notice if another renderer than requested was used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub notice: Option<String>,
}

impl Evaluation {
    /// The same with the views in their given order, where `order` is that in which they were rendered.
    pub(crate) fn given_back(self, order: &[usize]) -> Self {
        let mut views: Vec<(usize, ViewScore)> = order.iter().copied().zip(self.views).collect();
        views.sort_unstable_by_key(|(index, _)| *index);
        Self { views: views.into_iter().map(|(_, score)| score).collect(), ..self }
    }
}
