//! `overlook render`: a store seen from any vantages.

use std::collections::BTreeSet;
use std::path::PathBuf;

use clap::Args;

use crate::capture::{Camera, TruthView, transforms};
use crate::cli::input::{self, PaintingArgs, SettingsArgs};
use crate::cli::output::{self, CommandError, PicturePaths};
use crate::error::{Error, Result};
use crate::evaluate::{Evaluation, Scoreboard, add_aligned, frame_of, render_view, vantage_order};
use crate::job::Job;
use crate::preprocess::diagnostics::Report;
use crate::render::Renderer;
use crate::settings::RenderSettings;
use crate::store::playback::Playback;

#[derive(Debug, Args)]
pub(crate) struct RenderArgs {
    /// The store.
    store: PathBuf,
    /// The viewpoints: a manifest of the same form as a capture's. Where its pictures exist, they are the truth.
    #[arg(long, value_name = "TRANSFORMS")]
    views: PathBuf,
    /// Folder for the pictures, each under its view's own name.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Also score each view from where its own true picture says that it was taken, at its own exposure: poses of recordings are
    /// wrong by some pixels, those of views as those of cameras. Pictures are written as the views say.
    #[arg(long)]
    align_views: bool,
    #[command(flatten)]
    painting: PaintingArgs,
    #[command(flatten)]
    settings: SettingsArgs,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

impl RenderArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        self.settings.only("render")?;
        output::check_folder(&self.out)?;
        output::refuse_pipe(&self.views)?;
        let playback = input::open_store(&self.store)?;
        let mut settings = self.settings.over(playback.store().info().settings.clone())?.render;
        self.painting.apply(&mut settings);
        let frames_are_ranked = playback.store().info().provenance.frames_are_ranked;
        let mut views = transforms::open_views_of(&self.views, frames_are_ranked)?;
        let report = &playback.store().info().report;
        let alignment = Report::from_json(report, &self.store.display().to_string())?.alignment;
        let corrected = alignment.map_or(0, |alignment| alignment.correct_lenses_of(&mut views));
        let paths = self.picture_paths(&views)?;
        let evaluation =
            output::watched(|job| paint(&playback, &views, &paths, (&settings, self.align_views), job))?;
        if corrected > 0 {
            let what = format!(
                "views that claim the capture's lens are rendered through the color lens that was found in its place: {corrected} of {}",
                views.len()
            );
            output::warn(&[what]);
        }
        output::warn(evaluation.notice.as_slice());
        output::warn(&playback.store().damage());
        if self.json {
            return output::print_json(&evaluation);
        }
        output::print(&format!(
            "{}\n{}\nWrote {} pictures (EXR and PNG) to {}",
            output::view_table(&evaluation),
            output::painter_line(&evaluation),
            paths.len(),
            self.out.display()
        ))
    }

    /// Where each picture goes; checked before any is painted.
    fn picture_paths(&self, views: &[TruthView]) -> Result<Vec<PicturePaths>> {
        let mut taken = BTreeSet::new();
        let path_of = |view: &TruthView| {
            let paths = PicturePaths::below(&self.out, &view.file_path)?;
            if !taken.insert(paths.clone()) {
                return Err(Error::invalid(
                    format!("{}: view '{}'", self.views.display(), view.file_path),
                    "another view has the same name; give each its own file_path",
                ));
            }
            Ok(paths)
        };
        let paths = views.iter().map(path_of).collect::<Result<Vec<_>>>()?;
        output::refuse_true_pictures(&self.views, &self.out, &paths)?;
        Ok(paths)
    }
}

fn paint(
    playback: &Playback,
    views: &[TruthView],
    paths: &[PicturePaths],
    (settings, align_views): (&RenderSettings, bool),
    job: &Job,
) -> Result<Evaluation> {
    let info = playback.store().info();
    let index_of = |view| frame_of(view, &info.name, &info.frame_numbers);
    let frames = views.iter().map(index_of).collect::<Result<Vec<_>>>()?;
    let mut renderer = Renderer::strict(settings.backend)?;
    let mut scores = Scoreboard::default();
    job.start("Painting views", views.len());
    // Views of one vantage one after the other, so that flicker shows and the background stays.
    let order = vantage_order(&views.iter().collect::<Vec<_>>());
    for &index in &order {
        let (view, paths) = (&views[index], &paths[index]);
        job.check()?;
        let samples = playback.seen_from(&view.camera, frames[index], job)?;
        let painted = render_view(&mut renderer, &samples, view, None, settings, job)?;
        paths.write(&painted.picture)?;
        scores.add(view, painted);
        job.advance(1);
    }
    let mut evaluation = scores.finish().in_order_of_views(&order);
    if align_views {
        let seen = |view: &TruthView, camera: &Camera| {
            playback.seen_from(camera, frame_of(view, &info.name, &info.frame_numbers)?, job)
        };
        add_aligned(&mut evaluation, &mut renderer, &views.iter().collect::<Vec<_>>(), settings, seen, job)?;
    }
    Ok(evaluation)
}
