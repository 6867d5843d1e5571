//! Films: pictures along a camera path, rendered in order for files or a video.

mod encoder;
mod h264;
mod mp4;
mod path;

pub use encoder::FilmEncoder;
pub use path::{PathKey, pose_at};

use std::sync::Arc;

use super::orthographic::OrthographicView;
use super::renderer::Renderer;
use super::vantage::{Picture, Vantage};
use crate::error::Result;
use crate::job::Job;
use crate::samples::SampleSet;
use crate::settings::RenderSettings;
use crate::store::playback::Playback;

/// Where the samples of a film come from.
#[derive(Clone)]
pub enum FilmSource {
    /// All in memory.
    Memory(Arc<SampleSet>),
    /// From a store, frame by frame.
    Disk(Arc<Playback>),
}

impl FilmSource {
    /// The number of frames.
    #[must_use]
    pub fn frame_count(&self) -> usize {
        match self {
            Self::Memory(samples) => samples.frame_count(),
            Self::Disk(playback) => playback.outline().frame_count(),
        }
    }

    fn seen_from(&self, vantage: &Vantage, job: &Job) -> Result<Arc<SampleSet>> {
        match self {
            Self::Memory(samples) => Ok(samples.clone()),
            Self::Disk(playback) => playback.seen_from(&vantage.camera, vantage.frame, job),
        }
    }
}

/// Renders every vantage in order and passes the pictures to `take` with their index. The next frame is read from disk meanwhile.
///
/// # Errors
/// Those of reading, rendering and `take`, and `Cancelled`.
pub fn paint(
    source: &FilmSource,
    vantages: &[Vantage],
    renderer: &mut Renderer,
    settings: &RenderSettings,
    job: &Job,
    mut take: impl FnMut(usize, &Picture) -> Result<()>,
) -> Result<()> {
    job.start("Rendering", vantages.len());
    for (nth, vantage) in vantages.iter().enumerate() {
        job.check()?;
        let samples = source.seen_from(vantage, job)?;
        // An error in reading ahead returns when that frame is rendered.
        let ahead = || match (source, vantages.get(nth + 1)) {
            (FilmSource::Disk(playback), Some(next)) => {
                playback.read_ahead_from(&next.camera, next.frame..next.frame + 1, job)
            }
            _ => Ok(()),
        };
        let (painted, _) = rayon::join(|| renderer.render(&samples, vantage, settings, job), ahead);
        let (picture, _): (Arc<Picture>, _) = painted?;
        take(nth, &picture)?;
        job.advance(1);
    }
    Ok(())
}

/// As [`paint`], of orthographic pictures that are `width` world units wide.
///
/// # Errors
/// As [`paint`], and as [`OrthographicView::new`].
pub fn paint_orthographic(
    source: &FilmSource,
    vantages: &[Vantage],
    width: f64,
    renderer: &mut Renderer,
    settings: &RenderSettings,
    job: &Job,
    mut take: impl FnMut(usize, &Picture) -> Result<()>,
) -> Result<()> {
    job.start("Rendering", vantages.len());
    for (nth, vantage) in vantages.iter().enumerate() {
        job.check()?;
        // Which blocks a lens sees is known of perspective ones alone.
        let samples = match source {
            FilmSource::Memory(samples) => samples.clone(),
            FilmSource::Disk(playback) => playback.at(vantage.frame, job)?,
        };
        let view = OrthographicView::new(&samples, vantage, width)?;
        let (picture, _) = renderer.render(&view.samples, &view.vantage, settings, job)?;
        take(nth, &view.finish(&picture))?;
        job.advance(1);
    }
    Ok(())
}
