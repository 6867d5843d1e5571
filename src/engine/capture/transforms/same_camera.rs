//! Whether two entries of a manifest were recorded by one camera: equal but for rounding.

use std::cell::RefCell;
use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};

use serde::Deserialize;
use unicode_normalization::UnicodeNormalization;

use crate::capture::camera::{Camera, Intrinsics, Projection};
use crate::error::{Error, Result};

/// How far two positions of one camera may be apart, relative to the distance from the origin up to [`NEAR`]: matrices
/// that went through six digits of text.
const SAME_PLACE: f64 = 1e-6;
/// The same farther out: matrices that went through `f32`.
const SAME_PLACE_FAR: f64 = 1.2e-7;
/// World units from the origin in which scenes are built.
const NEAR: f64 = 1e3;
/// How far the entries of two rotations of one camera may differ: a fiftieth of a pixel at a focal length of 2000.
const SAME_ROTATION: f64 = 1e-5;
/// How far focal length and principal point may differ, pixels.
const SAME_INTRINSICS_PX: f64 = 1e-3;

/// Refuses a camera that is not where, or as large, or of the focal length that it was in its first frame.
///
/// # Errors
/// `Unsupported` where it moves or zooms, `Invalid` where its size changes.
pub(super) fn refuse_motion(first: &Camera, other: &Camera, first_number: i64, place: &str) -> Result<()> {
    if !is_still(first, other) {
        let what = format!("the camera moved since frame {first_number}; only static cameras are supported");
        return Err(Error::unsupported(place, what));
    }
    let (a, b) = (&first.intrinsics, &other.intrinsics);
    if (a.width, a.height) != (b.width, b.height) {
        let what = format!(
            "the picture is {}×{} but was {}×{} in frame {first_number}; every frame of a camera must have the same size",
            b.width, b.height, a.width, a.height
        );
        return Err(Error::invalid(place, what));
    }
    if !same_lens(a, b) {
        let what =
            format!("the camera zooms since frame {first_number}; only a fixed focal length is supported");
        return Err(Error::unsupported(place, what));
    }
    Ok(())
}

fn is_still(first: &Camera, other: &Camera) -> bool {
    let reach = first.position_in_world().length();
    let (a, b) = (&first.world_from_camera, &other.world_from_camera);
    let apart = apart(SAME_PLACE, reach);
    a.matrix3.abs_diff_eq(b.matrix3, SAME_ROTATION) && a.translation.abs_diff_eq(b.translation, apart)
}

/// How far apart places that are this far from the origin may be: by this share near it, and by rounding to `f32` beyond.
fn apart(share: f64, reach: f64) -> f64 {
    (share * reach.clamp(1.0, NEAR)).max(SAME_PLACE_FAR * reach)
}

/// Whether the place of a camera may have gone through `f32`.
fn is_single(camera: &Camera) -> bool {
    camera.position_in_world().to_array().iter().all(|value| f64::from(*value as f32) == *value)
}

/// The first of the `known` cameras that differs from this one by rounding alone, or this one, which is known from then on.
pub(super) fn without_rounding(known: &mut Vec<Camera>, camera: Camera) -> Camera {
    let is_same = |first: &&Camera| {
        let (a, b) = (&first.intrinsics, &camera.intrinsics);
        // Far from the origin a view that is written with all digits may be a step of a path away.
        let is_near = first.position_in_world().distance(camera.position_in_world()) <= SAME_PLACE * NEAR;
        let is_rounded = is_near || (is_single(first) && is_single(&camera));
        let is_of_one_lens = first.name == camera.name && a.size() == b.size() && same_lens(a, b);
        is_of_one_lens && is_rounded && is_still(first, &camera)
    };
    if let Some(first) = known.iter().find(is_same) {
        return first.clone();
    }
    known.push(camera.clone());
    camera
}

/// How far apart the places of a view and of a picture of it may be, relative to the distance from the origin between 1 and [`NEAR`],
/// and how far the entries of their rotations: poses that another program wrote with five digits; a fifth of a pixel at a focal length of 2000.
const SAME_VIEW: f64 = 1e-4;

/// How far focal length and principal point of a view and of a picture of it may differ, pixels.
const SAME_VIEW_LENS_PX: f64 = 0.05;

/// Whether another program took a picture from where a view was taken, with what it rounds its poses to.
pub(super) fn is_view_from(view: &Camera, picture: &Camera) -> bool {
    let (a, b) = (&view.world_from_camera, &picture.world_from_camera);
    let apart = apart(SAME_VIEW, a.translation.length());
    a.matrix3.abs_diff_eq(b.matrix3, SAME_VIEW) && a.translation.abs_diff_eq(b.translation, apart)
}

/// Whether another program's picture has the size and the lens of a view.
pub(super) fn is_view_by(view: &Camera, picture: &Camera) -> bool {
    let (a, b) = (&view.intrinsics, &picture.intrinsics);
    a.size() == b.size() && lens_differences(a, b).iter().all(|d| d.abs() <= SAME_VIEW_LENS_PX)
}

/// Angle between the orientations of two cameras, degrees.
pub(super) fn turned_by_degrees(a: &Camera, b: &Camera) -> f64 {
    let turn = a.world_from_camera.matrix3.transpose() * b.world_from_camera.matrix3;
    let cosine = 0.5 * (turn.x_axis.x + turn.y_axis.y + turn.z_axis.z - 1.0);
    cosine.clamp(-1.0, 1.0).acos().to_degrees()
}

