//! Writing a capture as EXR pictures and a manifest that [`super::open`] reads.
//!
//! ```text
//! DIR/transforms.json          written last: a folder without it is not yet a capture
//! DIR/CAMERA/0000.exr …        one folder for each camera
//! DIR/novel/transforms.json    vantages, with their true pictures beside it
//! ```

use std::path::{Component, Path};
use std::sync::atomic::{AtomicBool, Ordering};

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use super::manifest_file::MANIFEST_NAME;
use super::pose;
use super::value_keys::ValueKeys;
use crate::capture::camera::{Camera, Intrinsics};
use crate::capture::exr::write_frame;
use crate::capture::frame::Frame;
use crate::capture::parts::{Capture, TruthView};
use crate::capture::values::ValueChannel;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::whole_file;

/// Folder of the vantages below a capture's.
const NOVEL_FOLDER: &str = "novel";

/// The path of a camera's picture at a frame of this number in a capture's folder that we write.
#[must_use]
pub fn picture_name(camera: &Camera, frame_number: i64) -> String {
    format!("{}/{frame_number:04}.exr", camera.name)
}

/// One picture of a manifest to be written.
struct PictureToWrite<'a> {
    /// Where the picture is, relative to the manifest.
    file_path: String,
    camera: &'a Camera,
    frame_number: i64,
}

/// The keys that a manifest has for all its pictures.
#[derive(Clone, Copy)]
struct ManifestFacts<'a> {
    up_in_world: DVec3,
    has_normals: bool,
    antialiased_color: bool,
    values: &'a [ValueChannel],
}

/// A manifest of pictures as [`write_frame`] writes them, in the order of its keys.
#[derive(Serialize)]
struct WrittenManifest<'a> {
    camera_model: &'static str,
    depth_kind: &'static str,
    depth_channel: &'static str,
    depth_miss_value: f64,
    normal_space: Option<&'static str>,
    antialiased_color: bool,
    pixel_center_offset: f64,
    color_space: &'static str,
    up: [f64; 3],
    #[serde(skip_serializing_if = "Vec::is_empty")]
    values: Vec<ValueKeys>,
    frames: Vec<WrittenEntry<'a>>,
}

#[serde_with::skip_serializing_none]
#[derive(Serialize)]
struct WrittenEntry<'a> {
    file_path: &'a str,
    transform_matrix: Vec<Vec<f64>>,
    camera: &'a str,
    time: f64,
    /// Where it is not the file's.
    camera_model: Option<&'static str>,
    fl_x: f64,
    fl_y: f64,
    cx: f64,
    cy: f64,
    w: f64,
    h: f64,
}

/// The model of cameras whose lines of sight are parallel.
pub(crate) const ORTHOGRAPHIC: &str = "ORTHOGRAPHIC";

/// Writes a manifest, which appears only when it is complete.
fn write_manifest(path: &Path, facts: ManifestFacts<'_>, pictures: &[PictureToWrite]) -> Result<()> {
    let frames = pictures.iter().map(|PictureToWrite { file_path, camera, frame_number }| {
        let Intrinsics { width, height, fx, fy, cx, cy, .. } = camera.intrinsics;
        WrittenEntry {
            file_path,
            transform_matrix: pose::opengl_matrix(&camera.world_from_camera),
            camera: &camera.name,
            time: *frame_number as f64,
            camera_model: camera.intrinsics.is_orthographic().then_some(ORTHOGRAPHIC),
            fl_x: fx,
            fl_y: fy,
            cx,
            cy,
            w: f64::from(width),
            h: f64::from(height),
        }
    });
    let manifest = WrittenManifest {
        camera_model: "PINHOLE",
        depth_kind: "planar_z",
        depth_channel: "Z",
        depth_miss_value: 1e10,
        normal_space: facts.has_normals.then_some("world"),
        antialiased_color: facts.antialiased_color,
        pixel_center_offset: 0.5,
        color_space: "linear Rec.709, scene referred",
        up: facts.up_in_world.to_array(),
        values: facts.values.iter().map(ValueKeys::of_written).collect(),
        frames: frames.collect(),
    };
    whole_file::write(path, |writer| {
        serde_json::to_writer_pretty(writer, &manifest)
            .map_err(|error| Error::io(path, std::io::Error::from(error)))
    })
}

