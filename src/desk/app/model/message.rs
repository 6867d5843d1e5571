//! What workers send to the window. Heavy results travel as `Arc`.

use std::path::PathBuf;
use std::sync::Arc;

use crate::app::model::look::FrameValues;
use crate::app::model::picture::{CarriedLook, CarryKey, LiveKey, LivePicture, SourceKey, SourcePicture};
use crate::app::model::purpose::Purpose;
use crate::app::model::scene::{Accuracy, CameraMemory, Inspected, OpenScene};
use crate::app::model::work_kind::WorkKind;
use crate::app::rooms::change::state::ChangeRequest;
use crate::app::rooms::charts::state::Found;
use crate::app::rooms::compare::state::{CompareKey, PictureDifference, PictureFolder};
use crate::app::rooms::edits::state::{EditKey, EditedScene};
use crate::app::rooms::files::state::Session;
use crate::app::rooms::path::{CameraPath, SavedPathKey};
use crate::app::rooms::pixel::state::{Probed, Spot};
use crate::app::rooms::readings::state::ReadingImages;
use crate::app::rooms::settings::ThresholdHistogram;
use crate::app::rooms::share::state::{Exported, SharePreviewKey};
use crate::ways_out::Facts;
use overlook_engine::capture::conventions::Finding;
use overlook_engine::capture::transforms::PathFile;
use overlook_engine::edits::EditList;
use overlook_engine::error::Error;
use overlook_engine::preprocess::{PreparedScan, Preprocessed};
use overlook_engine::settings::Settings;
use overlook_lab::tune::Tuned;

