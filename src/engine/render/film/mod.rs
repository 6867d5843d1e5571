//! Films: pictures along a camera path, rendered in order for files or a video.

mod compared;
mod encoder;
mod gif;
mod h264;
mod mp4;
mod path;

pub use compared::{FilmComparison, paint_compared};
pub use encoder::FilmEncoder;
pub use path::{PathKey, pose_at};

use std::sync::Arc;

use super::orthographic::OrthographicView;
use super::output::PictureValues;
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

    /// The samples for a picture. Which blocks of a store a picture shows is known of perspective ones alone.
    ///
    /// # Errors
    /// Those of reading, and `Cancelled`.
    pub fn samples_for(&self, vantage: &Vantage, is_orthographic: bool, job: &Job) -> Result<Arc<SampleSet>> {
        match self {
            Self::Memory(samples) => Ok(samples.clone()),
            Self::Disk(playback) if is_orthographic => playback.at(vantage.frame, job),
            Self::Disk(playback) => playback.seen_from(&vantage.camera, vantage.frame, job),
        }
    }
}

/// A picture of a film, with what its values are read from.
pub struct FilmPicture {
    /// The picture, with depths from its vantage.
    pub picture: Arc<Picture>,
    /// The picture as it was rendered of these samples at this vantage.
    rendered: (Arc<Picture>, Arc<SampleSet>, Vantage),
}

impl FilmPicture {
    /// The scalar values that it shows.
    #[must_use]
    pub fn values(&self) -> PictureValues {
        let (picture, samples, vantage) = &self.rendered;
        PictureValues::of(samples, vantage, picture)
    }
}

/// What paints the pictures of a film.
pub struct FilmPainter<'a> {
    /// The samples.
    pub source: &'a FilmSource,
    /// Where from, in order.
    pub vantages: &'a [Vantage],
    /// World units from the left edge to the right one of orthographic pictures; `None` of those through a lens.
    pub orthographic: Option<f64>,
    /// What renders.
    pub renderer: &'a mut Renderer,
    /// How.
    pub settings: &'a RenderSettings,
}

impl FilmPainter<'_> {
    /// The picture of a vantage. The next frame of perspective ones is read from disk meanwhile.
    ///
    /// # Errors
    /// Those of reading and rendering, as [`OrthographicView::new`], and `Cancelled`.
    pub fn picture(&mut self, nth: usize, job: &Job) -> Result<FilmPicture> {
        let (source, vantage) = (self.source, &self.vantages[nth]);
        let samples = source.samples_for(vantage, self.orthographic.is_some(), job)?;
        let parallel = |width: f64| OrthographicView::new(&samples, vantage, width);
        let view = self.orthographic.map(parallel).transpose()?;
        let (shown, from) = view.as_ref().map_or((&samples, vantage), |view| (&view.samples, &view.vantage));
        // An error in reading ahead returns when that frame is rendered.
        let ahead = || match (source, self.vantages.get(nth + 1)) {
            (FilmSource::Disk(playback), Some(next)) if view.is_none() => {
                playback.read_ahead_from(&next.camera, next.frame..next.frame + 1, job)
            }
            _ => Ok(()),
        };
        let (renderer, settings) = (&mut *self.renderer, self.settings);
        let (painted, _) = rayon::join(|| renderer.render(shown, from, settings, job), ahead);
        let (picture, _): (Arc<Picture>, _) = painted?;
        Ok(FilmPicture {
            picture: view.as_ref().map_or_else(|| picture.clone(), |view| view.finish(&picture).into()),
            rendered: (picture, shown.clone(), from.clone()),
        })
    }
}

/// Renders every vantage in order and passes the pictures to `take` with their index; `orthographic` pictures are so many world units
/// wide.
///
/// # Errors
/// Those of [`FilmPainter::picture`] and `take`.
pub fn paint(
    source: &FilmSource,
    vantages: &[Vantage],
    orthographic: Option<f64>,
    renderer: &mut Renderer,
    settings: &RenderSettings,
    job: &Job,
    mut take: impl FnMut(usize, &FilmPicture) -> Result<()>,
) -> Result<()> {
    job.start("Rendering", vantages.len());
    let mut painter = FilmPainter { source, vantages, orthographic, renderer, settings };
    for nth in 0..vantages.len() {
        job.check()?;
        take(nth, &painter.picture(nth, job)?)?;
        job.advance(1);
    }
    Ok(())
}
