//! Views of a store, rendered, written and scored.

use std::sync::Arc;

use crate::cli::input::ValueArgs;
use crate::cli::output::PicturePaths;
use overlook_engine::capture::{Camera, TruthView};
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::render::film::{self, FilmPicture, FilmSource};
use overlook_engine::render::output::{PictureValues, shown_values};
use overlook_engine::render::{Picture, Renderer, Vantage};
use overlook_engine::settings::RenderSettings;
use overlook_engine::store::playback::Playback;
use overlook_lab::{Evaluation, Scoreboard, add_aligned, frame_of, render_view, vantage_order};

/// How scalar values are shown.
pub(super) struct ShownValues<'a> {
    pub(super) args: &'a ValueArgs,
    /// The channel that pictures are colored by.
    pub(super) colored: Option<usize>,
    /// Whether values are written as arrays.
    pub(super) as_arrays: bool,
    /// The store, for errors.
    pub(super) place: &'a str,
}

impl ShownValues<'_> {
    /// Writes a picture with the values that it shows, if there are any.
    fn write(&self, paths: &PicturePaths, picture: &Picture, values: &PictureValues) -> Result<()> {
        if values.channels.is_empty() {
            return paths.write(picture);
        }
        let colored = |channel: usize| {
            let in_view = shown_values(picture, values, channel);
            let colors = self.args.colors(&values.channels[channel], &in_view, self.place)?;
            Ok(values.colored(picture, channel, &colors))
        };
        let colored = self.colored.map(colored).transpose()?;
        paths.write_with_values(picture, values, colored.as_ref().unwrap_or(picture), self.as_arrays)
    }
}

/// Views of a store, and where their pictures go.
pub(super) struct ViewPainting<'a> {
    pub(super) playback: &'a Playback,
    pub(super) views: &'a [TruthView],
    pub(super) paths: &'a [PicturePaths],
    pub(super) settings: &'a RenderSettings,
    /// How scalar values are shown.
    pub(super) values: ShownValues<'a>,
    /// Whether each view is also scored at the pose estimated from its true picture.
    pub(super) aligns: bool,
}

impl ViewPainting<'_> {
    /// Renders all views and writes their pictures.
    ///
    /// # Errors
    /// `Invalid` where the store has no frame of a view; those of rendering, of the truth and of writing; `Cancelled`.
    pub(super) fn paint(&self, job: &Job) -> Result<Evaluation> {
        let views: Vec<&TruthView> = self.views.iter().collect();
        let frame_of = |view: &TruthView| {
            let info = self.playback.store().info();
            frame_of(view, &info.name, &info.frame_numbers)
        };
        let frames = self.views.iter().map(frame_of).collect::<Result<Vec<_>>>()?;
        let mut renderer = Renderer::strict(self.settings.backend)?;
        let mut scores = Scoreboard::default();
        job.start("Rendering views", views.len());
        // Views of one vantage follow each other, so that flicker shows and the background stays.
        let order = vantage_order(&views);
        for &index in &order {
            job.check()?;
            let view = &self.views[index];
            let samples = self.playback.seen_from(&view.camera, frames[index], job)?;
            let painted = render_view(&mut renderer, &samples, view, None, self.settings, job)?;
            let vantage = Vantage { camera: view.camera.clone(), frame: frames[index] };
            let values = PictureValues::of(&samples, &vantage, &painted.picture);
            self.values.write(&self.paths[index], &painted.picture, &values)?;
            scores.add(view, painted);
            job.advance(1);
        }
        let mut evaluation = scores.finish().in_order_of_views(&order);
        if self.aligns {
            let seen =
                |view: &TruthView, camera: &Camera| self.playback.seen_from(camera, frame_of(view)?, job);
            add_aligned(&mut evaluation, &mut renderer, &views, self.settings, seen, job)?;
        }
        Ok(evaluation)
    }
}

/// Renders orthographic pictures from the places of all views, `width` world units wide, and writes them. Gives why the renderer of the
/// settings was not used.
///
/// # Errors
/// As [`ViewPainting::paint`].
pub(super) fn paint_orthographic(
    playback: &Arc<Playback>,
    views: &[TruthView],
    width: f64,
    paths: &[PicturePaths],
    settings: &RenderSettings,
    values: &ShownValues<'_>,
    job: &Job,
) -> Result<Option<String>> {
    let info = playback.store().info();
    let vantage = |view: &TruthView| {
        let frame = frame_of(view, &info.name, &info.frame_numbers)?;
        Ok(Vantage { camera: view.camera.clone(), frame })
    };
    let vantages = views.iter().map(vantage).collect::<Result<Vec<_>>>()?;
    let mut renderer = Renderer::strict(settings.backend)?;
    let source = FilmSource::Disk(playback.clone());
    let write = |nth: usize, shown: &FilmPicture| values.write(&paths[nth], &shown.picture, &shown.values());
    film::paint(&source, &vantages, Some(width), &mut renderer, settings, job, write)?;
    Ok(renderer.notice().map(str::to_owned))
}
