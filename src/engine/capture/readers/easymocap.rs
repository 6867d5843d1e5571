//! Rigs calibrated by `EasyMocap`, as `ENeRF`, `ZJU-MoCap` and `4K4D` have them too.
//!
//! Source: `EasyMocap`'s `camera_utils.py`: `intri.yml` (`K_NAME` 3×3, `dist_NAME` k1 k2 p1 p2 k3) and `extri.yml` (`names`, `R_NAME`
//! Rodrigues' vector, `Rot_NAME` 3×3, `T_NAME`: world to camera, x right, y down, z forward) in `OpenCV`'s YAML, `images/NAME/000000.jpg`.
//! Depth, which the rig's own tools do not write, is looked for as `depth/NAME/000000.png` (or `depths/`) in millimeters, of
//! color's lens.

use std::collections::BTreeMap;
use std::path::Path;

use glam::{DAffine3, DMat3, DQuat, DVec3};

use super::place::{SourceFolder, names_in};
use super::reader::{Description, ReadSource, Reader};
use super::text::TextFile;
use super::views::{
    MILLIMETERS, OPENCV_POSES, colors_in, entry, lens, number_in, pictures_in, pose_of_rows,
    rig_or_recording, stem,
};
use crate::capture::transforms::{Keys, LensKeys, PictureEntry};
use crate::error::{Error, Result};
use crate::plural::counted;

/// Files of the calibration.
const FILES: [&str; 2] = ["intri.yml", "extri.yml"];

/// Rigs of `EasyMocap`.
pub(super) const EASYMOCAP: Reader = Reader {
    source: "EasyMocap",
    marks: "intri.yml, extri.yml and images/ (EasyMocap)",
    stands_for_folder: |file| FILES.contains(&file),
    is_here: |place| place.has_all(&FILES),
    poses: "",
    depth: MILLIMETERS,
    lens: "of every camera",
    read,
};

fn read(place: &SourceFolder, mut description: Description) -> Result<ReadSource> {
    let paths = FILES.map(|name| place.join(name));
    let [lenses, poses] = [matrices(&paths[0])?, matrices(&paths[1])?];
    let Some(depth) = place.first_of(&["depth", "depths"]) else {
        let what = "there is no depth/ beside images/: a rig of color cameras holds no depth; compute it (COLMAP's patch_match_stereo for every frame, or a sensor's) and save it as depth/NAME/000000.png in millimeters";
        return Err(Error::unsupported(place.folder.display(), what));
    };
    description.poses = OPENCV_POSES.replace("camera to world", "world to camera");
    let mut frames = Vec::new();
    for name in names_in(&place.join("images"))? {
        if lenses.contains_key(&format!("K_{name}")) {
            let keys = lens_of(&lenses, &name, &paths[0])?;
            let pose = pose_of(&poses, &name, &paths[1])?;
            frames.extend(pictures_of(place, depth, &name, &keys, &pose, &mut description));
        } else {
            description.skip("cameras without a calibration", name);
        }
    }
    let keys = Keys { depth_unit_scale_factor: Some(1e-3), ..Keys::default() };
    rig_or_recording(place, keys, frames, description, paths.to_vec())
}

/// The matrices of a file of `OpenCV`'s YAML by their names, each row by row.
fn matrices(path: &Path) -> Result<BTreeMap<String, Vec<f64>>> {
    let file = TextFile::read(path)?;
    let mut found = BTreeMap::new();
    // The matrix that was begun last: its name, its first line, and its numbers as far as they were read.
    let mut open: Option<(String, usize, Option<String>)> = None;
    let wrong = |line: usize, what: String| Error::invalid(format!("{}, line {line}", path.display()), what);
    let endless = |(name, line, _): &(String, usize, Option<String>)| {
        wrong(*line, format!("the matrix {name} has no end: there is no ']'"))
    };
    for (index, line) in file.text().lines().enumerate() {
        if let Some((name, _)) = line.split_once(':').filter(|(_, value)| value.contains("!!opencv-matrix")) {
            if let Some(open) = &open {
                return Err(endless(open));
            }
            open = Some((name.trim().trim_matches('"').to_owned(), index + 1, None));
            continue;
        }
        let Some((name, start, data)) = &mut open else { continue };
        let start = *start;
        if let Some((_, begun)) = line.split_once("data:") {
            *data = Some(begun.trim_start().trim_start_matches('[').to_owned());
        } else if let Some(data) = data {
            data.push(' ');
            data.push_str(line.trim());
        }
        let Some((numbers, _)) = data.as_deref().and_then(|data| data.split_once(']')) else { continue };
        let fields = numbers
            .split(|letter: char| letter == ',' || letter.is_whitespace())
            .filter(|field| !field.is_empty());
        let number = |field: &str| {
            field
                .parse::<f64>()
                .ok()
                .filter(|number| number.is_finite())
                .ok_or_else(|| wrong(index + 1, format!("'{field}' is no number")))
        };
        let numbers = fields.map(number).collect::<Result<Vec<f64>>>()?;
        if found.insert(name.clone(), numbers).is_some() {
            return Err(wrong(start, format!("the matrix {name} is there twice")));
        }
        open = None;
    }
    match &open {
        Some(open) => Err(endless(open)),
        None => Ok(found),
    }
}

