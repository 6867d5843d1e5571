//! `overlook export pictures`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;

use super::path::{self, Pace, Stops};
use crate::cli::input::{self, PaintingArgs, SettingsArgs};
use crate::cli::output::{self, CommandError, PicturePaths};
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::plural::counted;
use overlook_engine::render::film::{self, FilmSource};
use overlook_engine::render::{Picture, Renderer};
use overlook_engine::settings::{RenderSettings, Settings};
use overlook_engine::store::playback::Playback;
use overlook_engine::whole_file;

/// Where a film is painted from, and how.
#[derive(Debug, Args)]
pub(crate) struct FilmArgs {
    /// The store.
    store: PathBuf,
    /// The camera path: views at some frames, between which the camera moves smoothly, or every picture of a film, as the window and
    /// nerfstudio's viewer write it. Of a scene of one frame every view is a picture.
    #[arg(long, value_name = "TRANSFORMS")]
    path: PathBuf,
    /// Hold the scene at this frame, by its number: every view of the path is a picture of one moment.
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true)]
    frame: Option<i64>,
    /// So many pictures, spread evenly over the path; more than it has frames are slow motion.
    #[arg(long, value_name = "N", value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(1..1_000_000))]
    pictures: Option<usize>,
    #[command(flatten)]
    painting: PaintingArgs,
    #[command(flatten)]
    settings: SettingsArgs,
}

impl FilmArgs {
    /// Refuses a file that the film is made from, and any other store.
    pub(crate) fn refuse_inputs(&self, out: &Path) -> Result<()> {
        output::refuse_input(&self.store, out)?;
        output::refuse_store(out)?;
        self.settings.refuse_inputs(out)?;
        output::refuse_view_files(&self.path, out)
    }

    /// The open store, the stops of the path, and the settings to paint with.
    pub(crate) fn plan(&self) -> Result<(Arc<Playback>, Stops, RenderSettings), CommandError> {
        self.settings.only("render")?;
        whole_file::refuse_pipe(&self.path)?;
        let playback = input::open_store(&self.store)?;
        let info = playback.store().info();
        let mut settings: Settings = self.settings.over(info.settings.clone())?;
        self.painting.apply(&mut settings.render);
        let pace = Pace { frame: self.frame, pictures: self.pictures };
        let stops = path::along(&self.path, info, pace)?;
        Ok((Arc::new(playback), stops, settings.render))
    }
}

/// Renders every stop in order and passes each picture on with its index; returns a notice if another renderer than requested was
/// used.
pub(crate) fn paint(
    playback: &Arc<Playback>,
    stops: &Stops,
    settings: &RenderSettings,
    job: &Job,
    take: impl FnMut(usize, &Picture) -> Result<()>,
) -> Result<Option<String>> {
    let mut renderer = Renderer::strict(settings.backend)?;
    film::paint(&FilmSource::Disk(playback.clone()), &stops.vantages, &mut renderer, settings, job, take)?;
    Ok(renderer.notice().map(str::to_owned))
}

#[derive(Debug, Args)]
pub(crate) struct PicturesArgs {
    #[command(flatten)]
    film: FilmArgs,
    /// Folder for the pictures, named by their frame's number, or by their own where a frame has several.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

impl PicturesArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        output::check_folder(&self.out)?;
        let (playback, stops, settings) = self.film.plan()?;
        let path_of = |number: &i64| PicturePaths::below(&self.out, &format!("{number:04}"));
        let paths = stops.numbers.iter().map(path_of).collect::<Result<Vec<_>>>()?;
        output::refuse_true_pictures(&self.film.path, &self.out, &paths)?;
        let notice = output::watched(|job| {
            paint(&playback, &stops, &settings, job, |nth, picture| paths[nth].write(picture))
        })?;
        output::warn(notice.as_slice());
        output::warn(&playback.store().damage());
        let (pictures, out) = (counted(paths.len(), "picture"), self.out.display());
        output::print(&format!("Wrote {pictures} (EXR and PNG) to {out}"))
    }
}
