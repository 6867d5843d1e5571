//! `overlook evaluate`: accuracy, speed and size of one setting.

use std::collections::BTreeSet;
use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use crate::cli::input::{self, HoldOutArgs, PaintingArgs, SettingsArgs};
use crate::cli::output::{self, CommandError};
use overlook_engine::capture::transforms::{self, OtherPictures};
use overlook_engine::capture::{Capture, TruthView};
use overlook_engine::error::Result;
use overlook_engine::render::Picture;
use overlook_engine::settings::Settings;
use overlook_lab::metrics::ClassMap;
use overlook_lab::{MethodComparison, MethodScore, PictureScores, compare_each, score_pictures, truth};

/// Folder of our own error maps beside those of other programs.
const OURS: &str = "overlook";

#[derive(Debug, Args)]
pub(crate) struct EvaluateArgs {
    /// The capture: a folder, or the file in it that names its pictures.
    capture: PathBuf,
    /// Vantages whose truth is known [default: the capture's novel/transforms.json].
    #[arg(long, value_name = "TRANSFORMS", conflicts_with = "hold_out")]
    views: Option<PathBuf>,
    /// Also score each view at the pose and exposure that are estimated from its own true picture: recorded poses of views and
    /// cameras are wrong by some pixels.
    #[arg(long)]
    align_views: bool,
    #[command(flatten)]
    held_out: HoldOutArgs,
    /// Score the pictures that another program made of the same viewpoints; may be given several times. If the folder has a
    /// transforms.json, a viewpoint's picture is its entry with the same pose, lens and frame; otherwise it is the file with the
    /// viewpoint's name.
    #[arg(long, value_name = "DIR")]
    pictures: Vec<PathBuf>,
    /// Folder for the truth, each picture of --pictures and of ours (in `overlook`), and its error, beside each other.
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
        let others = self.others(&capture, &views)?;
        let comparison = output::watched(|job| {
            let mut on_picture = |view: &TruthView, picture: &Picture, classes: Option<&ClassMap>| {
                self.save_error_map(OURS, view, picture, classes)
            };
            compare_each(&capture, &views, &settings, self.align_views, job, &mut on_picture)
        })?;
        let MethodComparison { as_set, no_pruning, first_camera } = &comparison;
        let notices = [as_set, no_pruning, first_camera].map(|compared| compared.evaluation.notice.clone());
        output::warn(&notices.into_iter().flatten().collect::<BTreeSet<_>>().into_iter().collect::<Vec<_>>());
        let pictures = self.scored_pictures(&capture, &views, &others)?;
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

    /// The pictures of other programs, each under a name of its own; all views have one.
    fn others(&self, capture: &Capture, views: &[TruthView]) -> Result<Vec<(String, OtherPictures)>> {
        let mut others: Vec<(String, OtherPictures)> = Vec::new();
        for folder in &self.pictures {
            let other = transforms::open_pictures(folder, views, capture.frames_are_ranked())?;
            other.all()?;
            output::warn(&other.warning().into_iter().collect::<Vec<_>>());
            let is_free = |name: &String| name != OURS && others.iter().all(|(known, _)| known != name);
            let mut names = (2..).map(|nth| format!("{} ({nth})", other.name()));
            let name = std::iter::once(other.name()).chain(&mut names).find(is_free).unwrap_or_default();
            others.push((name, other));
        }
        Ok(others)
    }

    /// The pictures of other programs, scored as ours are.
    fn scored_pictures(
        &self,
        capture: &Capture,
        views: &[TruthView],
        others: &[(String, OtherPictures)],
    ) -> Result<Vec<PictureScores>, CommandError> {
        if others.is_empty() {
            return Ok(Vec::new());
        }
        let classes = output::watched(|job| truth::class_maps(capture, views, job))?;
        let mut all = Vec::new();
        for (name, other) in others {
            let scores = output::watched(|job| {
                score_pictures(name, other, views, &classes, job, |view, picture, classes| {
                    self.save_error_map(name, view, picture, classes)
                })
            })?;
            all.push(scores);
        }
        Ok(all)
    }

    /// Writes the truth, the picture of a program and its error, if the options choose a folder for them.
    fn save_error_map(
        &self,
        program: &str,
        view: &TruthView,
        picture: &Picture,
        classes: Option<&ClassMap>,
    ) -> Result<()> {
        let (Some(maps), Some(truth)) = (&self.error_maps, &view.truth) else { return Ok(()) };
        let file = output::PicturePaths::below(&maps.join(program), &view.file_path)?.png;
        output::write_error_map(&file, picture, &truth()?, classes)
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