fn lens_differences(a: &Intrinsics, b: &Intrinsics) -> [f64; 4] {
    // Orthographic cameras are compared by what they move at the edges of the picture: pixels per unit may be of any size.
    let [by_x, by_y] = match a.projection {
        Projection::Perspective => [1.0, 1.0],
        Projection::Orthographic => [f64::from(a.width) / a.fx, f64::from(a.height) / a.fy],
    };
    [(a.fx - b.fx) * by_x, (a.fy - b.fy) * by_y, a.cx - b.cx, a.cy - b.cy]
}

fn same_lens(a: &Intrinsics, b: &Intrinsics) -> bool {
    a.projection == b.projection && lens_differences(a, b).iter().all(|d| d.abs() <= SAME_INTRINSICS_PX)
}

/// The names of each folder that was looked into, by what all systems take for the same.
#[derive(Default)]
pub(super) struct SimilarNames {
    folders: RefCell<HashMap<PathBuf, HashMap<String, Vec<PathBuf>>>>,
}

impl SimilarNames {
    /// The one file that a path which is not there can mean; `None` where there is none, or several. A path from the root of another
    /// machine means the file in `folder` that has the longest end of it as its own.
    pub(super) fn file(&self, folder: &Path, path: &Path) -> Option<PathBuf> {
        self.similar(path).or_else(|| {
            // What was joined to the folder is no path of another machine, but for a name of Windows.
            let parts = foreign_parts(path.strip_prefix(folder).unwrap_or(path))?;
            let ends = (1..parts.len()).map(|from| parts[from..].iter().collect::<PathBuf>());
            ends.map(|end| folder.join(end)).find_map(|place| self.similar(&place))
        })
    }

    /// The path itself where it is a file, or the only one that differs by letters that systems take for the same.
    fn similar(&self, path: &Path) -> Option<PathBuf> {
        if path.is_file() {
            return Some(path.to_path_buf());
        }
        let mut place = PathBuf::new();
        for part in path.components() {
            let next = place.join(part);
            place = match part {
                Component::Normal(name) if !next.exists() => self.only(&place, &name.to_string_lossy())?,
                _ => next,
            };
        }
        place.is_file().then_some(place)
    }

    fn only(&self, folder: &Path, name: &str) -> Option<PathBuf> {
        let mut folders = self.folders.borrow_mut();
        let names = folders.entry(folder.to_path_buf()).or_insert_with(|| {
            let place = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
            let mut names: HashMap<String, Vec<PathBuf>> = HashMap::new();
            for entry in std::fs::read_dir(place).into_iter().flatten().flatten() {
                let own = entry.file_name();
                names.entry(folded(&own.to_string_lossy())).or_default().push(folder.join(own));
            }
            names
        });
        match names.get(&folded(name)).map(Vec::as_slice) {
            Some([only]) => Some(only.clone()),
            _ => None,
        }
    }
}

/// What names are compared by: letters without case, each composed where that can be.
fn folded(name: &str) -> String {
    name.nfd().flat_map(char::to_lowercase).nfc().collect()
}

/// Whether a name starts at the root of a machine, of whatever system.
pub(super) fn is_absolute(name: &str) -> bool {
    let of_windows = |name: &[u8]| name.len() > 2 && name[0].is_ascii_alphabetic() && name[1] == b':';
    name.starts_with(['/', '\\']) || of_windows(name.as_bytes())
}

/// The parts of a path from the root of a machine; `None` of any other path.
fn foreign_parts(path: &Path) -> Option<Vec<String>> {
    let text = path.to_string_lossy();
    // A name of Windows is no root here: it was joined to the folder of the manifest.
    let windows = text.char_indices().find(|(at, _)| {
        let starts = *at == 0 || text[..*at].ends_with(['/', '\\']);
        starts && text[*at..].as_bytes().get(1) == Some(&b':') && is_absolute(&text[*at..])
    });
    let name = windows.map_or(&*text, |(at, _)| &text[at..]);
    let parts = name.split(['/', '\\']).filter(|part| !part.is_empty() && *part != "." && *part != "..");
    is_absolute(name).then(|| parts.map(str::to_owned).collect())
}

/// Reads a camera's name; some writers number their cameras.
pub(super) fn camera_name<'de, D: serde::Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<String>, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum CameraName {
        Text(String),
        Number(i64),
    }
    Ok(Option::<CameraName>::deserialize(deserializer)?.map(|name| match name {
        CameraName::Text(text) => text,
        CameraName::Number(number) => number.to_string(),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_means_a_file_of_other_case_or_composition_only_where_there_is_one() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir(at("Left")).unwrap();
        for name in ["Left/Ra\u{308}ume.PNG", "twice.png", "Twice.png", "a.exr"] {
            std::fs::write(at(name), "").unwrap();
        }
        let found = |name: &str| SimilarNames::default().file(folder.path(), &at(name));
        assert_eq!(found("left/R\u{e4}ume.png"), Some(at("Left/Ra\u{308}ume.PNG")));
        assert_eq!(found("a.exr"), Some(at("a.exr")));
        assert_eq!((found("TWICE.png"), found("b.exr")), (None, None));
    }

    #[test]
    fn a_path_of_another_machine_means_the_file_with_the_longest_end_of_it() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir(at("left")).unwrap();
        for name in ["left/1.png", "1.png"] {
            std::fs::write(at(name), "").unwrap();
        }
        let found = |name: &str| SimilarNames::default().file(folder.path(), &at(name));
        for name in ["/no/such/home/left/1.png", "C:\\Users\\me\\left\\1.png", "D:/x/left/1.png"] {
            assert_eq!(found(name), Some(at("left/1.png")), "{name}");
        }
        assert_eq!(found("/no/such/right/1.png"), Some(at("1.png")));
        assert_eq!((found("right/1.png"), found("/no/such/2.png")), (None, None));
    }
}
