//! The dialog of all ways out of the window: what is chosen in it, and what came of it.

use std::path::PathBuf;
use std::sync::Arc;

use crate::app::model::picture::LivePicture;
use crate::app::model::purpose::FigureOf;
use crate::app::model::same::Same;
use crate::app::model::scene::OpenScene;
use crate::app::model::texture::Texture;
use crate::app::model::ways_out::{ShareOptions, SharedPictures};
use overlook_engine::render::Vantage;
use overlook_engine::samples::SampleSet;
use overlook_engine::settings::RenderSettings;

/// What came of the last thing that was asked for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ShareOutcome {
    /// It is written: what, and where.
    Written { said: String, path: PathBuf },
    /// Nothing was written, or not all; why.
    Failed(String),
}

/// The dialog.
#[derive(Default)]
pub(crate) struct ShareDialog {
    pub is_open: bool,
    pub options: ShareOptions,
    /// What the sizes follow from; `None` until it is measured.
    pub facts: Option<ShareFacts>,
    /// What the budget leaves: the request, the picture if there is one, and its PSNR against that of all samples, dB.
    pub preview: Option<ShownPreview>,
    /// Where what was asked for last is written, until it is.
    pub asked: Option<PathBuf>,
    pub outcome: Option<ShareOutcome>,
}

impl ShareDialog {
    /// Forgets what belongs to a scene.
    pub(crate) fn close_scene(&mut self) {
        let options = ShareOptions {
            title: String::new(),
            text: String::new(),
            pictures: SharedPictures::default(),
            figure_of: FigureOf::default(),
            ..std::mem::take(&mut self.options)
        };
        *self = Self { options, asked: self.asked.take(), ..Self::default() };
    }
}

/// What sizes are measured from.
#[derive(Clone, PartialEq)]
pub(crate) struct ShareKey {
    pub scene: Arc<OpenScene>,
    /// The samples of the whole capture; of a store the outline.
    pub samples: Same<SampleSet>,
    pub frame: usize,
    /// The picture of the live view, where it is in memory.
    pub picture: Option<Same<LivePicture>>,
}

/// What a preview is of.
#[derive(Clone, PartialEq)]
pub(crate) struct SharePreviewKey {
    pub scene: Arc<OpenScene>,
    /// As in [`ShareKey`].
    pub samples: Same<SampleSet>,
    pub vantage: Vantage,
    pub settings: RenderSettings,
    /// The samples that the budget leaves, as a share of all.
    pub share: f64,
}

/// A picture of what a budget leaves.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SharePreview {
    pub image: Arc<egui::ColorImage>,
    /// PSNR beside the picture of all samples, dB.
    pub decibels: Option<f64>,
}

/// A preview as the dialog shows it.
pub(crate) struct ShownPreview {
    pub key: SharePreviewKey,
    /// Its texture and decibels; `None` where the budget leaves nothing.
    pub picture: Option<(Texture, Option<f64>)>,
}

/// What was measured of the open scene, for sizes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ShareFacts {
    /// Kept samples.
    pub samples: u64,
    /// Those with a place that are shown at the frame, and those at infinity.
    pub placed_here: u64,
    pub at_infinity_here: u64,
    /// Bytes of the store: of an open one as it is, else by writing all samples or those of some cameras.
    pub store_bytes: f64,
    /// Bytes of a pixel of the live view's picture as PNG and as EXR; `None` while none is in memory.
    pub picture: Option<PictureFacts>,
}

/// What the picture of the live view takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PictureFacts {
    pub pixels: f64,
    pub png_bytes: f64,
    pub exr_bytes: f64,
}
