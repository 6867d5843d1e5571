//! `overlook align`: what the rig got wrong, and poses without it.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use glam::{DAffine3, DMat3, DVec3};
use serde::Serialize;
use serde_json::{Value, json};

use crate::cli::input::{self, SettingsArgs};
use crate::cli::output::{self, CommandError};
use overlook_engine::alignment::{self, Aligned, AlignedLens, Alignment};
use overlook_engine::capture::conventions::{MIRROR, PoseConvention};
use overlook_engine::capture::pictures::depth_size;
use overlook_engine::capture::transforms::manifest_path;
use overlook_engine::capture::{Camera, Capture, Intrinsics};
use overlook_engine::error::{Error, Result};
use overlook_engine::settings::{AlignSettings, Settings};
use overlook_engine::whole_file;
use overlook_lab::truth::ViewCorrections;

#[derive(Debug, Args)]
pub(crate) struct AlignArgs {
    /// The capture: a folder or its transforms.json.
    capture: PathBuf,
    /// File for a manifest of the same pictures with the corrected poses and color lenses, for other programs. It names pictures
    /// relative to the capture's own manifest. Color and depth have a lens each if they differ.
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
    /// `None` if no correction pays.
    alignment: Option<&'a Alignment>,
    /// The corrections of views beside the capture; `None` if nothing is predicted.
    #[serde(skip_serializing_if = "Option::is_none")]
    views: Option<&'a ViewCorrections<'a>>,
    seconds: f64,
}

