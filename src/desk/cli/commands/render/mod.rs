//! `overlook render`: a store seen from any vantages.

mod views;

use std::collections::BTreeSet;
use std::path::PathBuf;

use clap::Args;

use crate::cli::input::{self, RenderingArgs, StoreArgs, ValueArgs};
use crate::cli::output::{self, CommandError, PicturePaths};
use overlook_engine::capture::{TruthView, transforms};
use overlook_engine::error::{Error, Result};
use overlook_engine::plural::counted;
use overlook_engine::preprocess::diagnostics::Report;
use overlook_engine::whole_file;
use overlook_lab::truth::{CorrectedViews, ViewCorrections};
use views::{ShownValues, ViewPainting};

#[derive(Debug, Args)]
pub(crate) struct RenderArgs {
    #[command(flatten)]
    from: StoreArgs,
    /// The viewpoints: a manifest of the same form as a capture's. Its pictures are the truth, if they exist.
    #[arg(long, value_name = "TRANSFORMS")]
    views: PathBuf,
    /// Folder for the pictures, each under its view's own name.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Also score each view at the pose and exposure that are estimated from its own true picture: recorded poses of views and
    /// cameras are wrong by some pixels. Pictures are written at the poses of the views file.
    #[arg(long)]
    align_views: bool,
    /// Orthographic pictures: this many world units from the left edge to the right one. What lies behind a viewpoint is not shown, and
    /// nothing is scored, as true pictures are in perspective.
    #[arg(long, value_name = "WIDTH", value_parser = input::length, conflicts_with_all = ["align_views", "json"])]
    orthographic: Option<f64>,
    #[command(flatten)]
    shown: ValueArgs,
    /// Also write each value as an array beside the picture: NAME.npy behind the picture's name, float32, NaN where it is missing. What
    /// file names cannot have is written as in addresses: %2F for a slash.
    #[arg(long)]
    values: bool,
    #[command(flatten)]
    rendering: RenderingArgs,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

impl RenderArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        output::check_folder(&self.out)?;
        whole_file::refuse_pipe(&self.views)?;
        self.rendering.settings.only("render")?;
        let playback = self.from.open()?;
        let settings = self.rendering.of_store(playback.store().info())?;
        let place = self.from.store.display().to_string();
        let frames_are_ranked = playback.store().info().provenance.frames_are_ranked;
        let mut views = transforms::open_views_of(&self.views, frames_are_ranked)?;
        let report = &playback.store().info().report;
        let alignment = Report::from_json(report, &place)?.alignment;
        let corrected = alignment.as_ref().map_or_else(CorrectedViews::default, |alignment| {
            ViewCorrections::of(alignment).correct(&mut views)
        });
        let paths = self.picture_paths(&views)?;
        let colored = self.shown.channel(&playback.outline().values, &place)?;
        let values = ShownValues { args: &self.shown, colored, as_arrays: self.values, place: &place };
        if let Some(width) = self.orthographic {
            return output::export(std::slice::from_ref(&playback), None, |job| {
                let notice =
                    views::paint_orthographic(&playback, &views, width, &paths, &settings, &values, job)?;
                Ok((output::wrote_pictures(paths.len(), &self.out), notice))
            });
        }
        let painting = ViewPainting {
            playback: &playback,
            views: &views,
            paths: &paths,
            settings: &settings,
            values,
            aligns: self.align_views,
        };
        let evaluation = output::watched(|job| painting.paint(job))?;
        output::warn(&correction_notices(corrected, views.len()));
        output::warn(evaluation.notice.as_slice());
        output::warn(&playback.store().damage());
        if self.json {
            return output::print_json(&evaluation);
        }
        output::print(&format!(
            "{}\n{}\n{}",
            output::view_table(&evaluation),
            output::painter_line(&evaluation),
            output::wrote_pictures(paths.len(), &self.out)
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

/// What was changed about views, for people.
fn correction_notices(corrected: CorrectedViews, all: usize) -> Vec<String> {
    let CorrectedViews { lenses, poses, exposures } = corrected;
    let notices = [
        (
            lenses,
            "claim the capture's lens and are rendered through the color lens that was found in its place",
        ),
        (poses, "are moved as the pictures beside them were when poses were corrected"),
        (exposures, "are exposed as the pictures beside them were"),
    ];
    let told = notices.into_iter().filter(|(count, _)| *count > 0);
    told.map(|(count, what)| {
        format!(
            "{count} of {} {what} (--as-claimed renders them at the poses of their file)",
            counted(all, "view")
        )
    })
    .collect()
}