/// `N` numbers of a matrix.
fn numbers<const N: usize>(
    matrices: &BTreeMap<String, Vec<f64>>,
    name: &str,
    path: &Path,
) -> Result<[f64; N]> {
    let Some(found) = matrices.get(name) else {
        return Err(Error::invalid(path.display(), format!("there is no {name}")));
    };
    found.get(..N).filter(|_| found.len() == N).and_then(|found| found.try_into().ok()).ok_or_else(|| {
        Error::invalid(
            path.display(),
            format!("{name} has {}; {N} are expected", counted(found.len(), "number")),
        )
    })
}

fn lens_of(lenses: &BTreeMap<String, Vec<f64>>, name: &str, path: &Path) -> Result<Keys> {
    let [fx, _, cx, _, fy, cy, ..] = numbers::<9>(lenses, &format!("K_{name}"), path)?;
    let mut keys = lens(fx, fy, cx, cy, 0.0);
    let bent = format!("dist_{name}");
    if lenses.contains_key(&bent) {
        let [k1, k2, p1, p2, k3] = numbers::<5>(lenses, &bent, path)?;
        keys.camera_model = Some("OPENCV".to_owned());
        keys.lens = LensKeys::of(&[("k1", k1), ("k2", k2), ("p1", p1), ("p2", p2), ("k3", k3)]);
    }
    Ok(keys)
}

/// Camera to world. The matrix counts if a Rodrigues vector is there too; both must be the same rotation.
fn pose_of(poses: &BTreeMap<String, Vec<f64>>, name: &str, path: &Path) -> Result<DAffine3> {
    let translation = DVec3::from(numbers::<3>(poses, &format!("T_{name}"), path)?);
    let (matrix, vector) = (format!("Rot_{name}"), format!("R_{name}"));
    let of_vector = || -> Result<DMat3> {
        let vector = DVec3::from(numbers::<3>(poses, &vector, path)?);
        Ok(DMat3::from_quat(DQuat::from_scaled_axis(vector)))
    };
    let rotation = if poses.contains_key(&matrix) {
        let [a, b, c, d, e, f, g, h, i] = numbers::<9>(poses, &matrix, path)?;
        let rows = [a, b, c, 0.0, d, e, f, 0.0, g, h, i, 0.0];
        let pose = pose_of_rows(&rows)
            .ok_or_else(|| Error::invalid(path.display(), format!("{matrix} is no rotation")))?;
        if poses.contains_key(&vector) && !of_vector()?.abs_diff_eq(pose.matrix3, 1e-3) {
            let what = format!("{vector} and {matrix} are two rotations; leave the wrong one out");
            return Err(Error::invalid(path.display(), what));
        }
        pose.matrix3
    } else {
        of_vector()?
    };
    Ok(DAffine3 { matrix3: rotation, translation }.inverse())
}

/// The pictures of a camera that have color and depth.
fn pictures_of(
    place: &SourceFolder,
    depth_folder: &str,
    name: &str,
    lens: &Keys,
    world_from_camera: &DAffine3,
    description: &mut Description,
) -> Vec<PictureEntry> {
    let depths = pictures_in(&place.join(&format!("{depth_folder}/{name}")), &[".png"]);
    let mut pictures = Vec::new();
    for color in colors_in(&place.join(&format!("images/{name}"))) {
        let file_path = format!("images/{name}/{color}");
        let own = depths.iter().find(|depth| stem(depth) == stem(&color));
        let (Some(depth), Some(frame)) = (own, number_in(&color)) else {
            description.skip("without depth of the same number", file_path);
            continue;
        };
        let mut one = entry(file_path, Some(format!("{depth_folder}/{name}/{depth}")), world_from_camera);
        one.keys = Keys { camera: Some(name.to_owned()), frame: Some(frame as f64), ..lens.clone() };
        pictures.push(one);
    }
    pictures
}
