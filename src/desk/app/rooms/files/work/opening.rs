//! Opens captures and stores.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::app::model::{Message, OpenScene, SceneSource, median_depth};
use crate::app::rooms::files::model::{Session, SessionLook};
use crate::app::work::requests::OpenRequest;
use overlook_engine::capture::{Capture, Source, TruthView, transforms};
use overlook_engine::demo::Demo;
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::settings::CaptureSettings;
use overlook_engine::store;
use overlook_engine::store::file::Store;
use overlook_engine::store::playback::Playback;
use overlook_engine::whole_file;

/// The store that the window opens by itself: `assets/room/make.sh` made it.
static ROOM: &[u8] = include_bytes!("../../../../../../assets/room/room.ovl");

/// What errors about it name.
const ROOM_NAME: &str = "the built-in room";

/// Opens a built-in scene, a capture or a store.
pub(crate) fn open(request: OpenRequest, job: &Job) -> Result<Message> {
    let opened = match request {
        OpenRequest::Demo { spec, settings } => {
            job.start(format!("Opening {}", spec.scene), 0);
            let demo = Demo::new(&spec)?;
            let capture = demo.capture(&settings);
            let truth = demo.truth_views();
            open_capture(SceneSource::Demo(spec.scene), capture, truth, job)
        }
        OpenRequest::Room => {
            let store = Store::over(Path::new(ROOM_NAME), Box::new(ROOM.to_vec()))?;
            let playback = Playback::new(store, store::playback::DEFAULT_CACHE_BYTES);
            OpenScene::of_store(SceneSource::Room, playback, job)
        }
        OpenRequest::Path { path, settings, keys } => {
            job.start(format!("Opening {}", path.display()), 0);
            if Session::is_session(&path) {
                open_session(&path, job)
            } else {
                open_path(path, &settings, &keys, job)
            }
        }
    }?;
    // Who cancelled meanwhile, or opened something else, does not want it any more.
    job.check()?;
    Ok(Message::Opened(Arc::new(opened)))
}

/// Opens what a session names, with its settings.
fn open_session(path: &Path, job: &Job) -> Result<OpenScene> {
    let session = Session::from_text(&whole_file::short_text(path)?, path)?;
    SessionLook::read(&session.look, path)?;
    let scene = open_path(session.opens.clone(), &session.settings.capture, &[], job)?;
    Ok(OpenScene { session: Some(session), ..scene })
}

fn open_path(
    path: PathBuf,
    settings: &CaptureSettings,
    keys: &[(String, String)],
    job: &Job,
) -> Result<OpenScene> {
    if Store::is_store(&path)? {
        let playback = Playback::new(Store::open(&path)?, store::playback::DEFAULT_CACHE_BYTES);
        return OpenScene::of_store(SceneSource::Path(path), playback, job);
    }
    let source = Source::find(&path)?;
    let manifest = source.manifest().map(PathBuf::from);
    let is_reread = !keys.is_empty();
    let source = if is_reread { source.read_as(keys)? } else { source };
    let up_is_estimated = source.description().up_is_estimated;
    let mut capture = source.open(settings)?;
    job.check()?;
    let mut truth = Vec::new();
    if is_reread {
        let keys: Vec<String> = keys.iter().map(|(key, value)| format!("\"{key}\": {value}")).collect();
        capture = capture.with_warning(format!(
            "it is open under another reading than that of its files; to keep this, write {} in the manifest",
            keys.join(", ")
        ));
    } else if let Some(views) = transforms::truth_beside(&path) {
        // Views beside a capture that is read otherwise are placed as the capture was: they would show something else.
        truth = transforms::open_views_of(&views, capture.frames_are_ranked())?;
    }
    let scene = open_capture(SceneSource::Path(path), capture, truth, job)?;
    Ok(OpenScene { up_is_estimated, manifest, is_reread, ..scene })
}

fn open_capture(
    origin: SceneSource,
    capture: Capture,
    truth: Vec<TruthView>,
    job: &Job,
) -> Result<OpenScene> {
    job.check()?;
    if capture.cameras.is_empty() || capture.frame_count() == 0 {
        return Err(Error::invalid(&capture.name, "there is no camera or no frame in it"));
    }
    let depth = median_depth(capture.frame(0, 0)?.inverse_depth.as_slice());
    Ok(OpenScene::of_capture(origin, capture, truth, depth))
}
