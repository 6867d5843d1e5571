//! The inspector: what the window knows beyond its two pictures.

use std::collections::{BTreeSet, VecDeque};
use std::sync::Arc;
use std::time::Instant;

use egui::TextureHandle;

use crate::app::model::command::{CommandPalette, HelpPage};
use crate::app::model::frame_timer::Meter;
use crate::app::model::results::CameraMemory;
use crate::app::rooms::charts::model::charts::Charts;
use crate::app::rooms::compare::model::comparison::{CompareLook, CompareSide, ShownComparison};
use crate::app::rooms::compare::model::vantage::CompareVantage;
use crate::app::rooms::files::model::picture_folder::PictureFolder;
use crate::app::rooms::frame::model::notice::{LogLine, NoticeKind};
use crate::app::rooms::live::model::view_history::ViewHistory;
use crate::app::rooms::path::model::CameraPath;
use crate::app::rooms::pixel::model::pixel::{Probed, Spot};
use crate::app::rooms::readings::model::readings::ReadingCheck;
use crate::app::rooms::settings::model::histogram::ThresholdHistogram;
use crate::app::rooms::settings::model::presets::OwnPreset;
use crate::app::rooms::settings::model::undo::History;
use overlook_engine::plural;
use overlook_engine::settings::Settings;

/// Entries the log keeps.
const LOG: usize = 500;

/// The selected pixel.
#[derive(Default)]
pub(crate) struct InspectedPixel {
    /// Where somebody points.
    pub spot: Option<Spot>,
    /// Whether it stays when the pointer goes.
    pub pinned: bool,
    pub shown: Option<Arc<Probed>>,
}

/// What stands between the person and closing the window.
#[derive(Clone, Copy, Default)]
pub(crate) struct Closing {
    /// Whether the question before closing is open.
    pub asks: bool,
    /// Whether the window closes without another question.
    pub anyway: bool,
    /// Whether a file, pictures or a video are being written.
    pub writing: bool,
}

/// What the inspector knows.
#[derive(Default)]
pub(crate) struct Inspector {
    pub probe: InspectedPixel,
    /// Every camera small, in the capture's order; empty before the first.
    pub thumbs: Vec<TextureHandle>,
    /// What takes the memory, largest first; `None` before it was asked for.
    pub memory: Option<Vec<CameraMemory>>,
    /// The quantities that thresholds cut; empty before the first.
    pub histograms: Vec<ThresholdHistogram>,
    pub history: History,
    /// Presets of the person.
    pub presets: Vec<OwnPreset>,
    /// What a new preset is named so far, while it is named.
    pub naming: Option<String>,
    pub compare: CompareLook,
    pub compared: Option<ShownComparison>,
    /// Why there is none.
    pub compare_error: Option<String>,
    /// Pictures of other programs, to be compared with; of the open scene.
    pub pictures: Vec<PictureFolder>,
    pub charts: Charts,
    pub path: CameraPath,
    /// How the capture is read, and how it would fit better.
    pub readings: ReadingCheck,
    /// The command palette, while it is open.
    pub palette: Option<CommandPalette>,
    /// The page of help that is open.
    pub help: Option<HelpPage>,
    /// The camera whose name in a legend is under the pointer.
    pub isolated: Option<usize>,
    /// The setting to scroll to, by its path.
    pub find_setting: Option<&'static str>,
    /// The adapter that draws the window; `None` without one.
    pub graphics: Option<String>,
    /// Bytes that the window's device has allocated on it when *About* was opened, where its driver says.
    pub graphics_memory: Option<u64>,
    /// What the program held in memory when it was asked for, by part, bytes.
    pub held_memory: Vec<(&'static str, u64)>,
    /// Views that were left by a jump.
    pub views: ViewHistory,
    /// Whether the introduction of the first run was read.
    pub introduced: bool,
    /// Whether the sentence about the room that comes with the program was read.
    pub room_explained: bool,
    /// The settings of the store that was saved last of the open capture, at first those that it was opened with.
    pub saved: Option<Settings>,
    /// What stands between the person and closing the window.
    pub closing: Closing,
    pub log: VecDeque<LogLine>,
    /// The reported parts of the open store that could not be read.
    pub reported_damage: BTreeSet<String>,
    pub meter: Meter,
}

impl Inspector {
    /// Forgets what belongs to a scene.
    pub(crate) fn close_scene(&mut self) {
        self.probe = InspectedPixel::default();
        self.thumbs.clear();
        self.memory = None;
        self.isolated = None;
        self.histograms.clear();
        self.compare.choice.from = CompareVantage::Live;
        self.close_pictures(|_| true);
        self.compared = None;
        self.path = CameraPath::default();
        self.views = ViewHistory::default();
        self.charts.close_scene();
        self.saved = None;
        self.compare_error = None;
        self.reported_damage.clear();
    }

    /// Name of a side of a comparison.
    pub(crate) fn side_name(&self, side: CompareSide) -> String {
        if let CompareSide::Pictures(id) = side {
            let folder = self.pictures.iter().find(|folder| folder.id == id);
            return folder.map(PictureFolder::name).unwrap_or_default();
        }
        let known = CompareSide::ALL.iter().find(|(of, ..)| *of == side);
        known.map(|(_, name, _)| (*name).to_owned()).unwrap_or_default()
    }

    /// Closes pictures of other programs; sides that showed them show what they did at first.
    pub(crate) fn close_pictures(&mut self, closes: impl Fn(&PictureFolder) -> bool) {
        self.pictures.retain(|folder| !closes(folder));
        let first = CompareLook::default().choice.sides;
        for (side, first) in self.compare.choice.sides.iter_mut().zip(first) {
            if let CompareSide::Pictures(id) = *side
                && self.pictures.iter().all(|folder| folder.id != id)
            {
                *side = first;
            }
        }
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

    /// Adds a line to the log.
    pub(crate) fn log(&mut self, kind: NoticeKind, text: String) {
        if self.log.len() == LOG {
            self.log.pop_front();
        }
        self.log.push_back(LogLine { at: Instant::now(), kind, text });
    }
}
