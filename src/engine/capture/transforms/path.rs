//! Camera paths as manifests: one entry for each picture of a path, so that `render --views` renders it, with its keys marked.
//!
//! ```text
//! {"up": …, "frames": [{"file_path": "path/0001.exr", "transform_matrix": …, "fl_x": …, "frame": 1, "path_key": true}, …]}
//! ```
//!
//! A manifest of another program has no keys marked; each of its entries is one. Entries may say when the camera is there (`path_time`,
//! seconds) and how it goes on from there (`path_easing`). At the top, `path_easing` says so of the path as a whole: the pictures of a
//! saved path go at an even pace, and whoever films them eases.

use std::path::Path;

use glam::DVec3;
use serde::Serialize;

use super::manifest::{Manifest, PictureEntry};
use super::view_list::{self, ViewList};
use super::write::ORTHOGRAPHIC;
use super::{frame_numbers, header_probe, intrinsics, pose};
use crate::capture::camera::{Camera, Intrinsics};
use crate::capture::pose_convention::upright;
use crate::error::{Error, Result};
use crate::settings::choice::choice;

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
    /// When the camera is at each view, in seconds of the film, increasing; `None` where the file does not say.
    pub seconds: Option<Vec<f64>>,
    /// How the camera goes from each view to the next.
    pub easings: Vec<Easing>,
    /// How it sets off and arrives over the whole path.
    pub easing: Easing,
}

choice! {
    /// How a camera sets off and arrives.
    pub enum Easing {
        /// At an even pace.
        Linear = "linear",
        /// It sets off slowly.
        In = "in",
        /// It arrives slowly.
        Out = "out",
        /// It sets off and arrives slowly.
        InOut = "in-out",
    }
}

impl Easing {
    /// The share of the way that is done after a share of the time, both from 0 to 1.
    #[must_use]
    pub fn way(self, time: f64) -> f64 {
        match self {
            Self::Linear => time,
            Self::In => time * time,
            Self::Out => time * (2.0 - time),
            Self::InOut => time * time * (3.0 - 2.0 * time),
        }
    }
}

#[serde_with::skip_serializing_none]
#[derive(Serialize)]
struct WrittenPath {
    camera_model: &'static str,
    pixel_center_offset: f64,
    up: [f64; 3],
    path_easing: Option<String>,
    frames: Vec<WrittenView>,
}

#[serde_with::skip_serializing_none]
#[derive(Serialize)]
struct WrittenView {
    file_path: String,
    transform_matrix: Vec<Vec<f64>>,
    frame: i64,
    /// Where it is not the file's.
    camera_model: Option<&'static str>,
    fl_x: f64,
    fl_y: f64,
    cx: f64,
    cy: f64,
    w: u32,
    h: u32,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    path_key: bool,
}

