//! Pictures that another program made of views: found by their names, or by where they were taken.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::files::{PictureFiles, picture_path, without_extension};
use super::manifest::Keys;
use super::manifest_file::MANIFEST_NAME;
use super::other_pictures::{MatchedBy, OtherPictures, loader};
use super::pictures_by_pose::by_pose;
use crate::capture::parts::TruthView;
use crate::capture::pictures::PICTURE_EXTENSIONS;
use crate::error::Result;

/// Folders within each other that pictures without a view are looked for in.
const DEPTH: usize = 4;

/// Finds the pictures of views in a folder. A `transforms.json` in it has the pose of each: a view's picture is the one from its
/// place, by its lens, at its frame (the order of pictures at one place, if it gives no times). In any other folder a
/// view's picture has the view's own name, with the same extension or that of another format; the last part of the name is enough
/// where it names one view alone. PNG, JPEG and TIFF are sRGB, EXR is linear. A pixel with an alpha of 0 is a hole.
///
/// `frames_are_ranked`: see [`open_views_of`](super::open_views_of).
///
/// # Errors
/// `Invalid` where the folder has a picture of none of the views, with the reason for the first; those of reading its `transforms.json`.
pub fn open_pictures(folder: &Path, views: &[TruthView], frames_are_ranked: bool) -> Result<OtherPictures> {
    let manifest = folder.join(MANIFEST_NAME);
    let found = if manifest.is_file() {
        by_pose(folder, &manifest, views, frames_are_ranked)?
    } else {
        by_name(folder, views)
    };
    if found.count() == 0 {
        found.all()?;
    }
    Ok(found)
}

fn by_name(folder: &Path, views: &[TruthView]) -> OtherPictures {
    let last_parts: BTreeSet<&str> = views.iter().map(|view| without_extension(&view.file_path)).collect();
    let last_part_is_enough = last_parts.len() == views.len();
    let mut used: BTreeSet<PathBuf> = BTreeSet::new();
    let pictures = views.iter().map(|view| {
        let by_last_part = || picture_of(folder, without_extension(&view.file_path));
        let path = picture_of(folder, &view.file_path)
            .or_else(|| if last_part_is_enough { by_last_part() } else { None });
        let Some(path) = path else {
            return Err(format!(
                "has no picture of view '{}'; write one for each view, under its own name, as PNG, JPEG, TIFF or EXR",
                view.file_path
            ));
        };
        used.insert(path.with_extension(""));
        let place = path.display().to_string();
        let files = PictureFiles::new(path, None, None, &Keys::default(), &place);
        loader(files.map_err(|error| error.to_string())?, &view.camera, place, view)
    });
    let pictures = pictures.collect();
    let left_over =
        pictures_in(folder, DEPTH).into_iter().filter(|path| !used.contains(&path.with_extension("")));
    let left_over =
        left_over.map(|path| path.strip_prefix(folder).unwrap_or(&path).display().to_string()).collect();
    OtherPictures { folder: folder.to_path_buf(), matched_by: MatchedBy::FileName, pictures, left_over }
}

/// The path of the picture with a name; `None` if none has it.
fn picture_of(folder: &Path, name: &str) -> Option<PathBuf> {
    let whole = picture_path(folder, name, &[]);
    if whole.is_file() {
        return Some(whole);
    }
    let stem = Path::new(name).with_extension("");
    let other = picture_path(folder, &stem.to_string_lossy(), &[]);
    other.is_file().then_some(other)
}

