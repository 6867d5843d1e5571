//! Measures what the sizes of what is shared follow from, and shows folders.

use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::sharing::temporary_folder;
use crate::app::model::{Content, Message, OpenScene, Same, State};
use crate::app::rooms::colors::model::Display;
use crate::app::rooms::files::work::files::save_picture;
use crate::app::rooms::live::model::{LivePicture, PixelSource};
use crate::app::rooms::share::model::{PictureFacts, ShareFacts, ShareKey};
use crate::app::work::slot::Wanted;
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::samples::SampleSet;
use overlook_engine::store::file::{Extras, write_with};
use overlook_engine::whole_file;

/// Samples that are written to measure how large a store is: those of as many cameras as it takes to have so many.
const MEASURED_SAMPLES: u64 = 1_000_000;

impl Wanted for ShareKey {
    /// What sizes follow from, while the dialog that shows them is open.
    fn wanted(state: &State) -> Option<Self> {
        let samples = state.samples_here().filter(|_| state.share.is_open)?;
        let shown = state.doc.live_shown.as_ref().filter(|shown| shown.key.quality.is_none());
        Some(Self {
            scene: state.doc.scene.clone()?,
            // Until the whole capture is pruned only pictures have a size.
            samples: Same(state.whole_samples().unwrap_or(samples).clone()),
            frame: state.timeline.frame,
            picture: shown.map(|shown| Same(shown.picture.clone())),
        })
    }
}

/// What was measured of samples that are in memory.
#[derive(Default)]
pub(crate) struct StoreMeter {
    known: Option<(Arc<SampleSet>, f64)>,
}

impl StoreMeter {
    /// Counts and measures.
    pub(crate) fn facts(&mut self, key: &ShareKey, job: &Job) -> Result<Message> {
        let here = samples_of_frame(&key.scene, &key.samples, key.frame, job)?;
        let (samples, store_bytes) = match &key.scene.content {
            Content::Store { playback, bytes, .. } => (playback.store().info().sample_count(), *bytes as f64),
            Content::Capture { .. } => (here.sample_count(), self.store_bytes(&here, job)?),
        };
        let of_frame = || here.images_at(key.frame);
        let placed_here: u64 = of_frame().map(|image| image.placed_count()).sum();
        let all_here: u64 = of_frame().map(|image| image.len() as u64).sum();
        let picture = key.picture.as_deref().map(|picture| picture_facts(picture)).transpose()?.flatten();
        let facts = ShareFacts {
            samples,
            placed_here,
            at_infinity_here: all_here - placed_here,
            store_bytes,
            picture,
        };
        Ok(Message::SizesMeasured { scene: key.scene.id, facts })
    }

    /// Bytes of the store of a set.
    fn store_bytes(&mut self, samples: &Arc<SampleSet>, job: &Job) -> Result<f64> {
        if let Some((_, bytes)) = self.known.as_ref().filter(|(known, _)| Arc::ptr_eq(known, samples)) {
            return Ok(*bytes);
        }
        let some = of_first_cameras(samples);
        let folder = temporary_folder()?;
        let written = write_with(&folder.path().join("part.ovl"), &some, &Extras::default(), job)?;
        let bytes = written as f64 * samples.sample_count() as f64 / some.sample_count().max(1) as f64;
        self.known = Some((samples.clone(), bytes));
        Ok(bytes)
    }
}

/// A set that has the samples of a frame in memory; `samples` are those of a capture.
pub(crate) fn samples_of_frame(
    scene: &OpenScene,
    samples: &Arc<SampleSet>,
    frame: usize,
    job: &Job,
) -> Result<Arc<SampleSet>> {
    match &scene.content {
        Content::Store { playback, .. } => playback.at(frame, job),
        Content::Capture { .. } => Ok(samples.clone()),
    }
}

/// The samples of as many of the first cameras as have [`MEASURED_SAMPLES`]: images of one camera are predicted from each other.
fn of_first_cameras(samples: &SampleSet) -> SampleSet {
    let mut some = samples.clone();
    let mut wanted = 0;
    let mut count = 0;
    while count < MEASURED_SAMPLES && wanted < samples.cameras.len() as u32 {
        let of_next = samples.images.iter().filter(|image| image.camera == wanted);
        count += of_next.map(|image| image.len() as u64).sum::<u64>();
        wanted += 1;
    }
    some.images.retain(|image| image.camera < wanted);
    some
}

/// What a picture takes in both formats; `None` while its pixels are out of reach.
fn picture_facts(picture: &LivePicture) -> Result<Option<PictureFacts>> {
    let PixelSource::InMemory { image, rendered } = &picture.pixels else { return Ok(None) };
    let folder = temporary_folder()?;
    let written = |name: &str| -> Result<f64> {
        let path = folder.path().join(name);
        save_picture(&path, image, rendered, &Display::default())?;
        let length = std::fs::metadata(&path).map_err(|error| Error::io(&path, error))?.len();
        Ok(length as f64)
    };
    let pixels = (image.width() * image.height()) as f64;
    Ok(Some(PictureFacts { pixels, png_bytes: written("picture.png")?, exr_bytes: written("picture.exr")? }))
}

/// How long a program that opens folders is waited for: one that still runs has opened it.
const OPENED_BY: Duration = Duration::from_secs(4);

/// How often it is checked whether it has ended.
const POLL_INTERVAL: Duration = Duration::from_millis(20);

/// Opens the folder of a file in the system's file manager.
///
/// # Errors
/// `Unsupported` where there is none, with the folder.
pub(crate) fn show_in_folder(path: &Path) -> Result<Message> {
    let folder = whole_file::folder_of(path);
    let program = if cfg!(target_os = "macos") {
        "open"
    } else if cfg!(windows) {
        "explorer"
    } else {
        "xdg-open"
    };
    let none =
        || Error::unsupported(folder.display(), "this system has no file manager to open the folder with");
    let mut command = Command::new(program);
    command.arg(folder).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let mut opener = command.spawn().map_err(|_| none())?;
    let started = Instant::now();
    while started.elapsed() < OPENED_BY {
        match opener.try_wait() {
            // Windows' explorer gives no meaning to its exit status.
            Ok(Some(status)) if status.success() || cfg!(windows) => return Ok(Message::FolderShown),
            Ok(None) => std::thread::sleep(POLL_INTERVAL),
            _ => return Err(none()),
        }
    }
    // Where the file manager itself was started it runs until it is closed; its end is taken note of.
    let waiter = std::thread::Builder::new().name("file manager".to_owned());
    waiter.spawn(move || opener.wait()).map_err(|error| Error::io(folder, error))?;
    Ok(Message::FolderShown)
}
