//! `overlook evaluate`: accuracy, speed and size of one setting.

use std::collections::BTreeSet;
use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use crate::capture::{Capture, TruthLoader, TruthView, transforms};
use crate::cli::input::{self, HoldOutArgs, PaintingArgs, SettingsArgs};
use crate::cli::output::{self, CommandError};
use crate::evaluate::{MethodComparison, MethodScore, PictureScores, compare, score_pictures, truth};
use crate::settings::Settings;

#[derive(Debug, Args)]
pub(crate) struct EvaluateArgs {
    /// The capture: a folder, or the file in it that names its pictures.
    capture: PathBuf,
    /// Vantages whose truth is known [default: the capture's novel/transforms.json].
    #[arg(long, value_name = "TRANSFORMS", conflicts_with = "hold_out")]
    views: Option<PathBuf>,
    /// Also score each view from where its own true picture says that it was taken, at its own exposure: poses of recordings are
    /// wrong by some pixels, those of views as those of cameras.
    #[arg(long)]
    align_views: bool,
    #[command(flatten)]
    held_out: HoldOutArgs,
    /// Score the pictures that another program made of the same viewpoints, under the viewpoints' own names in this folder; may be given
    /// several times.
    #[arg(long, value_name = "DIR")]
    pictures: Vec<PathBuf>,
    /// Folder for the truth, each picture of --pictures, and its error, beside each other.
    #[arg(long, value_name = "DIR", requires = "pictures")]
    error_maps: Option<PathBuf>,
    #[command(flatten)]
    painting: PaintingArgs,
    #[command(flatten)]
    settings: SettingsArgs,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct EvaluateOutput<'a> {
    #[serde(flatten)]
    as_set: &'a MethodScore,
    no_pruning: &'a MethodScore,
    first_camera: &'a MethodScore,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pictures: Vec<PictureScores>,
    hold_out: &'a [String],
    settings: &'a Settings,
}

impl EvaluateArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        let mut settings = self.settings.over(Settings::default())?;
        self.painting.apply(&mut settings.render);
        let capture = input::open_capture(&self.capture, &settings.capture)?;
        let (capture, views) = self.truth(capture)?;
        let loaders = self.pictures.iter().map(|folder| transforms::open_pictures(folder, &views));
        let loaders = loaders.collect::<Result<Vec<_>, _>>()?;
        let comparison = output::watched(|job| compare(&capture, &views, &settings, self.align_views, job))?;
        let MethodComparison { as_set, no_pruning, first_camera } = &comparison;
        let notices = [as_set, no_pruning, first_camera].map(|compared| compared.evaluation.notice.clone());
        output::warn(&notices.into_iter().flatten().collect::<BTreeSet<_>>().into_iter().collect::<Vec<_>>());
        let pictures = self.scored_pictures(&capture, &views, &loaders)?;
        if self.json {
            return output::print_json(&EvaluateOutput {
                as_set,
                no_pruning,
                first_camera,
                pictures,
                hold_out: &self.held_out.names(),
                settings: &settings,
            });
        }
        output::print(&format!(
            "{}{}\n{}\n\n{}",
            output::view_table(&as_set.evaluation),
            output::class_line(&as_set.evaluation),
            output::painter_line(&as_set.evaluation),
            output::comparison_table(&comparison) + &output::picture_table(&pictures)
        ))
    }

    /// The pictures of other programs, scored as ours are.
    fn scored_pictures(
        &self,
        capture: &Capture,
        views: &[TruthView],
        loaders: &[Vec<TruthLoader>],
    ) -> Result<Vec<PictureScores>, CommandError> {
        if loaders.is_empty() {
            return Ok(Vec::new());
        }
        let classes = output::watched(|job| truth::class_maps(capture, views, job))?;
        let mut all = Vec::new();
        for (folder, pictures) in self.pictures.iter().zip(loaders) {
            let name = folder.file_name().unwrap_or(folder.as_os_str()).to_string_lossy().into_owned();
            let scores = output::watched(|job| {
                score_pictures(&name, (views, pictures), &classes, job, |view, picture, classes| {
                    let (Some(maps), Some(truth)) = (&self.error_maps, &view.truth) else { return Ok(()) };
                    let file = output::PicturePaths::below(&maps.join(&name), &view.file_path)?.png;
                    output::write_error_map(&file, picture, &truth()?, classes)
                })
            })?;
            all.push(scores);
        }
        Ok(all)
    }

    /// The capture to preprocess, and the views to score it at.
    fn truth(&self, capture: Capture) -> Result<(Capture, Vec<TruthView>), CommandError> {
        let held_out = self.held_out.names();
        if !held_out.is_empty() {
            return Ok(truth::split(&capture, &held_out)?);
        }
        let views = self.views.clone().or_else(|| transforms::truth_beside(&self.capture)).ok_or_else(|| {
            CommandError::Usage(format!(
                "{} comes without truth views; name some with --views, or hold out a camera with --hold-out {}",
                self.capture.display(),
                capture.cameras.first().map_or("CAMERA", |camera| &camera.name)
            ))
        })?;
        let views = transforms::open_views_of(&views, capture.frames_are_ranked())?;
        Ok((capture, views))
    }
}