/// All pictures in a folder and those within it, sorted.
fn pictures_in(folder: &Path, depth: usize) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort_unstable();
    let is_picture = |path: &Path| {
        let extension = path.extension().unwrap_or_default();
        path.is_file() && PICTURE_EXTENSIONS.iter().any(|known| extension.eq_ignore_ascii_case(known))
    };
    let within = |path: PathBuf| match depth {
        _ if is_picture(&path) => vec![path],
        1.. if path.is_dir() => pictures_in(&path, depth - 1),
        _ => Vec::new(),
    };
    paths.into_iter().flat_map(within).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::transforms::pose;
    use crate::capture::{Camera, Intrinsics, TruthLoader};
    use glam::DVec3;
    use serde_json::{Value, json};

    /// Views from two places at two frames, without truth.
    fn views() -> Vec<TruthView> {
        let intrinsics = Intrinsics::centered(4, 3, 5.0);
        let view = |place: usize, frame: i64| {
            let position = DVec3::new(place as f64, -3.0, 1.0);
            let camera = Camera::look_at(format!("at{place}"), intrinsics, position, DVec3::ZERO, DVec3::Z);
            TruthView::new(format!("at{place}/{frame:04}.exr"), camera, frame, None)
        };
        vec![view(0, 4), view(0, 7), view(1, 4), view(1, 7)]
    }

    /// Writes a gray picture.
    fn picture(folder: &Path, name: &str, gray: u8, size: (u32, u32)) {
        let path = folder.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        image::GrayImage::from_pixel(size.0, size.1, image::Luma([gray])).save(path).unwrap();
    }

    /// Writes a manifest of pictures that were taken where views were, after `change`.
    fn manifest(folder: &Path, pictures: &[(&str, &TruthView)], change: impl Fn(&mut Value)) {
        let entries = pictures.iter().map(|(name, view)| {
            let k = view.camera.intrinsics;
            let rounded = pose::opengl_matrix(&view.camera.world_from_camera).into_iter();
            let rounded = rounded.map(|row| row.into_iter().map(|value| (1e6 * value).round() / 1e6).collect::<Vec<_>>());
            let mut entry = json!({
                "file_path": name, "fl_x": k.fx, "fl_y": k.fy, "cx": k.cx, "cy": k.cy, "w": k.width, "h": k.height,
                "transform_matrix": rounded.collect::<Vec<_>>(), "time": view.frame_number,
            });
            change(&mut entry);
            entry
        });
        let text = json!({ "frames": entries.collect::<Vec<_>>() }).to_string();
        std::fs::write(folder.join(MANIFEST_NAME), text).unwrap();
    }

    /// The gray of each view's picture, encoded, or the trouble.
    fn grays(found: &OtherPictures) -> Vec<Result<u8, String>> {
        let gray = |load: &TruthLoader| {
            let linear = load().unwrap().color[(0, 0)][0].to_f32();
            crate::color::srgb8_from_linear(linear)
        };
        found.pictures.iter().map(|picture| picture.as_ref().map(gray).map_err(Clone::clone)).collect()
    }

    #[test]
    fn pictures_are_found_by_the_views_names_in_any_format_and_others_are_left_over() {
        let folder = tempfile::tempdir().unwrap();
        let (folder, views) = (folder.path(), views());
        assert!(
            open_pictures(folder, &views, false)
                .err()
                .unwrap()
                .to_string()
                .contains("no picture of view 'at0/0004.exr'")
        );
        for (index, view) in views.iter().enumerate() {
            picture(folder, &view.file_path.replace(".exr", ".png"), 10 + index as u8, (4, 3));
        }
        picture(folder, "at1/extra.png", 0, (4, 3));
        let found = open_pictures(folder, &views, false).unwrap();
        assert_eq!(found.matched_by, MatchedBy::FileName);
        assert_eq!(grays(&found), [Ok(10), Ok(11), Ok(12), Ok(13)]);
        assert_eq!(found.left_over, ["at1/extra.png"]);
        assert!(found.warning().unwrap().ends_with("the picture 'at1/extra.png' shows none of the views"));
        // The last part of a name is enough for one place, and means two views for two.
        let flat = tempfile::tempdir().unwrap();
        picture(flat.path(), "0004.png", 50, (4, 3));
        assert_eq!(grays(&open_pictures(flat.path(), &views[..2], false).unwrap())[0], Ok(50));
        assert!(open_pictures(flat.path(), &views, false).is_err());
    }

    #[test]
    fn pictures_with_poses_are_found_by_where_they_were_taken_whatever_their_names() {
        let folder = tempfile::tempdir().unwrap();
        let (folder, views) = (folder.path(), views());
        let names = ["a.png", "b.png", "c.png", "d.png"];
        for (index, name) in names.iter().enumerate() {
            picture(folder, name, 10 + index as u8, (4, 3));
        }
        let shuffled =
            [("a.png", &views[3]), ("b.png", &views[2]), ("c.png", &views[0]), ("d.png", &views[1])];
        manifest(folder, &shuffled, |_| {});
        let found = open_pictures(folder, &views, false).unwrap();
        assert_eq!(found.matched_by, MatchedBy::Pose);
        assert_eq!(grays(&found), [Ok(12), Ok(13), Ok(11), Ok(10)]);
        assert_eq!(found.left_over, [""; 0]);
        // Without times, pictures from one place follow each other.
        let in_order =
            [("a.png", &views[0]), ("b.png", &views[2]), ("c.png", &views[1]), ("d.png", &views[3])];
        manifest(folder, &in_order, |entry| {
            entry.as_object_mut().unwrap().remove("time");
        });
        assert_eq!(grays(&open_pictures(folder, &views, false).unwrap()), [Ok(10), Ok(12), Ok(11), Ok(13)]);
    }

    #[test]
    fn poses_and_lenses_that_do_not_fit_are_said_in_numbers() {
        let folder = tempfile::tempdir().unwrap();
        let (folder, views) = (folder.path(), views());
        picture(folder, "a.png", 10, (4, 3));
        let trouble = |change: &dyn Fn(&mut Value)| {
            manifest(folder, &[("a.png", &views[0])], change);
            open_pictures(folder, &views[..1], false).err().unwrap().to_string()
        };
        let moved = trouble(&|entry| entry["transform_matrix"][0][3] = json!(0.25));
        assert!(moved.contains("'a.png', is 0.250 away and turned by 0.00°"), "{moved}");
        let zoomed = trouble(&|entry| entry["fl_x"] = json!(6.0));
        assert!(zoomed.contains("fl_x 6 ") && zoomed.contains("fl_x 5 "), "{zoomed}");
        let later = trouble(&|entry| entry["time"] = json!(5));
        assert!(later.contains("no picture at frame 4"), "{later}");
        for text in [moved, zoomed, later] {
            assert_eq!(text.lines().count(), 1);
        }
    }
}
