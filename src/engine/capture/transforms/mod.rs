//! The manifest: `transforms.json` of nerfstudio and instant-ngp, and our superset of it.
//!
//! ```text
//! manifest (JSON) ─ pose (camera space) ─ cameras (who recorded which frame) ─ source (frames on demand)
//!                                                          write: the same, backwards
//! ```
//!
//! Source: nerfstudio's data conventions: `transform_matrix` is camera-to-world with OpenGL's axes (x right, y up,
//! looking along −z), `fl_x fl_y cx cy w h` in pixels, per file or per entry. What differs: `camera` and `time` name a
//! recording by several static cameras, and its own keys (CAPTURES.md lists them) describe how depth and normals are read.
//! Files without them read unchanged: one camera for each distinct pose.

mod cameras;
mod colmap_keys;
mod depth_camera;
mod depth_file;
mod depth_presence;
mod exposure;
mod exr_picture;
mod files;
mod frame_numbers;
mod header_probe;
mod intrinsics;
mod left_out;
mod lens;
mod load;
mod manifest;
mod manifest_file;
mod normal_file;
mod numbers_in_names;
mod other_pictures;
mod path;
mod pictures_by_pose;
mod pictures_of_views;
mod placed_entry;
mod pose;
mod position_depth;
mod raw_video;
mod same_camera;
mod source;
mod turned_pictures;
mod value_file;
mod value_keys;
mod value_places;
mod view_list;
mod write;

pub(crate) use colmap_keys::keys_of_colmap;
pub(crate) use depth_camera::DepthCameraKeys;
pub use files::picture_places;
pub(crate) use files::places_of;
pub(crate) use header_probe::picture_size;
pub(crate) use left_out::is_recording;
pub(crate) use lens::LensKeys;
pub(crate) use manifest::{Keys, Manifest, NormalSpaceName, PictureEntry};
pub use manifest_file::{MANIFEST_NAME, manifest_path, truth_beside};
pub(crate) use manifest_file::{ManifestOrigin, other_file};
pub use other_pictures::{MatchedBy, OtherPictures};
pub use path::{Easing, PathFile, PathView, open_path, path_from_json, path_to_json};
pub use pictures_of_views::open_pictures;
pub(crate) use pose::opengl_matrix;
pub(crate) use raw_video::RawVideoKeys;
pub(crate) use write::ORTHOGRAPHIC;
pub use write::{picture_name, write_cameras, write_capture};

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use super::conventions::{self, ConventionVerdict};
use super::parts::{Capture, CaptureParts, TruthLoader, TruthView, stem_of};
use crate::error::{Error, Result};
use crate::settings::CaptureSettings;
use cameras::CameraFiles;
use load::NeededPlanes;
use source::FileSource;
use view_list::ViewList;

/// Opens a capture: a `transforms.json`, or a folder that holds one.
///
/// Every file is looked for, and the first one of each camera has its header read; pictures are decoded on demand, except
/// for first ones with both depth and positions where the manifest does not decide between them, and for as many as it takes to find
/// one with depth: the first, as a rule.
///
/// # Errors
/// `Io`, `Invalid`, `Unsupported`: what, where, what to do.
pub fn open(path: &Path, settings: &CaptureSettings) -> Result<Capture> {
    let path = manifest_path(path);
    capture_of(&Manifest::read(&path)?, &ManifestOrigin::of_file(&path), settings)
}

/// The capture that a manifest describes, wherever the manifest comes from. Its name is that of the folder.
///
/// # Errors
/// As [`open`].
pub(crate) fn capture_of(
    manifest: &Manifest,
    origin: &ManifestOrigin,
    settings: &CaptureSettings,
) -> Result<Capture> {
    open_manifest(manifest, origin, settings)
        .map_err(|error| mirrored(manifest.clone(), origin, settings).unwrap_or(error))
}

/// The error that names the axes that fit, where all poses of a manifest mirror.
fn mirrored(mut manifest: Manifest, origin: &ManifestOrigin, settings: &CaptureSettings) -> Option<Error> {
    let is_open = manifest.keys.camera_axes.is_none()
        && manifest.frames.iter().all(|entry| entry.keys.camera_axes.is_none());
    if !is_open || !manifest.frames.iter().all(|entry| pose::mirrors(&entry.transform_matrix)) {
        return None;
    }
    // Any left-handed axes serve to compare the views; which ones fit is found so.
    manifest.keys.camera_axes = serde_json::from_str("[\"left\", \"up\", \"back\"]").ok();
    let capture = open_manifest(&manifest, origin, settings).ok()?;
    let found = conventions::check(&capture).ok()?;
    let axes = match &found.verdict {
        ConventionVerdict::Other(_) => found.sentence(),
        ConventionVerdict::Stands { .. } => {
            let axes = manifest.keys.camera_axes.map(conventions::CameraAxes::json);
            format!("the views agree if one writes \"camera_axes\": {}", axes.unwrap_or_default())
        }
        ConventionVerdict::Unknown { .. } => return None,
    };
    let what =
        format!("every transform_matrix mirrors: the axes of its camera space are left-handed; {axes}");
    Some(Error::invalid(origin.path.display(), what))
}

