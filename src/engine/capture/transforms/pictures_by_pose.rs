//! Pictures that another program made of views, found by their poses in the manifest of their folder.

use std::collections::BTreeSet;
use std::path::Path;

use super::cameras;
use super::manifest::Manifest;
use super::manifest_file::{MANIFEST_NAME, ManifestOrigin};
use super::other_pictures::{MatchedBy, OtherPictures, loader};
use super::placed_entry::PlacedEntry;
use super::{frame_numbers, same_camera};
use crate::capture::camera::Camera;
use crate::capture::parts::TruthView;
use crate::error::Result;

/// The pictures of views in a folder with a manifest.
///
/// # Errors
/// Those of reading the manifest.
pub(super) fn by_pose(
    folder: &Path,
    manifest_path: &Path,
    views: &[TruthView],
    frames_are_ranked: bool,
) -> Result<OtherPictures> {
    let manifest = Manifest::read(manifest_path)?;
    frame_numbers::refuse_times(&manifest, manifest_path, frames_are_ranked)?;
    let entries = cameras::entries(&manifest, &ManifestOrigin::of_file(manifest_path))?;
    let has_frames = entries.iter().any(|entry| entry.keys.frame.or(entry.keys.time).is_some());
    let entries: Vec<(PlacedEntry, Camera)> = entries
        .into_iter()
        .map(|entry| entry.camera().map(|camera| (entry, camera)))
        .collect::<Result<_>>()?;
    let mut used = BTreeSet::new();
    let pictures = views.iter().map(|view| {
        let earlier = |other: &&TruthView| {
            other.frame_number < view.frame_number && same_camera::is_view_from(&view.camera, &other.camera)
        };
        let number = if has_frames { view.frame_number } else { views.iter().filter(earlier).count() as i64 };
        let index = entry_of(&entries, view, number)?;
        used.insert(index);
        let (entry, camera) = &entries[index];
        loader(entry.files.clone(), camera, entry.place.clone(), view)
    });
    let pictures = pictures.collect();
    let left_over = entries.iter().enumerate().filter(|(index, _)| !used.contains(index));
    let left_over = left_over.map(|(_, (entry, _))| entry.file_path.clone()).collect();
    Ok(OtherPictures { folder: folder.to_path_buf(), matched_by: MatchedBy::Pose, pictures, left_over })
}

/// The entry that was taken from a view's pose; or why none was.
fn entry_of(
    entries: &[(PlacedEntry, Camera)],
    view: &TruthView,
    number: i64,
) -> std::result::Result<usize, String> {
    let name = &view.file_path;
    let at_frame = || entries.iter().enumerate().filter(|(_, (entry, _))| entry.number == number);
    let from_there = || at_frame().filter(|(_, (_, camera))| same_camera::is_view_from(&view.camera, camera));
    if let Some((index, _)) =
        from_there().find(|(_, (_, camera))| same_camera::is_view_by(&view.camera, camera))
    {
        return Ok(index);
    }
    if let Some((_, (entry, camera))) = from_there().next() {
        let lens = |camera: &Camera| {
            let k = camera.intrinsics;
            format!("fl_x {} fl_y {} cx {} cy {} of {}×{} pixels", k.fx, k.fy, k.cx, k.cy, k.width, k.height)
        };
        return Err(format!(
            "has another lens in its {MANIFEST_NAME} for '{}', {}, than view '{name}' has, {}; render it with the view's lens and size",
            entry.file_path,
            lens(camera),
            lens(&view.camera)
        ));
    }
    let apart = |camera: &Camera| camera.position_in_world().distance(view.camera.position_in_world());
    let nearest = at_frame().min_by(|(_, (_, a)), (_, (_, b))| apart(a).total_cmp(&apart(b)));
    Err(match nearest {
        None => format!("has no picture at frame {number}, that of view '{name}', in its {MANIFEST_NAME}"),
        Some((_, (entry, camera))) => format!(
            "has no picture in its {MANIFEST_NAME} from where view '{name}' was taken; the nearest, '{}', is {:.3} away and turned by {:.2}°. \
             Export poses in the capture's own coordinates, or remove that file to match pictures by their names",
            entry.file_path,
            apart(camera),
            same_camera::turned_by_degrees(&view.camera, camera)
        ),
    })
}
