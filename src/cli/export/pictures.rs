//! `overlook export pictures`.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;

use super::super::picture::PicturePaths;
use super::super::render::PaintingArgs;
use super::super::{Failure, SettingsArgs, output, progress};
use super::path::{self, Stop};
use crate::error::Result;
use crate::job::Job;
use crate::render::{Picture, Renderer, Vantage};
use crate::settings::{RenderSettings, Settings};
use crate::store::Playback;

/// Where a film is painted from, and how.
#[derive(Debug, Args)]
pub(super) struct FilmArgs {
    /// The store.
    pub(super) store: PathBuf,
    /// The camera path: a manifest of views, one place at a time; between them the camera moves evenly.
    #[arg(long, value_name = "TRANSFORMS")]
    path: PathBuf,
    #[command(flatten)]
    painting: PaintingArgs,
    #[command(flatten)]
    settings: SettingsArgs,
}

impl FilmArgs {
    /// The stops of the path and the settings to paint with.
    pub(super) fn plan(&self, playback: &Playback) -> Result<(Vec<Stop>, RenderSettings), Failure> {
        let info = playback.store().info();
        let mut settings: Settings = self.settings.over(info.settings.clone())?;
        self.painting.apply(&mut settings.render);
        Ok((path::along(&self.path, &info.frame_numbers)?, settings.render))
    }
}

/// Paints every stop in order and hands the pictures on; the next frame is read from disk while one is painted.
///
/// # Errors
/// Whatever painting and `take` give, and `Cancelled`.
pub(super) fn paint(
    playback: &Playback,
    stops: &[Stop],
    settings: &RenderSettings,
    job: &Job,
    mut take: impl FnMut(&Stop, &Picture) -> Result<()>,
) -> Result<()> {
    let mut renderer = Renderer::strict(settings.backend)?;
    job.start("Painting", stops.len());
    for (nth, stop) in stops.iter().enumerate() {
        job.check()?;
        let samples = playback.seen_from(&stop.camera, stop.frame, job)?;
        let vantage = Vantage { camera: stop.camera.clone(), frame: stop.frame };
        // A frame that cannot be read ahead says so when it is painted.
        let (painted, _) = rayon::join(
            || renderer.render(&samples, &vantage, settings, job),
            || stops.get(nth + 1).map(|next| playback.seen_from(&next.camera, next.frame, job)),
        );
        let (picture, _): (Arc<Picture>, _) = painted?;
        take(stop, &picture)?;
        job.advance(1);
    }
    Ok(())
}

/// Arguments of `overlook export pictures`.
#[derive(Debug, Args)]
pub(super) struct PicturesArgs {
    #[command(flatten)]
    film: FilmArgs,
    /// Folder for the pictures, named by their frame's number.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

impl PicturesArgs {
    pub(super) fn run(self) -> Result<(), Failure> {
        let playback = super::open(&self.film.store)?;
        let (stops, settings) = self.film.plan(&playback)?;
        progress::watched(|job| {
            paint(&playback, &stops, &settings, job, |stop, picture| {
                PicturePaths::below(&self.out, &format!("{:04}", stop.number))?.write(picture)
            })
        })?;
        output::warn(&playback.store().damage());
        output::print(&format!("Wrote {} pictures (EXR and PNG) to {}", stops.len(), self.out.display()))
    }
}