fn open_manifest(
    manifest: &Manifest,
    origin: &ManifestOrigin,
    settings: &CaptureSettings,
) -> Result<Capture> {
    let path = &origin.path;
    let mut recording = CameraFiles::group(manifest, origin)?;
    turned_pictures::decide(&mut recording);
    let probes = recording.probe()?;
    let mut warnings = std::mem::take(&mut recording.warnings);
    let has_normals = source::normals_in_all_cameras(&recording, &probes, &mut warnings);
    position_depth::prefer_to_contradicting_depth(&mut recording, &mut warnings);
    let keys = || recording.entries.iter().flatten().map(|entry| &entry.keys);
    warnings.extend(unknown_color_spaces(keys()));
    warnings.extend(scaled_poses(keys()));
    let up_in_world = up_in_world(keys(), path)?;
    // Renderers filter color unless the manifest denies it.
    let antialiased_color = keys().any(|keys| keys.antialiased_color.unwrap_or(true));
    let values = value_file::channels(&recording, &path.display().to_string())?;
    let is_noise_free = keys().all(|keys| keys.noise_free == Some(true)).then_some(true);
    let noise_free = keys().find_map(|keys| keys.noise_free.filter(|is_free| !is_free)).or(is_noise_free);
    let source = Arc::new(FileSource { recording, has_normals, values, noise_free });
    let recording = &source.recording;
    let capture = Capture::new(
        CaptureParts {
            name: capture_name(origin),
            cameras: recording.cameras.clone(),
            frame_numbers: recording.frame_numbers.clone(),
            up_in_world,
            has_normals,
            antialiased_color,
            warnings,
            source: source.clone(),
        },
        settings.frame_cache_bytes(),
    );
    depth_presence::refuse_without_depth(&capture, &source)?;
    Ok(match exposure::warning(&capture, &source) {
        Some(warning) => capture.with_warning(warning),
        None => capture,
    })
}

/// Reads vantages, and where the pictures exist their truth, from a manifest of the same form, or another list of viewpoints (see
/// [`open_path`]).
///
/// A true picture needs no depth: where none is recorded, every pixel of it counts as a sample at infinity. Views of one camera that
/// differ by no more than a capture's frames may are one vantage.
///
/// # Errors
/// As [`open`], and `Invalid` for times that are fractions: which frame of a capture one of them means is not known here.
pub fn open_views(path: &Path) -> Result<Vec<TruthView>> {
    open_views_of(path, false)
}

/// As [`open_views`], of a capture or a store: where its own times are fractions ([`Capture::frames_are_ranked`]), so that a time
/// of 1 may mean frame 1 or the last one, views have to name the number of their frame as `frame`.
///
/// # Errors
/// As [`open_views`].
pub fn open_views_of(path: &Path, frames_are_ranked: bool) -> Result<Vec<TruthView>> {
    let ViewList { manifest, path, .. } = ViewList::read(path)?;
    frame_numbers::refuse_times(&manifest, &path, frames_are_ranked)?;
    let places = cameras::entries(&manifest, &ManifestOrigin::of_file(&path))?;
    let mut known = Vec::new();
    places
        .into_iter()
        .map(|entry| {
            let camera = same_camera::without_rounding(&mut known, entry.camera()?);
            let truth = entry.files.color.is_file().then(|| {
                let (files, camera, place) = (entry.files.clone(), camera.clone(), entry.place.clone());
                Arc::new(move || load::frame(&files, &camera, &place, NeededPlanes::ColorOnly)) as TruthLoader
            });
            let picture = stem_of(&entry.files.color);
            Ok(TruthView { picture, ..TruthView::new(entry.file_path, camera, entry.number, truth) })
        })
        .collect()
}

/// The name of the capture's folder, or of the manifest itself at the root.
fn capture_name(origin: &ManifestOrigin) -> String {
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let (folder, path) = (absolute(&origin.folder.join(".")), absolute(&origin.path));
    let folder = folder.file_name().or(path.file_stem());
    folder.map_or_else(|| "capture".to_owned(), |name| name.to_string_lossy().into_owned())
}

/// A warning for each color space that is neither ours nor sRGB.
fn unknown_color_spaces<'a>(keys: impl Iterator<Item = &'a Keys>) -> Vec<String> {
    let is_known = |color_space: &str| {
        let lower = color_space.to_ascii_lowercase();
        ["linear", "srgb", "709", "raw"].iter().any(|known| lower.contains(known))
    };
    let given: BTreeSet<&str> = keys.filter_map(|keys| keys.color_space.as_deref()).collect();
    let unknown = given.into_iter().filter(|color_space| !is_known(color_space));
    let warning = |name| format!("color space '{name}' is not converted; colors are taken as linear Rec.709");
    unknown.map(warning).collect()
}

/// A warning if the poses were scaled, and depth may be scaled or not.
fn scaled_poses<'a>(mut keys: impl Iterator<Item = &'a Keys>) -> Option<String> {
    let scale = keys.find_map(|keys| keys.applied_scale.filter(|_| keys.depth_unit_scale_factor.is_none()));
    scale.filter(|scale| *scale != 1.0).map(|scale| {
        format!(
            "the poses are scaled by applied_scale {scale}, and depth is taken in their unit (in PNG files in thousandths of it); give depth_unit_scale_factor where it has another"
        )
    })
}

/// The manifest's `up`, or +z as Blender and nerfstudio have it.
fn up_in_world<'a>(mut keys: impl Iterator<Item = &'a Keys>, path: &Path) -> Result<DVec3> {
    let up = keys.next().and_then(|keys| keys.up);
    if keys.any(|keys| keys.up != up) {
        return Err(Error::invalid(
            path.display(),
            "\"up\" differs between entries; write one for all of them, beside \"frames\"",
        ));
    }
    let Some(up) = up else { return Ok(DVec3::Z) };
    DVec3::from(up).try_normalize().ok_or_else(|| {
        Error::invalid(path.display(), "\"up\" is no direction; write it as three numbers, as in [0, 0, 1]")
    })
}