impl AlignArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        let settings = self.settings.over(Settings::default())?;
        if settings.align == AlignSettings::OFF {
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
        let Aligned { capture: corrected, alignment, .. } =
            output::watched(|job| alignment::align(&capture, &settings.align, job))?;
        let seconds = started.elapsed().as_secs_f64();
        if let Some(out) = &self.out {
            let lenses = alignment.as_ref().map_or(&[][..], |alignment| &alignment.lenses);
            self.write(&capture, &corrected, lenses, out)?;
        }
        let views = alignment.as_ref().map(ViewCorrections::of);
        let of_views = views.as_ref().and_then(ViewCorrections::sentence);
        if self.json {
            let views = views.as_ref().filter(|_| of_views.is_some());
            return output::print_json(&AlignOutput { alignment: alignment.as_ref(), views, seconds });
        }
        let mut lines = alignment.as_ref().map_or_else(Vec::new, Alignment::sentences);
        let refused = alignment.as_ref().map_or_else(Vec::new, Alignment::refusals);
        lines.extend(refused.iter().map(|line| format!("not corrected: {line}")));
        let measured = alignment.as_ref().map_or(&[][..], |alignment| &alignment.measured);
        lines.extend(measured.iter().map(|line| format!("measured: {line}")));
        if lines.is_empty() {
            let line =
                "Nothing to correct: no change makes cameras agree better by more than its standard error";
            lines.push(line.to_owned());
        }
        lines.extend(of_views);
        lines.extend(self.out.iter().map(|out| format!("Wrote {}", out.display())));
        output::print(&lines.join("\n"))
    }

    /// Writes the capture's manifest with other poses and color lenses, and all else as it is.
    fn write(
        &self,
        capture: &Capture,
        corrected: &Capture,
        lenses: &[AlignedLens],
        out: &Path,
    ) -> Result<()> {
        let manifest = manifest_path(&self.capture);
        let place = manifest.display();
        let text = std::fs::read_to_string(&manifest).map_err(|error| Error::io(&manifest, error))?;
        let invalid = |what: String| Error::invalid(&place, what);
        let mut json: Value = serde_json::from_str(&text).map_err(|error| invalid(error.to_string()))?;
        let folder = manifest.parent().unwrap_or(Path::new(""));
        let is_beside = absolute(out)?.parent() == absolute(&manifest)?.parent();
        let convention = capture.source.pose_convention();
        let shared = ManifestDefaults::of(&json);
        let entries = json.get_mut("frames").and_then(Value::as_array_mut);
        for (index, entry) in entries.into_iter().flatten().enumerate() {
            let camera = camera_of(entry, capture, folder).ok_or_else(|| {
                invalid(format!("entry {index} names no picture of the capture; give it a file_path"))
            })?;
            let (then, now) = (&capture.cameras[camera], &corrected.cameras[camera]);
            let no_matrix = || invalid(format!("entry {index} has no 4×4 transform_matrix; give it one"));
            if let Some(lens) = lenses.iter().find(|lens| lens.claimed == then.intrinsics) {
                let size = depth_size_of(entry, folder, lens)?;
                correct_lens(entry, &shared, [then, now], lens, size, convention).ok_or_else(no_matrix)?;
            } else if then != now {
                correct_matrix(entry, then, now, convention).ok_or_else(no_matrix)?;
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

/// Moves the matrix of an entry, which is in `convention`, by the change from `then` to `now`; `None` without such a matrix.
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

/// Values of a manifest for all entries without their own.
struct ManifestDefaults {
    depth_camera: Option<Value>,
    pixel_center_offset: Option<f64>,
}

impl ManifestDefaults {
    fn of(manifest: &Value) -> Self {
        Self {
            depth_camera: manifest.get("depth_camera").cloned(),
            pixel_center_offset: manifest.get("pixel_center_offset").and_then(Value::as_f64),
        }
    }
}

/// Columns and rows of the depth of an entry; those of its color if one file holds both.
fn depth_size_of(entry: &Value, folder: &Path, lens: &AlignedLens) -> Result<(usize, usize)> {
    let named = ["depth_file_path", "depth_path"].iter().find_map(|key| entry.get(key)?.as_str());
    let is_apart = |path: &PathBuf| path.extension().is_some_and(|extension| extension != "exr");
    match named.map(|name| folder.join(name)).filter(is_apart) {
        // The capture was opened, so that the meaning of its bits is known to be right.
        Some(path) => depth_size(&path, true, &path.display().to_string()),
        None => Ok(lens.claimed.size()),
    }
}

/// Gives an entry the corrected lens and pose of its color, and moves its own to its depth; `None` without a matrix.
fn correct_lens(
    entry: &mut Value,
    shared: &ManifestDefaults,
    [then, now]: [&Camera; 2],
    lens: &AlignedLens,
    depth_size: (usize, usize),
    convention: PoseConvention,
) -> Option<()> {
    let mut depth_now = now.clone();
    depth_now.world_from_camera *= lens.color_from_depth;
    let known = entry.get("depth_camera").or(shared.depth_camera.as_ref()).filter(|known| known.is_object());
    let mut depth_camera = known.cloned().unwrap_or_else(|| {
        let (width, height) = lens.claimed.size();
        let [x, y] = [depth_size.0 as f64 / width as f64, depth_size.1 as f64 / height as f64];
        let Intrinsics { fx, fy, cx, cy, .. } = lens.claimed;
        json!({ "fl_x": fx * x, "fl_y": fy * y, "cx": cx * x, "cy": cy * y, "pixel_center_offset": 0.5 })
    });
    if depth_camera.get("transform_matrix").is_none() {
        depth_camera["transform_matrix"] = entry.get("transform_matrix")?.clone();
    }
    correct_matrix(&mut depth_camera, then, &depth_now, convention)?;
    correct_matrix(entry, then, now, convention)?;
    let own_offset = entry.get("pixel_center_offset").and_then(Value::as_f64);
    let shift = own_offset.or(shared.pixel_center_offset).unwrap_or(0.5) - 0.5;
    let Intrinsics { fx, fy, cx, cy, .. } = lens.color;
    for (key, value) in [("fl_x", fx), ("fl_y", fy), ("cx", cx + shift), ("cy", cy + shift)] {
        entry[key] = Value::from(value);
    }
    entry["depth_camera"] = depth_camera;
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
    use overlook_engine::capture::Intrinsics;
    use overlook_engine::capture::conventions::{CameraAxes, PoseDirection, upright};

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

    #[test]
    fn an_entry_whose_color_has_a_lens_of_its_own_gets_it_and_a_depth_camera_that_stays_where_it_was() {
        let claimed = Intrinsics::from_horizontal_angle(8, 6, 1.0);
        let then = Camera::look_at("c", claimed, DVec3::new(3.0, -4.0, 2.0), DVec3::ONE, DVec3::Z);
        let color_from_depth = DAffine3::from_translation(DVec3::new(-0.025, 0.0, 0.0));
        let color = Intrinsics { fx: 6.0, fy: 6.0, cx: 4.25, ..claimed };
        let lens = AlignedLens {
            claimed,
            color,
            color_from_depth,
            focal_se: 0.0,
            principal_point_se: None,
            degrees: 0.0,
            degrees_se: None,
            distance: 0.025,
            distance_se: None,
            moved_px: 1.0,
            loss_before: 1.0,
            loss_after: 0.0,
            loss_se: 0.0,
        };
        let mut now = Camera { intrinsics: color, ..then.clone() };
        now.world_from_camera *= color_from_depth.inverse();
        let convention = PoseConvention::default();
        let rows = |pose: &DAffine3| {
            let DAffine3 { matrix3: m, translation: t } = convention.matrix(pose);
            [0, 1, 2].map(|row: usize| [m.x_axis[row], m.y_axis[row], m.z_axis[row], t[row]])
        };
        let mut entry = json!({ "transform_matrix": rows(&then.world_from_camera), "fl_x": claimed.fx });
        let shared = ManifestDefaults { depth_camera: None, pixel_center_offset: Some(0.0) };
        correct_lens(&mut entry, &shared, [&then, &now], &lens, (16, 12), convention).unwrap();
        assert_eq!(
            [&entry["fl_x"], &entry["fl_y"], &entry["cx"]].map(Value::as_f64),
            [6.0, 6.0, 3.75].map(Some)
        );
        let depth = &entry["depth_camera"];
        assert_eq!([&depth["fl_x"], &depth["cx"]].map(Value::as_f64), [2.0 * claimed.fx, 8.0].map(Some));
        for (matrix, pose) in [(&entry, &now.world_from_camera), (depth, &then.world_from_camera)] {
            for (row, expected) in rows(pose).iter().enumerate() {
                for (column, expected) in expected.iter().enumerate() {
                    let found = matrix["transform_matrix"][row][column].as_f64().unwrap();
                    assert!(
                        (found - expected).abs() < 1e-9,
                        "row {row}, column {column}: {found} {expected}"
                    );
                }
            }
        }
    }
}
