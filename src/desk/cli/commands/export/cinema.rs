//! `overlook export cinema`.

use std::path::PathBuf;

use clap::Args;

use super::super::demo::parse_size;
use crate::app::pivot_of_store;
use crate::cli::input::{RenderingArgs, StoreArgs};
use crate::cli::output::{self, CommandError, PicturePaths};
use overlook_engine::capture::cinema::{AngleRange, DatabaseCamera, DatabaseRow, grid, write_table};
use overlook_engine::capture::{Camera, Intrinsics};
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::plural::counted;
use overlook_engine::render::film::{self, FilmSource};
use overlook_engine::render::{Renderer, Vantage};
use overlook_engine::store::playback::Playback;
use overlook_engine::whole_file;

/// Angles where none are asked for: about what cameras look at, and above it.
const COUNTS: [usize; 2] = [9, 3];

/// The most pictures of a database.
const MOST_PICTURES: usize = 100_000;

#[derive(Debug, Args)]
pub(crate) struct CinemaArgs {
    #[command(flatten)]
    from: StoreArgs,
    /// Folder for the database, by custom with the ending .cdb.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Angles about up, degrees: the first, the last and how many, as in --phi 0,360,24 [default: 9 between the cameras]
    #[arg(long, value_name = "FIRST,LAST,COUNT", value_parser = parse_range, allow_hyphen_values = true)]
    phi: Option<AngleRange>,
    /// Angles above what the cameras look at, degrees, likewise [default: 3 between the cameras]
    #[arg(long, value_name = "FIRST,LAST,COUNT", value_parser = parse_range, allow_hyphen_values = true)]
    theta: Option<AngleRange>,
    /// Columns and rows of the pictures [default: those of the first camera]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<(u32, u32)>,
    #[command(flatten)]
    rendering: RenderingArgs,
}

/// `FIRST,LAST,COUNT`.
fn parse_range(text: &str) -> std::result::Result<AngleRange, String> {
    let wrong = || format!("'{text}' is not of the form FIRST,LAST,COUNT in degrees, as in 0,360,24");
    let parts: Vec<&str> = text.split(',').map(str::trim).collect();
    let [first, last, count] = parts[..] else { return Err(wrong()) };
    let angle = |text: &str| text.parse().ok().filter(|angle: &f64| angle.abs() <= 3600.0).ok_or_else(wrong);
    let count = count.parse().ok().filter(|count| (1..=10_000).contains(count)).ok_or_else(wrong)?;
    Ok(AngleRange { first: angle(first)?, last: angle(last)?, count })
}

impl CinemaArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        self.from.check_out(&self.out, None)?;
        self.rendering.settings.refuse_inputs(&self.out)?;
        self.rendering.settings.only("render")?;
        let playback = self.from.open()?;
        let settings = self.rendering.of_store(playback.store().info())?;
        let views = self.viewpoints(&playback)?;
        let (rows, vantages) = self.planned(&views, &playback)?;
        let mut renderer = Renderer::strict(settings.backend)?;
        let source = FilmSource::Disk(playback.clone());
        let (pictures, places) = (counted(rows.len(), "picture"), counted(views.len(), "viewpoint"));
        output::export(std::slice::from_ref(&playback), None, |job| {
            whole_file::write_folder(&self.out, |folder| {
                film::paint(&source, &vantages, None, &mut renderer, &settings, job, |nth, shown| {
                    PicturePaths::below(folder, &rows[nth].files[0])?.write(&shown.picture)
                })?;
                write_table(folder, &rows)
            })?;
            let said = format!("Wrote {pictures}, of {places}, to {}", self.out.display());
            Ok((said, renderer.notice().map(str::to_owned)))
        })
    }

    /// Where the pictures are taken from, with their angles.
    fn viewpoints(&self, playback: &Playback) -> Result<Vec<([f64; 2], DatabaseCamera)>> {
        let outline = playback.outline();
        let middle = pivot_of_store(playback, &Job::new())?;
        Ok(grid(&outline.cameras, middle, outline.up_in_world, [self.phi, self.theta], COUNTS))
    }

    /// The rows of the table, and the vantage of each.
    fn planned(
        &self,
        views: &[([f64; 2], DatabaseCamera)],
        playback: &Playback,
    ) -> Result<(Vec<DatabaseRow>, Vec<Vantage>)> {
        let outline = playback.outline();
        let first = outline.cameras.first();
        let first =
            first.ok_or_else(|| Error::invalid(self.from.store.display(), "there is no camera in it"))?;
        let (width, height) = self.size.unwrap_or((first.intrinsics.width, first.intrinsics.height));
        let count = views.len() * outline.frame_count();
        if count > MOST_PICTURES {
            let pictures = counted(count, "picture");
            let what = format!(
                "it would have {pictures}, more than {MOST_PICTURES}; give fewer angles with --phi and --theta"
            );
            return Err(Error::invalid(self.out.display(), what));
        }
        let (mut rows, mut vantages) = (Vec::new(), Vec::new());
        for (frame, number) in outline.frame_numbers.iter().enumerate() {
            for (nth, (angles, camera)) in views.iter().enumerate() {
                let pose = camera.world_from_camera().zip(camera.focal_length_px(f64::from(height)));
                // Straight from above no direction is up.
                let Some((world_from_camera, focal)) = pose else { continue };
                let intrinsics = Intrinsics::centered(width, height, focal);
                let camera_of = Camera { name: format!("view {nth}"), intrinsics, world_from_camera };
                vantages.push(Vantage { camera: camera_of, frame });
                let files = ["png", "exr"].map(|extension| format!("{number:04}_{nth:04}.{extension}"));
                rows.push(DatabaseRow { time: *number, angles: *angles, camera: *camera, files });
            }
        }
        Ok((rows, vantages))
    }
}
