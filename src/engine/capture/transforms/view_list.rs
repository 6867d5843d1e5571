//! Lists of viewpoints as programs write them, as manifests.
//!
//! | program | file | what it holds |
//! |---|---|---|
//! | nerfstudio, instant-ngp, Overlook | `transforms.json` | see [`manifest`](super::manifest) |
//! | nerfstudio's viewer | `camera_path.json` | every picture of a film: `camera_to_world` row by row (OpenGL's axes), vertical `fov` in degrees |
//! | 3D Gaussian Splatting | `cameras.json` | `position` and `rotation`, camera to world (x right, y down, z forward), `fx` and `fy` in pixels |
//! | COLMAP | `images.txt` or `images.bin` beside `cameras`, also in `sparse/0` | see [`colmap`](crate::capture::colmap) |

use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DVec3};
use serde::Deserialize;
use serde_json::Value;

use super::colmap_keys::keys_of_colmap;
use super::manifest::{Keys, Manifest, PictureEntry};
use super::manifest_file::{MANIFEST_NAME, manifest_path, plain};
use super::pose::opengl_matrix;
use crate::capture::colmap;
use crate::capture::pictures::PictureRows;
use crate::error::{Error, Result};
use crate::whole_file;

/// A list of viewpoints.
pub(super) struct ViewList {
    /// One entry a viewpoint.
    pub manifest: Manifest,
    /// The file that was read.
    pub path: PathBuf,
    /// Whether it has every picture of a film, whatever its frames.
    pub is_film: bool,
}

impl ViewList {
    /// Reads a list: a file, or a folder that holds one.
    ///
    /// # Errors
    /// `Io`, `Invalid`, `Unsupported`: what, where, what to do.
    pub(super) fn read(path: &Path) -> Result<Self> {
        if let Some([cameras, images]) = model_at(path) {
            let manifest = of_colmap(&cameras, &images)?;
            return Ok(Self { manifest, path: images, is_film: false });
        }
        let path = manifest_path(path);
        let (manifest, is_film) = from_json(&Manifest::bytes(&path)?, &path.display().to_string())?;
        Ok(Self { manifest, path, is_film })
    }
}

/// The list in a text, and whether it has every picture of a film.
///
/// # Errors
/// `Invalid` for another text than one of these lists, `Unsupported` for cameras that are no pinholes.
pub(super) fn from_json(bytes: &[u8], place: &str) -> Result<(Manifest, bool)> {
    let document: Option<Value> = serde_json::from_slice(&plain(bytes)).ok();
    match &document {
        Some(Value::Object(keys)) if keys.contains_key("camera_path") => {
            of_viewer(bytes, place).map(|manifest| (manifest, true))
        }
        Some(Value::Array(list)) if list.first().is_some_and(|first| first.get("position").is_some()) => {
            of_splats(bytes, place).map(|manifest| (manifest, false))
        }
        _ => {
            let manifest = Manifest::from_json(bytes, place)?;
            let is_film = manifest.frames.len() > 1 && manifest.frames.iter().any(|entry| entry.path_key);
            Ok((manifest, is_film))
        }
    }
}

/// A film of nerfstudio's viewer.
#[derive(Deserialize)]
struct ViewerPath {
    #[serde(default)]
    camera_type: Option<String>,
    render_height: f64,
    render_width: f64,
    camera_path: Vec<ViewerCamera>,
}

#[derive(Deserialize)]
struct ViewerCamera {
    camera_to_world: Vec<f64>,
    /// Vertical, degrees.
    fov: f64,
}

fn of_viewer(bytes: &[u8], place: &str) -> Result<Manifest> {
    let path: ViewerPath = parsed(bytes, "camera path of nerfstudio's viewer", place)?;
    let kind = path.camera_type.as_deref().unwrap_or("perspective");
    if kind != "perspective" {
        let what = format!("camera_type is '{kind}'; views are perspective: export the path so");
        return Err(Error::unsupported(place, what));
    }
    let entry = |(index, camera): (usize, &ViewerCamera)| PictureEntry {
        file_path: format!("{:04}.png", index + 1),
        transform_matrix: camera.camera_to_world.chunks(4).map(<[f64]>::to_vec).collect(),
        keys: Keys { y_fov: Some(camera.fov), ..Keys::default() },
        ..PictureEntry::default()
    };
    let frames = path.camera_path.iter().enumerate().map(entry).collect();
    let keys = Keys { w: Some(path.render_width), h: Some(path.render_height), ..Keys::default() };
    not_empty(Manifest { keys, frames, path_easing: None }, place)
}

