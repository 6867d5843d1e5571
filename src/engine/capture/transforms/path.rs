//! Camera paths as manifests: one entry for each picture of a path, so that `render --views` renders it, with its keys marked.
//!
//! ```text
//! {"up": …, "frames": [{"file_path": "path/0001.exr", "transform_matrix": …, "fl_x": …, "frame": 1, "path_key": true}, …]}
//! ```
//!
//! A manifest of another program has no keys marked; each of its entries is one.

use std::path::Path;

use glam::DVec3;
use serde::Serialize;

use super::manifest::{Manifest, PictureEntry};
use super::view_list::{self, ViewList};
use super::{frame_numbers, header_probe, intrinsics, pose};
use crate::capture::camera::{Camera, Intrinsics};
use crate::capture::pose_convention::upright;
use crate::error::{Error, Result};

/// One picture of a camera path.
#[derive(Clone, Debug, PartialEq)]
pub struct PathView {
    /// The camera's pose and lens.
    pub camera: Camera,
    /// Number of the frame that it sees.
    pub frame_number: i64,
    /// Whether the path has a key here.
    pub is_key: bool,
}

/// A camera path in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct PathFile {
    /// Its views, in the file's order.
    pub views: Vec<PathView>,
    /// Whether these are all pictures of a film, and not places between which a camera moves.
    pub is_film: bool,
    /// Whether it says which frame each view sees. If not, their numbers are 0.
    pub names_frames: bool,
}

#[derive(Serialize)]
struct WrittenPath {
    camera_model: &'static str,
    pixel_center_offset: f64,
    up: [f64; 3],
    frames: Vec<WrittenView>,
}

#[derive(Serialize)]
struct WrittenView {
    file_path: String,
    transform_matrix: Vec<Vec<f64>>,
    frame: i64,
    fl_x: f64,
    fl_y: f64,
    cx: f64,
    cy: f64,
    w: u32,
    h: u32,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    path_key: bool,
}

/// A manifest of the pictures of a path, as JSON.
///
/// # Errors
/// `Invalid` where a pose or a lens holds numbers that are not finite.
pub fn path_to_json(up_in_world: DVec3, views: &[PathView]) -> Result<String> {
    let written = views.iter().enumerate().map(|(index, view)| {
        let Intrinsics { width, height, fx, fy, cx, cy } = view.camera.intrinsics;
        WrittenView {
            file_path: format!("path/{:04}.exr", index + 1),
            transform_matrix: pose::opengl_matrix(&view.camera.world_from_camera),
            frame: view.frame_number,
            fl_x: fx,
            fl_y: fy,
            cx,
            cy,
            w: width,
            h: height,
            path_key: view.is_key,
        }
    });
    let path = WrittenPath {
        camera_model: "PINHOLE",
        pixel_center_offset: 0.5,
        up: up_in_world.to_array(),
        frames: written.collect(),
    };
    serde_json::to_string_pretty(&path).map_err(|error| Error::invalid("camera path", error.to_string()))
}

/// Reads a camera path from a file, or the one in a folder, of any program that lists viewpoints: a manifest, nerfstudio's
/// `camera_path.json`, the `cameras.json` of Gaussian splats, or a COLMAP model. `frames_are_ranked`: see
/// [`open_views_of`](super::open_views_of).
///
/// # Errors
/// `Io`, and as [`path_from_json`].
pub fn open_path(path: &Path, frames_are_ranked: bool) -> Result<PathFile> {
    let list = ViewList::read(path)?;
    frame_numbers::refuse_times(&list.manifest, &list.path, frames_are_ranked)?;
    let names_frame = |entry: &PictureEntry| {
        let keys = entry.keys.clone().or(&list.manifest.keys);
        keys.frame.or(keys.time).is_some()
    };
    let names_frames = list.manifest.frames.iter().all(names_frame);
    let folder = list.path.parent().unwrap_or(Path::new(""));
    let views = views_of(&list.manifest, &list.path, Some(folder))?;
    Ok(PathFile { views, is_film: list.is_film, names_frames })
}

