//! The dialog of all ways out of the window: what is chosen in it, and what came of it.

use std::path::PathBuf;
use std::sync::Arc;

use crate::app::model::picture::LivePicture;
use crate::app::model::same::Same;
use crate::app::model::scene::OpenScene;
use crate::app::model::texture::Texture;
use crate::ways_out::figure::FigureOf;
use crate::ways_out::{Facts, Options};
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

/// What came of an export.
pub(crate) struct Exported {
    /// What was written, in words.
    pub said: String,
    /// Why the renderer of the settings did not paint.
    pub notice: Option<String>,
    /// What could not be read of a store so far, one line each.
    pub damage: Vec<String>,
}

/// The dialog.
#[derive(Default)]
pub(crate) struct ShareDialog {
    pub is_open: bool,
    pub options: Options,
    /// What the sizes follow from; `None` until it is measured.
    pub facts: Option<Facts>,
    /// What the budget leaves.
    pub preview: Option<ShownPreview>,
    /// Where what was asked for last is written, until it is.
    pub asked: Option<PathBuf>,
    pub outcome: Option<ShareOutcome>,
}

impl ShareDialog {
    /// Forgets what belongs to a scene.
    pub(crate) fn close_scene(&mut self) {
        let options = Options {
            title: String::new(),
            text: String::new(),
            along_path: false,
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
    /// What edits left, else the samples of the whole capture; of a store the outline.
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

/// A preview as the dialog shows it.
pub(crate) struct ShownPreview {
    pub key: SharePreviewKey,
    /// Its texture, and its PSNR beside the picture of all samples, dB; `None` where the budget leaves nothing.
    pub picture: Option<(Texture, Option<f64>)>,
}