/// An answer of a worker.
pub(crate) enum Message {
    /// A capture, demo or store is open, perhaps by a session.
    Opened { scene: Arc<OpenScene>, session: Option<Box<Session>> },
    /// The pass over all frames is done.
    Scanned { scene: u64, scan: Arc<PreparedScan> },
    /// The whole capture is pruned. Reading all frames took so many seconds; `None` where they were read before.
    Pruned { scene: u64, settings: Settings, result: Arc<Preprocessed>, read_seconds: Option<f64> },
    /// One frame is pruned, with reasons.
    Inspected { scene: u64, inspected: Inspected },
    /// One frame is ready for thresholds to be turned.
    Prepared,
    /// The left picture.
    SourcePainted { key: SourceKey, picture: Arc<SourcePicture> },
    /// The right picture.
    LivePainted { key: LiveKey, picture: Arc<LivePicture> },
    /// The live picture as the view shows it now, until it is painted; `None` where nothing of it is in view.
    LiveCarried { key: CarryKey, carried: Option<CarriedLook> },
    /// Accuracy at vantages with truth; `None` without such vantages.
    Measured { scene: u64, settings: Settings, accuracy: Option<Accuracy> },
    /// The evidence about a pixel; `None` for a hole, and without verdicts.
    Probed { scene: u64, spot: Spot, probed: Option<Arc<Probed>>, is_hole: bool },
    /// Every camera small, in the capture's order.
    Thumbnails { scene: u64, pictures: Vec<Arc<egui::ColorImage>> },
    /// The quantities that thresholds cut.
    Histograms { scene: u64, histograms: Vec<ThresholdHistogram> },
    /// The samples that a change of settings dropped, and those that it brought back.
    ChangePainted { request: Box<ChangeRequest>, pictures: [Option<Arc<egui::ColorImage>>; 2] },
    /// The values that the live view shows in colors.
    ValuesCounted { scene: u64, values: FrameValues },
    /// Two pictures of one place, or why there are none.
    Compared { key: Box<CompareKey>, outcome: Result<PictureDifference, String> },
    /// What takes the memory, by camera.
    MemoryMapped { scene: u64, cameras: Vec<CameraMemory> },
    /// A file is written. `bytes` is the size of a store; `holds` names the scene and the settings of samples in it.
    Saved { path: PathBuf, bytes: Option<u64>, holds: Option<(u64, Settings)> },
    /// What a study measured last, and how much of it is known, of how much.
    Found { scene: u64, found: Box<Found>, known: (usize, usize) },
    /// The settings that tuning found.
    Tuned { scene: u64, tuned: Box<Tuned> },
    /// A study is done, or its time is over with so many measurements left.
    Studied { scene: u64, left: usize },
    /// What goes to the clipboard, and what it is called; a figure also has a width on paper.
    Drawn { image: egui::ColorImage, name: String, width_mm: Option<f64> },
    /// What is shared is written.
    Exported { path: PathBuf, exported: Exported },
    /// What is shared within a budget, and its PSNR beside the picture of all samples, dB; `None` where it is too small for anything.
    SharePreviewed { key: SharePreviewKey, preview: Option<(Arc<egui::ColorImage>, Option<f64>)> },
    /// What sizes follow from is measured.
    SizesMeasured { scene: u64, facts: Facts },
    /// The folder of a file is shown by the system.
    FolderShown,
    /// A session was written, with the camera path and the edits in it.
    SessionSaved { path: PathBuf, keys: Vec<SavedPathKey>, list: EditList },
    /// A camera path is written.
    PathSaved { path: PathBuf, saved: CameraPath },
    /// A camera path is read.
    PathLoaded { scene: u64, path: PathBuf, file: PathFile },
    /// Pictures of another program are open.
    PicturesOpened { scene: u64, folder: PictureFolder },
    /// What edits leave of the samples, or why they cannot be applied.
    Edited { key: Box<EditKey>, edited: Result<Box<EditedScene>, String> },
    /// An edit list is written.
    EditsSaved { path: PathBuf, list: EditList },
    /// An edit list is read.
    EditsLoaded { scene: u64, path: PathBuf, list: EditList },
    /// Settings are read.
    SettingsLoaded { path: PathBuf, settings: Settings },
    /// A dialog was answered; `None` if it was closed.
    PathChosen { purpose: Purpose, path: Option<PathBuf> },
    /// Whether a file or folder to be written exists already.
    PathChecked { purpose: Purpose, path: PathBuf, taken: bool },
    /// Writing was stopped by the person.
    Stopped { title: &'static str, text: String },
    /// The finding about a capture's reading from the agreement of its views, or why there is none.
    ReadingsChecked { scene: u64, finding: Result<Arc<Finding>, String> },
    /// Two readings as pictures, or why there are none.
    ReadingsShown { scene: u64, images: Result<ReadingImages, String> },
    /// A job failed or was cancelled.
    Failed { work: WorkKind, error: Error },
}

impl Message {
    /// The scene of the answer, where the answer is of no use once another scene is open.
    pub(crate) fn scene(&self) -> Option<u64> {
        match self {
            Self::Scanned { scene, .. }
            | Self::Pruned { scene, .. }
            | Self::Inspected { scene, .. }
            | Self::Measured { scene, .. }
            | Self::Probed { scene, .. }
            | Self::Thumbnails { scene, .. }
            | Self::Histograms { scene, .. }
            | Self::ValuesCounted { scene, .. }
            | Self::MemoryMapped { scene, .. }
            | Self::Found { scene, .. }
            | Self::Tuned { scene, .. }
            | Self::Studied { scene, .. }
            | Self::PicturesOpened { scene, .. }
            | Self::SizesMeasured { scene, .. }
            | Self::ReadingsChecked { scene, .. }
            | Self::ReadingsShown { scene, .. }
            | Self::EditsLoaded { scene, .. }
            | Self::PathLoaded { scene, .. } => Some(*scene),
            Self::ChangePainted { request, .. } => Some(request.scene),
            Self::Edited { key, .. } => Some(key.scene.id),
            Self::SharePreviewed { key, .. } => Some(key.scene.id),
            Self::SourcePainted { key, .. } => Some(key.scene),
            Self::LivePainted { key, .. } => Some(key.scene),
            Self::LiveCarried { key, .. } => Some(key.scene),
            Self::Compared { key, .. } => Some(key.scene.id),
            _ => None,
        }
    }
}
