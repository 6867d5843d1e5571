//! `overlook align`: what the rig got wrong, and poses without it.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use glam::{DMat3, DVec3};
use serde::Serialize;
use serde_json::Value;

use crate::alignment::{self, Aligned, Alignment};
use crate::capture::{Camera, Capture};
use crate::cli::input::{self, SettingsArgs};
use crate::cli::output::{self, CommandError};
use crate::error::{Error, Result};
use crate::settings::{AlignSettings, Correction, Settings};
use crate::whole_file;

#[derive(Debug, Args)]
pub(crate) struct AlignArgs {
    /// The capture: a folder or its transforms.json.
    capture: PathBuf,
    /// Where to write a manifest of the same pictures with the corrected poses, for other programs. Pictures are named as they lie
    /// beside the capture's own manifest.
    #[arg(long, value_name = "TRANSFORMS")]
    out: Option<PathBuf>,
    #[command(flatten)]
    settings: SettingsArgs,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct AlignOutput<'a> {
    /// `None` where nothing pays.
    alignment: Option<&'a Alignment>,
    seconds: f64,
}

impl AlignArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        // Who asks for corrections wants all of them, unless settings say otherwise.
        let all = AlignSettings { poses: Correction::Auto, exposure: Correction::Auto };
        let settings = self.settings.over(Settings { align: all, ..Settings::default() })?;
        if settings.align == AlignSettings::default() {
            let what = "every part of align is off; set at least one to auto".to_owned();
            return Err(CommandError::Usage(what));
        }
        if let Some(out) = &self.out {
            output::check_file(out, "transforms.json")?;
            self.settings.refuse_inputs(out)?;
            output::refuse_capture_files(&self.capture, None, out)?;
        }
        let capture = input::open_capture(&self.capture, &settings.capture)?;
        let started = std::time::Instant::now();
        let Aligned { capture: corrected, alignment } =
            output::watched(|job| alignment::align(&capture, &settings.align, job))?;
        let seconds = started.elapsed().as_secs_f64();
        if let Some(out) = &self.out {
            self.write(&capture, &corrected, out)?;
        }
        if self.json {
            return output::print_json(&AlignOutput { alignment: alignment.as_ref(), seconds });
        }
        let mut lines = alignment.as_ref().map_or_else(
            || vec!["Nothing to correct: no change makes cameras agree better by more than its standard error".to_owned()],
            Alignment::sentences,
        );
        lines.extend(self.out.iter().map(|out| format!("Wrote {}", out.display())));
        output::print(&lines.join("\n"))
    }

    /// Writes the capture's manifest with other poses, and all else as it is.
    fn write(&self, capture: &Capture, corrected: &Capture, out: &Path) -> Result<()> {
        let manifest =
            if self.capture.is_dir() { self.capture.join("transforms.json") } else { self.capture.clone() };
        let place = manifest.display();
        let text = std::fs::read_to_string(&manifest).map_err(|error| Error::io(&manifest, error))?;
        let invalid = |what: String| Error::invalid(&place, what);
        let mut json: Value = serde_json::from_str(&text).map_err(|error| invalid(error.to_string()))?;
        let folder = manifest.parent().unwrap_or(Path::new(""));
        let is_beside = absolute(out)?.parent() == absolute(&manifest)?.parent();
        let scale = json.get("applied_scale").and_then(Value::as_f64).unwrap_or(1.0);
        let entries = json.get_mut("frames").and_then(Value::as_array_mut);
        for (index, entry) in entries.into_iter().flatten().enumerate() {
            let camera = camera_of(entry, capture, folder).ok_or_else(|| {
                invalid(format!("entry {index} names no picture of the capture; give it a file_path"))
            })?;
            let (then, now) = (&capture.cameras[camera], &corrected.cameras[camera]);
            if then != now {
                correct_matrix(entry, then, now, scale).ok_or_else(|| {
                    invalid(format!("entry {index} has no 4×4 transform_matrix; give it one"))
                })?;
            }
            if !is_beside {
                name_from_elsewhere(entry, &absolute(folder)?);
            }
        }
        whole_file::write(out, |writer| {
            serde_json::to_writer_pretty(&mut *writer, &json)
                .map_err(std::io::Error::from)
                .and_then(|()| writer.write_all(b"\n"))
                .map_err(|error| Error::io(out, error))
        })
    }
}

fn absolute(path: &Path) -> Result<PathBuf> {
    std::path::absolute(if path.as_os_str().is_empty() { Path::new(".") } else { path })
        .map_err(|error| Error::io(path, error))
}

/// The camera that an entry's picture is of.
fn camera_of(entry: &Value, capture: &Capture, folder: &Path) -> Option<usize> {
    let named = absolute(&folder.join(entry.get("file_path")?.as_str()?)).ok()?;
    let is_named =
        |file: &PathBuf| absolute(file).is_ok_and(|file| file == named || file.with_extension("") == named);
    (0..capture.cameras.len()).find(|camera| {
        (0..capture.frame_count()).any(|frame| capture.files_of(*camera, frame).iter().any(is_named))
    })
}

/// Turns and moves the matrix of an entry, whose translations are `scale` times the capture's, as its camera was; `None` where there
/// is no such matrix.
fn correct_matrix(entry: &mut Value, then: &Camera, now: &Camera, scale: f64) -> Option<()> {
    let change = now.world_from_camera * then.camera_from_world();
    let rows = entry.get_mut("transform_matrix")?.as_array_mut()?;
    let at = |rows: &[Value], row: usize, column: usize| rows.get(row)?.get(column)?.as_f64();
    let column = |rows: &[Value], column: usize| {
        Some(DVec3::new(at(rows, 0, column)?, at(rows, 1, column)?, at(rows, 2, column)?))
    };
    let axes = DMat3::from_cols(column(rows, 0)?, column(rows, 1)?, column(rows, 2)?);
    let (axes, position) =
        (change.matrix3 * axes, change.matrix3 * column(rows, 3)? + scale * change.translation);
    for row in 0..3 {
        rows[row] = Value::from(vec![axes.x_axis[row], axes.y_axis[row], axes.z_axis[row], position[row]]);
    }
    Some(())
}

/// Names the files of an entry so that they are found from another folder.
fn name_from_elsewhere(entry: &mut Value, folder: &Path) {
    const FILES: [&str; 5] = ["file_path", "depth_file_path", "depth_path", "normal_file_path", "mask_path"];
    for key in FILES {
        if let Some(path) = entry.get(key).and_then(Value::as_str) {
            entry[key] = Value::from(folder.join(path).display().to_string());
        }
    }
}
