//! The requests that workers take.

use std::path::PathBuf;
use std::sync::Arc;

use crate::app::model::{Message, OpenScene};
use crate::app::rooms::charts::state::StudyPlan;
use overlook_engine::demo::DemoSpec;
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::settings::CaptureSettings;

/// What to open.
#[derive(Clone, Debug)]
pub(crate) enum OpenRequest {
    /// A built-in scene.
    Demo { spec: DemoSpec, settings: CaptureSettings },
    /// The room that comes with the program.
    Room,
    /// A file or folder; `keys` of a manifest, with their values as JSON, count whatever its files say.
    Path { path: PathBuf, settings: CaptureSettings, keys: Vec<(String, String)> },
}

/// Work of a worker.
type Work = Box<dyn FnOnce(&Job) -> Result<Message> + Send>;

/// A file that is read or written, or what is drawn for the clipboard.
pub(crate) struct FileWork {
    /// Title and text of the message once it was stopped.
    pub stopped: (&'static str, String),
    pub run: Work,
}

impl FileWork {
    /// Work that `run` does.
    pub(crate) fn new(
        stopped: (&'static str, String),
        run: impl FnOnce(&Job) -> Result<Message> + Send + 'static,
    ) -> Self {
        Self { stopped, run: Box::new(run) }
    }
}

/// What to measure.
pub(crate) struct StudyRequest {
    pub scene: Arc<OpenScene>,
    pub plan: StudyPlan,
}