/// Writes a manifest of cameras at one frame, whose pictures are still to be made: where each is to lie, and how its depth is meant.
///
/// # Errors
/// `Io`.
pub fn write_cameras(path: &Path, cameras: &[Camera], frame_number: i64, up_in_world: DVec3) -> Result<()> {
    let entries: Vec<PictureToWrite> = cameras
        .iter()
        .map(|camera| PictureToWrite { file_path: picture_name(camera, frame_number), camera, frame_number })
        .collect();
    let facts = ManifestFacts { up_in_world, has_normals: true, antialiased_color: true, values: &[] };
    write_manifest(path, facts, &entries)
}

/// Writes every frame of a capture, and the vantages with their true pictures, below `folder`.
///
/// Progress is counted in pictures; cancelling stops before the next one, and leaves no manifest: one that was there before is
/// taken away first.
///
/// # Errors
/// `Io` where something cannot be written, whatever loading a frame gives, `Invalid` for names that are no paths below
/// `folder`, and [`Error::Cancelled`].
pub fn write_capture(folder: &Path, capture: &Capture, views: &[TruthView], job: &Job) -> Result<()> {
    let frame_count = capture.frame_count();
    let truths = views.iter().filter(|view| view.truth.is_some()).count();
    job.start("writing pictures", capture.cameras.len() * frame_count + truths);
    let entries = capture_entries(capture);
    for entry in &entries {
        create_folder_of(folder, &entry.file_path)?;
    }
    // Pictures of one recording must never be left beside the manifest of another.
    for manifest in [folder.join(MANIFEST_NAME), folder.join(NOVEL_FOLDER).join(MANIFEST_NAME)] {
        remove_if_there(&manifest)?;
    }
    entries.par_iter().enumerate().try_for_each(|(index, entry)| {
        job.check()?;
        let frame = capture.frame(index / frame_count, index % frame_count)?;
        write_frame(&folder.join(&entry.file_path), &frame, capture.value_channels())?;
        job.advance(1);
        Ok(())
    })?;
    let facts = ManifestFacts {
        up_in_world: capture.up_in_world,
        has_normals: capture.has_normals,
        antialiased_color: capture.antialiased_color,
        values: capture.value_channels(),
    };
    if !views.is_empty() {
        write_views(&folder.join(NOVEL_FOLDER), views, facts, job)?;
    }
    write_manifest(&folder.join(MANIFEST_NAME), facts, &entries)
}

fn remove_if_there(path: &Path) -> Result<()> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(Error::io(path, error)),
        _ => Ok(()),
    }
}

fn capture_entries(capture: &Capture) -> Vec<PictureToWrite<'_>> {
    let of_camera = |camera| {
        capture.frame_numbers.iter().map(move |&frame_number| PictureToWrite {
            file_path: picture_name(camera, frame_number),
            camera,
            frame_number,
        })
    };
    capture.cameras.iter().flat_map(of_camera).collect()
}

fn write_views(folder: &Path, views: &[TruthView], facts: ManifestFacts<'_>, job: &Job) -> Result<()> {
    let entries: Vec<PictureToWrite> = views
        .iter()
        .map(|view| PictureToWrite {
            file_path: Path::new(&view.file_path).with_extension("exr").to_string_lossy().into_owned(),
            camera: &view.camera,
            frame_number: view.frame_number,
        })
        .collect();
    std::fs::create_dir_all(folder).map_err(|error| Error::io(folder, error))?;
    for entry in &entries {
        create_folder_of(folder, &entry.file_path)?;
    }
    let all_have_normals = AtomicBool::new(true);
    views.par_iter().zip(&entries).try_for_each(|(view, entry)| {
        job.check()?;
        let Some(truth) = &view.truth else { return Ok(()) };
        let frame: Frame = truth()?;
        if frame.normal_in_world.is_none() {
            all_have_normals.store(false, Ordering::Relaxed);
        }
        write_frame(&folder.join(&entry.file_path), &frame, &[])?;
        job.advance(1);
        Ok(())
    })?;
    let facts = ManifestFacts { has_normals: all_have_normals.into_inner(), values: &[], ..facts };
    write_manifest(&folder.join(MANIFEST_NAME), facts, &entries)
}

/// Makes the folder of a picture, which must be below `folder` whatever a camera is called.
fn create_folder_of(folder: &Path, file_path: &str) -> Result<()> {
    let is_below = Path::new(file_path)
        .components()
        .all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
    if !is_below {
        let what = format!("'{file_path}' is no path below this folder; rename the camera or the picture");
        return Err(Error::invalid(folder.display(), what));
    }
    let path = folder.join(file_path);
    let parent = path.parent().unwrap_or(folder);
    std::fs::create_dir_all(parent).map_err(|error| Error::io(parent, error))
}
