//! `overlook align`: what the rig got wrong, and poses without it.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use glam::{DAffine3, DMat3, DVec3};
use serde::Serialize;
use serde_json::Value;

use crate::alignment::{self, Aligned, Alignment};
use crate::capture::conventions::{MIRROR, PoseConvention};
use crate::capture::transforms::manifest_path;
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
            if !manifest_path(&self.capture).is_file() {
                let what = "has no transforms.json that could be written with other poses; make one with 'overlook info CAPTURE --write-manifest'";
                return Err(Error::invalid(self.capture.display(), what).into());
            }
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
        let manifest = manifest_path(&self.capture);
        let place = manifest.display();
        let text = std::fs::read_to_string(&manifest).map_err(|error| Error::io(&manifest, error))?;
        let invalid = |what: String| Error::invalid(&place, what);
        let mut json: Value = serde_json::from_str(&text).map_err(|error| invalid(error.to_string()))?;
        let folder = manifest.parent().unwrap_or(Path::new(""));
        let is_beside = absolute(out)?.parent() == absolute(&manifest)?.parent();
        let convention = capture.source.pose_convention();
        let entries = json.get_mut("frames").and_then(Value::as_array_mut);
        for (index, entry) in entries.into_iter().flatten().enumerate() {
            let camera = camera_of(entry, capture, folder).ok_or_else(|| {
                invalid(format!("entry {index} names no picture of the capture; give it a file_path"))
            })?;
            let (then, now) = (&capture.cameras[camera], &corrected.cameras[camera]);
            if then != now {
                correct_matrix(entry, then, now, convention).ok_or_else(|| {
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

/// Turns and moves the matrix of an entry, which is meant as `convention` says, as its camera was; `None` where there is no such
/// matrix.
fn correct_matrix(entry: &mut Value, then: &Camera, now: &Camera, convention: PoseConvention) -> Option<()> {
    let rows = entry.get_mut("transform_matrix")?.as_array_mut()?;
    let at = |row: usize, column: usize| rows.get(row)?.get(column)?.as_f64();
    let column = |column: usize| Some(DVec3::new(at(0, column)?, at(1, column)?, at(2, column)?));
    let axes = DMat3::from_cols(column(0)?, column(1)?, column(2)?);
    let pose = convention.world_from_camera(&DAffine3::from_mat3_translation(axes, column(3)?));
    let mut change = now.world_from_camera * then.camera_from_world();
    if pose.matrix3.determinant() < 0.0 {
        // The file's world is left-handed, a mirror image of the capture's.
        change = MIRROR * change * MIRROR;
    }
    let DAffine3 { matrix3: axes, translation } = convention.matrix(&(change * pose));
    for row in 0..3 {
        rows[row] = Value::from(vec![axes.x_axis[row], axes.y_axis[row], axes.z_axis[row], translation[row]]);
    }
    Some(())
}

/// Names the files of an entry so that they are found from another folder.
fn name_from_elsewhere(entry: &mut Value, folder: &Path) {
    const FILES: [&str; 6] = [
        "file_path",
        "depth_file_path",
        "depth_path",
        "confidence_file_path",
        "normal_file_path",
        "mask_path",
    ];
    for key in FILES {
        if let Some(path) = entry.get(key).and_then(Value::as_str) {
            entry[key] = Value::from(folder.join(path).display().to_string());
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;
    use crate::capture::Intrinsics;
    use crate::capture::conventions::{CameraAxes, PoseDirection, upright};

    #[test]
    fn a_matrix_of_any_convention_is_corrected_to_the_pose_that_was_found() {
        let lens = Intrinsics::from_horizontal_angle(8, 6, 1.0);
        let then = Camera::look_at("c", lens, DVec3::new(3.0, -4.0, 2.0), DVec3::ONE, DVec3::Z);
        let mut now = then.clone();
        now.world_from_camera *=
            DAffine3::from_rotation_translation(DQuat::from_rotation_y(0.02), DVec3::new(0.1, 0.0, -0.05));
        for axes in CameraAxes::all() {
            for direction in [PoseDirection::CameraToWorld, PoseDirection::WorldToCamera] {
                let convention = PoseConvention { direction, axes };
                // Files are rotations: where the axes are left-handed, it is the world that mirrors.
                let is_mirrored = !axes.is_right_handed();
                let pose = if is_mirrored { MIRROR * then.world_from_camera } else { then.world_from_camera };
                let rows = |matrix: DAffine3| {
                    let column = |at: usize| {
                        let DAffine3 { matrix3: m, translation } = matrix;
                        vec![m.x_axis[at], m.y_axis[at], m.z_axis[at], translation[at]]
                    };
                    [column(0), column(1), column(2), vec![0.0, 0.0, 0.0, 1.0]]
                };
                let mut entry = serde_json::json!({ "transform_matrix": rows(convention.matrix(&pose)) });
                correct_matrix(&mut entry, &then, &now, convention).unwrap();
                let found: [[f64; 4]; 4] = serde_json::from_value(entry["transform_matrix"].take()).unwrap();
                let column = |at: usize| DVec3::new(found[0][at], found[1][at], found[2][at]);
                let matrix = DAffine3::from_cols(column(0), column(1), column(2), column(3));
                let read = upright(convention.world_from_camera(&matrix));
                assert!(read.abs_diff_eq(now.world_from_camera, 1e-9), "{convention:?}");
            }
        }
    }
}
