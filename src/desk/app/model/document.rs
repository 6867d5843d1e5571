//! What is open, and what is known of it.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Instant;

use egui::TextureHandle;

use crate::app::model::results::{Accuracy, CameraMemory, Inspected, Whole};
use crate::app::model::scene::OpenScene;
use crate::app::model::texture::Texture;
use crate::app::rooms::charts::model::charts::Charts;
use crate::app::rooms::colors::model::value_look::FrameValues;
use crate::app::rooms::compare::model::comparison::ShownComparison;
use crate::app::rooms::edits::model::edits::SceneEdits;
use crate::app::rooms::files::model::picture_folder::PictureFolder;
use crate::app::rooms::live::model::kept_views::{KeptView, ViewPictures};
use crate::app::rooms::live::model::motion_budget::ViewMotion;
use crate::app::rooms::live::model::picture::{LiveKey, LivePicture, ShownCarried};
use crate::app::rooms::live::model::view_history::ViewHistory;
use crate::app::rooms::path::model::CameraPath;
use crate::app::rooms::pixel::model::pixel::InspectedPixel;
use crate::app::rooms::readings::model::readings::ReadingCheck;
use crate::app::rooms::settings::model::histogram::ThresholdHistogram;
use crate::app::rooms::source::model::picture::{SourceKey, SourcePicture};
use overlook_engine::plural;
use overlook_engine::preprocess::PreparedScan;
use overlook_engine::settings::Settings;

/// A picture that is shown, and what it was made from.
pub(crate) struct ShownPicture<K, P> {
    /// What it was made from.
    pub key: K,
    pub picture: Arc<P>,
    /// The picture on the graphics card.
    pub texture: Texture,
}

/// What is open, and what is known of it. It ends with the scene: a new scene replaces it whole.
#[derive(Default)]
pub(crate) struct Document {
    pub scene: Option<Arc<OpenScene>>,
    /// The pass over all frames of the open capture.
    pub scan: Option<Arc<PreparedScan>>,
    /// The whole capture, pruned; perhaps by older settings.
    pub whole: Option<Whole>,
    /// Seconds that reading all frames took; `None` before they were read.
    pub read_seconds: Option<f64>,
    /// Whether the whole-capture work was stopped, by the person or as something could not be read.
    pub stopped: bool,
    /// The frame whose inspection failed last.
    pub failed_frame: Option<usize>,
    /// The frame last pruned with reasons.
    pub inspected: Option<Inspected>,
    /// When a setting was last changed that decides which samples stay; `None` where nothing waits for it to rest.
    pub changed_at: Option<Instant>,
    pub accuracy: Option<Accuracy>,
    pub source_shown: Option<ShownPicture<SourceKey, SourcePicture>>,
    /// How the live view moves.
    pub motion: ViewMotion,
    /// The live picture that was painted last.
    pub live_shown: Option<ShownPicture<LiveKey, LivePicture>>,
    /// That picture carried to where the view is now, until a new one is painted.
    pub live_carried: Option<ShownCarried>,
    pub edits: SceneEdits,
    pub probe: InspectedPixel,
    /// Every camera small, in the capture's order; empty before the first.
    pub thumbs: Vec<TextureHandle>,
    /// What takes the memory, largest first; `None` before it was asked for.
    pub memory: Option<Vec<CameraMemory>>,
    /// The camera whose name in a legend is under the pointer.
    pub isolated: Option<usize>,
    /// The values that the live view showed in colors when it rested last; `None` before the panel of colors asked for them.
    pub values: Option<FrameValues>,
    /// The quantities that thresholds cut; empty before the first.
    pub histograms: Vec<ThresholdHistogram>,
    pub compared: Option<ShownComparison>,
    /// Why there is none.
    pub compare_error: Option<String>,
    /// Pictures of other programs, to be compared with; of the open scene.
    pub pictures: Vec<PictureFolder>,
    pub path: CameraPath,
    /// How the capture is read, and how it would fit better.
    pub readings: ReadingCheck,
    pub charts: Charts,
    /// Views that were left by a jump.
    pub views: ViewHistory,
    /// Views that are kept.
    pub kept_views: Vec<KeptView>,
    /// Small pictures of views.
    pub view_pictures: ViewPictures,
    /// The settings of the store that was saved last of the open capture, at first those that it was opened with.
    pub saved: Option<Settings>,
    /// The reported parts of the open store that could not be read.
    pub reported_damage: BTreeSet<String>,
}

impl Document {
    /// What is known of a scene that was just opened with `settings`.
    pub(crate) fn of(scene: Arc<OpenScene>, settings: &Settings) -> Self {
        let saved = scene.capture().map(|_| settings.clone());
        Self { scene: Some(scene), saved, ..Self::default() }
    }

    /// Work that is in no file and ends with the scene, in words; `None` without any.
    pub(crate) fn unsaved_work(&self) -> Option<String> {
        let counted = |count: usize, of: &str| (count > 0).then(|| plural::counted(count, of));
        let charts = &self.charts;
        let parts = [
            counted(if self.path.is_saved() { 0 } else { self.path.keys.len() }, "key")
                .map(|keys| format!("the camera path ({keys})")),
            counted(charts.sweep.len(), "point").map(|points| format!("the sweep ({points})")),
            counted(charts.stress.len(), "point").map(|points| format!("the stress test ({points})")),
            charts.studying.then(|| "what is being measured".to_owned()),
        ];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        (!parts.is_empty()).then(|| parts.join(", "))
    }
}