/// A camera beside trained splats.
#[derive(Deserialize)]
struct SplatCamera {
    #[serde(default)]
    img_name: Option<String>,
    width: f64,
    height: f64,
    fx: f64,
    fy: f64,
    position: [f64; 3],
    /// Row by row.
    rotation: [[f64; 3]; 3],
}

fn of_splats(bytes: &[u8], place: &str) -> Result<Manifest> {
    let cameras: Vec<SplatCamera> = parsed(bytes, "cameras.json of Gaussian splats", place)?;
    let entry = |(index, camera): (usize, &SplatCamera)| {
        let [x, y, z] = camera.rotation.map(DVec3::from);
        let rotation = DMat3::from_cols(x, y, z).transpose();
        let pose = DAffine3::from_mat3_translation(rotation, DVec3::from(camera.position));
        PictureEntry {
            file_path: camera.img_name.clone().unwrap_or_else(|| format!("{:04}.png", index + 1)),
            transform_matrix: opengl_matrix(&pose),
            keys: Keys {
                w: Some(camera.width),
                h: Some(camera.height),
                fl_x: Some(camera.fx),
                fl_y: Some(camera.fy),
                ..Keys::default()
            },
            ..PictureEntry::default()
        }
    };
    let frames = cameras.iter().enumerate().map(entry).collect();
    not_empty(Manifest { frames, ..Manifest::default() }, place)
}

fn parsed<T: serde::de::DeserializeOwned>(bytes: &[u8], what: &str, place: &str) -> Result<T> {
    serde_json::from_slice(&plain(bytes))
        .map_err(|error| Error::invalid(place, format!("damaged, or no {what} ({error}); write it again")))
}

fn not_empty(manifest: Manifest, place: &str) -> Result<Manifest> {
    if manifest.frames.is_empty() {
        return Err(Error::invalid(place, "lists no camera; write it again"));
    }
    Ok(manifest)
}

/// The files of cameras and images of a COLMAP model at a path: a folder, one that holds it, or one of the two files. A folder with a
/// manifest is no model.
fn model_at(path: &Path) -> Option<[PathBuf; 2]> {
    let names = |ending: &str| ["cameras", "images"].map(|name| format!("{name}.{ending}"));
    let folders = if path.is_dir() {
        if path.join(MANIFEST_NAME).exists() {
            return None;
        }
        ["", "sparse", "sparse/0"].map(|within| path.join(within)).to_vec()
    } else {
        let name = path.file_name()?.to_string_lossy().into_owned();
        if !["bin", "txt"].iter().any(|ending| names(ending).contains(&name)) {
            return None;
        }
        vec![path.parent()?.to_path_buf()]
    };
    let models =
        folders.iter().flat_map(|folder| ["bin", "txt"].map(|it| names(it).map(|name| folder.join(name))));
    models.into_iter().find(|files| files.iter().all(|file| file.is_file()))
}

fn of_colmap(cameras: &Path, images: &Path) -> Result<Manifest> {
    let bytes = [whole_file::read_all(cameras)?, whole_file::read_all(images)?];
    let places = [cameras, images].map(|path| path.display().to_string());
    let (lenses, mut images) = if images.extension().is_some_and(|ending| ending == "bin") {
        (colmap::cameras_of_bytes(&bytes[0], &places[0])?, colmap::images_of_bytes(&bytes[1], &places[1])?)
    } else {
        let text = bytes.each_ref().map(|bytes| String::from_utf8_lossy(bytes));
        (colmap::cameras_of_text(&text[0], &places[0])?, colmap::images_of_text(&text[1], &places[1])?)
    };
    images.sort_by(|a, b| a.name.cmp(&b.name));
    let entry = |image: &colmap::ColmapImage| {
        let lens = lenses.iter().find(|lens| lens.id == image.camera);
        let (Some(lens), Some(pose)) = (lens, image.world_from_camera()) else {
            let what = format!("image '{}' has no camera or no pose; write the model again", image.name);
            return Err(Error::invalid(&places[1], what));
        };
        Ok(PictureEntry {
            file_path: image.name.clone(),
            transform_matrix: opengl_matrix(&pose),
            keys: keys_of_colmap(lens, cameras)?,
            ..PictureEntry::default()
        })
    };
    let frames = images.iter().map(entry).collect::<Result<_>>()?;
    let keys = Keys { picture_orientation: Some(PictureRows::AsStored), ..Keys::default() };
    not_empty(Manifest { keys, frames, path_easing: None }, &places[1])
}