/// A manifest of the pictures of a path, as JSON. They go at an even pace; `easing` is for who films them.
///
/// # Errors
/// `Invalid` where a pose or a lens holds numbers that are not finite.
pub fn path_to_json(up_in_world: DVec3, views: &[PathView], easing: Easing) -> Result<String> {
    let written = views.iter().enumerate().map(|(index, view)| {
        let Intrinsics { width, height, fx, fy, cx, cy, .. } = view.camera.intrinsics;
        WrittenView {
            file_path: format!("path/{:04}.exr", index + 1),
            transform_matrix: pose::opengl_matrix(&view.camera.world_from_camera),
            frame: view.frame_number,
            camera_model: view.camera.intrinsics.is_orthographic().then_some(ORTHOGRAPHIC),
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
        path_easing: (easing != Easing::Linear).then(|| easing.to_string()),
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
    let seconds = seconds_of(&list.manifest, &list.path)?;
    let easings = easings_of(&list.manifest, &list.path)?;
    let easing = easing_of(list.manifest.path_easing.as_deref(), || list.path.display().to_string())?;
    Ok(PathFile { views, is_film: list.is_film, names_frames, seconds, easings, easing })
}

/// When the camera is at each view, if the file says it.
fn seconds_of(manifest: &Manifest, place: &Path) -> Result<Option<Vec<f64>>> {
    let told: Vec<f64> = manifest.frames.iter().filter_map(|entry| entry.path_time).collect();
    if told.is_empty() {
        return Ok(None);
    }
    let refuse = |what: &str| Err(Error::invalid(place.display(), what));
    if told.len() < manifest.frames.len() {
        return refuse(
            "has \"path_time\" in some entries only; give every view of the path its time, or none",
        );
    }
    if !told.iter().all(|seconds| seconds.is_finite()) || told.windows(2).any(|pair| pair[0] >= pair[1]) {
        return refuse("its \"path_time\" must be seconds that increase from view to view");
    }
    Ok(Some(told))
}

fn easings_of(manifest: &Manifest, place: &Path) -> Result<Vec<Easing>> {
    let easing = |(index, entry): (usize, &PictureEntry)| {
        easing_of(entry.path_easing.as_deref(), || format!("{}, frames[{index}]", place.display()))
    };
    manifest.frames.iter().enumerate().map(easing).collect()
}

fn easing_of(told: Option<&str>, place: impl FnOnce() -> String) -> Result<Easing> {
    let easing = told.map_or(Ok(Easing::Linear), str::parse);
    easing.map_err(|what| Error::invalid(place(), format!("path_easing {what}")))
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
        let lens = Intrinsics { fy: 71.25, cx: 31.0, cy: 25.5, ..Intrinsics::centered(64, 48, 70.5) };
        let camera = Camera::look_at("path", lens, DVec3::new(x, -5.0, 1.0), DVec3::ZERO, DVec3::Z);
        PathView { camera, frame_number, is_key }
    }

    #[test]
    fn a_path_comes_back_as_it_was_written_and_one_without_keys_has_a_key_everywhere() {
        let views = [view(0.0, 3, true), view(0.5, 4, false), view(1.0, 5, true)];
        let text = path_to_json(DVec3::Z, &views, Easing::Linear).unwrap();
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
    fn how_a_path_is_eased_as_a_whole_is_in_its_file() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("path.json");
        let views = [view(0.0, 3, true), view(1.0, 5, true)];
        for &easing in Easing::ALL {
            std::fs::write(&file, path_to_json(DVec3::Z, &views, easing).unwrap()).unwrap();
            assert_eq!(open_path(&file, false).unwrap().easing, easing);
        }
        let text = path_to_json(DVec3::Z, &views, Easing::In).unwrap();
        std::fs::write(&file, text.replace("\"path_easing\": \"in\"", "\"path_easing\": \"bouncy\""))
            .unwrap();
        let error = open_path(&file, false).unwrap_err().to_string();
        assert!(error.contains("path_easing 'bouncy' is not one of linear"), "{error}");
    }

    #[test]
    fn every_easing_leads_from_the_start_to_the_end_and_is_slow_where_it_says() {
        for &easing in Easing::ALL {
            assert_eq!([0.0, 1.0].map(|time| easing.way(time)), [0.0, 1.0]);
            let way: Vec<f64> = (0..=100).map(|step| easing.way(f64::from(step) / 100.0)).collect();
            assert!(way.windows(2).all(|pair| pair[1] > pair[0]), "{easing}");
            let is_slow = |leg: f64| leg < 0.002;
            let slow = [way[1] - way[0], way[100] - way[99]].map(is_slow);
            let expected = match easing {
                Easing::Linear => [false, false],
                Easing::In => [true, false],
                Easing::Out => [false, true],
                Easing::InOut => [true, true],
            };
            assert_eq!(slow, expected, "{easing}");
        }
    }

    #[test]
    fn times_and_easings_of_views_are_read_and_bad_ones_give_one_line() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("path.json");
        let read = |[first, second]: [&str; 2]| {
            let entry = |more: &str| {
                format!(
                    r#"{{"file_path": "a", "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]{more}}}"#
                )
            };
            let text =
                format!(r#"{{"w": 4, "h": 4, "fl_x": 5, "frames": [{}, {}]}}"#, entry(first), entry(second));
            std::fs::write(&file, text).unwrap();
            open_path(&file, false).map_err(|error| error.to_string())
        };
        let eased = read([r#", "path_time": 0.5, "path_easing": "in-out""#, r#", "path_time": 2"#]).unwrap();
        assert_eq!(
            (eased.seconds, eased.easings),
            (Some(vec![0.5, 2.0]), vec![Easing::InOut, Easing::Linear])
        );
        let plain = read(["", ""]).unwrap();
        assert_eq!((plain.seconds, plain.easings), (None, vec![Easing::Linear; 2]));
        for (entries, why) in [
            ([r#", "path_time": 1"#, ""], "some entries only"),
            ([r#", "path_time": 1"#, r#", "path_time": 1"#], "increase"),
            ([r#", "path_easing": "bouncy""#, ""], "path_easing 'bouncy' is not one of linear"),
        ] {
            let error = read(entries).unwrap_err();
            assert!(error.contains(why) && !error.contains('\n'), "{error}");
        }
    }

    #[test]
    fn what_is_no_path_gives_one_line_that_says_why() {
        let no_size = r#"{"frames": [{"file_path": "a", "fl_x": 5,
            "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]}"#;
        for (text, why) in [("", "holds no JSON"), ("hello", "holds no JSON"), (no_size, "\"w\" and \"h\"")] {
            let error = path_from_json(text.as_bytes(), Path::new("clipboard")).unwrap_err().to_string();
            assert!(
                error.starts_with("clipboard") && error.contains(why) && !error.contains('\n'),
                "{error}"
            );
        }
    }
}
