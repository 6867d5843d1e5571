//! Opens captures and stores.

use std::path::PathBuf;
use std::sync::Arc;

use super::requests::OpenRequest;
use crate::app::model::{Message, OpenScene, Origin, median_depth};
use crate::capture::{self, Capture, TruthView, transforms};
use crate::demo::Demo;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::settings::CaptureSettings;
use crate::store;
use crate::store::playback::Playback;

/// Opens a built-in scene, a capture or a store.
pub(crate) fn open(request: OpenRequest, job: &Job) -> Result<Message> {
    let opened = match request {
        OpenRequest::Demo { spec, settings } => {
            job.start(format!("Opening {}", spec.scene), 0);
            let demo = Demo::new(&spec)?;
            let capture = demo.capture(&settings);
            let truth = demo.truth_views();
            open_capture(Origin::Demo(spec.scene), capture, truth, job)
        }
        OpenRequest::Path { path, settings } => {
            job.start(format!("Opening {}", path.display()), 0);
            open_path(path, &settings, job)
        }
    }?;
    // Who cancelled meanwhile, or opened something else, does not want it any more.
    job.check()?;
    Ok(opened)
}

fn open_path(path: PathBuf, settings: &CaptureSettings, job: &Job) -> Result<Message> {
    if store::file::Store::is_store(&path)? {
        let playback = Playback::new(store::file::Store::open(&path)?, store::playback::DEFAULT_CACHE_BYTES);
        return Ok(Message::Opened(Arc::new(OpenScene::of_store(path, playback, job)?)));
    }
    let capture = capture::open(&path, settings)?;
    job.check()?;
    let truth = transforms::truth_beside(&path).map_or_else(
        || Ok(Vec::new()),
        |views| transforms::open_views_of(&views, capture.frames_are_ranked()),
    )?;
    open_capture(Origin::Path(path), capture, truth, job)
}

fn open_capture(origin: Origin, capture: Capture, truth: Vec<TruthView>, job: &Job) -> Result<Message> {
    job.check()?;
    if capture.cameras.is_empty() || capture.frame_count() == 0 {
        return Err(Error::invalid(&capture.name, "there is no camera or no frame in it"));
    }
    let depth = median_depth(capture.frame(0, 0)?.inverse_depth.as_slice());
    Ok(Message::Opened(Arc::new(OpenScene::of_capture(origin, capture, truth, depth))))
}