/// The pictures of a path, from a text as [`path_to_json`] or another program wrote it. No file is looked for; `place` is
/// named in errors.
///
/// # Errors
/// `Invalid` for what is no list of views, for a pose or lens that cannot be, for an entry without `w` and `h`, and for a time that
/// is no number of a frame.
pub fn path_from_json(text: &[u8], place: &Path) -> Result<Vec<PathView>> {
    let (manifest, _) = view_list::from_json(text, &place.display().to_string())?;
    frame_numbers::refuse_times(&manifest, place, false)?;
    views_of(&manifest, place, None)
}

/// The views of a list. `folder` has the pictures that tell the size of views whose entries do not.
fn views_of(manifest: &Manifest, place: &Path, folder: Option<&Path>) -> Result<Vec<PathView>> {
    let has_keys = manifest.frames.iter().any(|entry| entry.path_key);
    let view = |(index, entry): (usize, &PictureEntry)| {
        let place = format!("{}, frames[{index}]", place.display());
        let keys = entry.keys.clone().or(&manifest.keys);
        let picture = folder.map(|folder| folder.join(&entry.file_path)).filter(|picture| picture.is_file());
        let size_of_picture = || {
            let without_size = || {
                let what = "has no \"w\" and \"h\"; write the columns and rows of its pictures";
                Error::invalid(&place, what)
            };
            let picture = picture.as_ref().ok_or_else(without_size)?;
            header_probe::picture_size(picture, keys.picture_orientation, None, &place)
        };
        let intrinsics = intrinsics::intrinsics(&keys, size_of_picture, || 1.0, &place)?;
        let world_from_camera =
            upright(pose::world_from_camera(&entry.transform_matrix, keys.pose_convention(), &place)?);
        let frame_number = keys.frame.or(keys.time).unwrap_or(0.0) as i64;
        let camera = Camera { name: "path".to_owned(), intrinsics, world_from_camera };
        Ok(PathView { camera, frame_number, is_key: entry.path_key || !has_keys })
    };
    manifest.frames.iter().enumerate().map(view).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view(x: f64, frame_number: i64, is_key: bool) -> PathView {
        let lens = Intrinsics { width: 64, height: 48, fx: 70.5, fy: 71.25, cx: 31.0, cy: 25.5 };
        let camera = Camera::look_at("path", lens, DVec3::new(x, -5.0, 1.0), DVec3::ZERO, DVec3::Z);
        PathView { camera, frame_number, is_key }
    }

    #[test]
    fn a_path_comes_back_as_it_was_written_and_one_without_keys_has_a_key_everywhere() {
        let views = [view(0.0, 3, true), view(0.5, 4, false), view(1.0, 5, true)];
        let text = path_to_json(DVec3::Z, &views).unwrap();
        let again = path_from_json(text.as_bytes(), Path::new("transforms.json")).unwrap();
        for (before, after) in views.iter().zip(&again) {
            assert_eq!((before.frame_number, before.is_key), (after.frame_number, after.is_key));
            assert_eq!(before.camera.intrinsics, after.camera.intrinsics);
            let apart = before.camera.world_from_camera.matrix3 - after.camera.world_from_camera.matrix3;
            assert!(apart.to_cols_array().iter().all(|apart| apart.abs() < 1e-12));
        }
        let bare = text.replace("\"path_key\": true", "\"other\": 1");
        let bare = path_from_json(bare.as_bytes(), Path::new("transforms.json")).unwrap();
        assert!(bare.iter().all(|view| view.is_key));
    }

    #[test]
    fn what_is_no_path_gives_one_line_that_says_why() {
        let no_size = r#"{"frames": [{"file_path": "a", "fl_x": 5,
            "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]}"#;
        for (text, why) in [("", "not a manifest"), ("hello", "not a manifest"), (no_size, "\"w\" and \"h\"")]
        {
            let error = path_from_json(text.as_bytes(), Path::new("clipboard")).unwrap_err().to_string();
            assert!(
                error.starts_with("clipboard") && error.contains(why) && !error.contains('\n'),
                "{error}"
            );
        }
    }
}
