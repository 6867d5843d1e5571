//! The captures *Breakdancers* and *Ballet* of Microsoft Research.
//!
//! Source: Zitnick, Kang, Uyttendaele, Winder, Szeliski: High-quality video view interpolation using a layered representation,
//! SIGGRAPH 2004, and the notes beside its data: `calibParams-NAME.txt` has for each camera its index, a 3×3 lens matrix, two
//! zeros (of distortion), and 3×4 numbers world to camera; `cam0/color-cam0-f000.jpg`; `cam0/depth-cam0-f000.png` in 256 levels
//! even in 1/z between two planes that the notes give. As measured on the data, the axes of a camera are x right, y up, z forward,
//! rows count from the bottom, and z is that of world space, not of the camera's.

use std::path::Path;

use super::place::SourceFolder;
use super::reader::{Description, ReadSource, Reader};
use super::text::TextFile;
use super::views::{
    colors_in, digits_between, entry, lens, pictures_in, pose_of_rows, rig_or_recording, stem,
};
use crate::capture::pictures;
use crate::capture::pose_convention::{CameraAxes, PoseDirection};
use crate::capture::transforms::{Keys, PictureEntry, RawVideoKeys};
use crate::error::{Error, Result};
use crate::plural::counted;

/// Near and far plane, of the capture whose name has this in it.
const RANGES: [(&str, f64, f64); 2] = [("breakdancer", 44.0, 120.0), ("ballet", 42.0, 130.0)];
/// Numbers of a camera: index, lens, distortion, pose.
const NUMBERS: usize = 1 + 9 + 2 + 12;

/// Microsoft Research's captures.
pub(super) const MSR: Reader = Reader {
    source: "Microsoft Research's video view interpolation",
    marks: "calibParams-*.txt and cam0/color-cam0-f000.jpg (Microsoft Research)",
    stands_for_folder: |_| true,
    is_here: |place| calibration_of(place).is_some(),
    poses: "world to camera; camera x right, y up, z forward; the world is left-handed, and is mirrored along y",
    depth: "",
    lens: "of every camera, with rows from the bottom",
    read,
};

/// A camera of the file of calibrations.
struct MsrCamera {
    index: usize,
    /// 3×3, row by row; rows of the picture count from the bottom.
    lens: [f64; 9],
    /// 3×4, world to camera, row by row.
    pose: [f64; 12],
}

fn read(place: &SourceFolder, mut description: Description) -> Result<ReadSource> {
    let path = place.join(calibration_of(place).unwrap_or_default());
    let (near, far) = range_of(&path, &place.folder)?;
    let cameras = calibrations(&path)?;
    description.depth = format!("z in world space, in 256 levels even in 1/z between {near} and {far}");
    let mut frames = Vec::new();
    for camera in &cameras {
        frames.extend(pictures_of(place, camera, &path, &mut description)?);
    }
    let largest = cameras.iter().map(|camera| camera.lens[1].abs()).fold(0.0, f64::max);
    if largest > 0.0 {
        description
            .notes
            .push(format!("axes of the lenses are skewed by up to {largest:.2}, which is left out"));
    }
    let keys = Keys {
        depth_kind: Some("world_z".to_owned()),
        raw_video: RawVideoKeys { depth_range: Some((near, Some(far))), ..RawVideoKeys::default() },
        transform_direction: Some(PoseDirection::WorldToCamera),
        camera_axes: Some(CameraAxes::DIRECT3D),
        up: Some([0.0, -1.0, 0.0]),
        ..Keys::default()
    };
    rig_or_recording(place, keys, frames, description, vec![path])
}

/// The file of calibrations: the one that was named, or the first of the folder's.
fn calibration_of(place: &SourceFolder) -> Option<&str> {
    let is_ours = |name: &str| name.strip_suffix(".txt").is_some_and(|stem| stem.starts_with("calibParams"));
    match place.file.as_deref() {
        Some(name) => Some(name).filter(|name| is_ours(name)),
        None => place.names().find(|name| is_ours(name)),
    }
}

/// Near and far plane. Only the names of captures distinguish them.
fn range_of(path: &Path, folder: &Path) -> Result<(f64, f64)> {
    let names =
        [path, folder].map(|path| path.file_name().unwrap_or_default().to_string_lossy().to_lowercase());
    let found = RANGES.iter().find(|(capture, ..)| names.iter().any(|name| name.contains(capture)));
    found.map(|&(_, near, far)| (near, far)).ok_or_else(|| {
        let what = "near and far plane of the depth are known of breakdancers and ballet, and the name of neither file nor folder has one of these; rename the file, as in calibParams-ballet.txt";
        Error::invalid(path.display(), what)
    })
}

fn calibrations(path: &Path) -> Result<Vec<MsrCamera>> {
    let numbers = TextFile::read(path)?.numbers()?;
    if numbers.is_empty() || numbers.len() % NUMBERS != 0 {
        let what = format!(
            "{} too many behind camera {}, counted from 0; a camera has an index, 9 of the lens, 2 of distortion, 12 of the pose",
            counted(numbers.len() % NUMBERS, "number"),
            numbers.len() / NUMBERS
        );
        return Err(Error::invalid(path.display(), what));
    }
    let calibration = |(position, of_camera): (usize, &[f64])| {
        let wrong = |what: String| {
            Error::invalid(path.display(), format!("camera {position}, counted from 0, {what}"))
        };
        let index = of_camera[0];
        if !((0.0..1e6).contains(&index) && index.fract() == 0.0) {
            return Err(wrong(format!("has the index {index}")));
        }
        if of_camera[10..12] != [0.0; 2] {
            return Err(wrong(
                "has distortion, whose meaning is not known; undistort its pictures and write 0 0".to_owned(),
            ));
        }
        let (mut lens, mut pose) = ([0.0; 9], [0.0; 12]);
        lens.copy_from_slice(&of_camera[1..10]);
        pose.copy_from_slice(&of_camera[12..]);
        if pose_of_rows(&pose).is_none() {
            return Err(wrong("has a pose that is not rigid".to_owned()));
        }
        Ok(MsrCamera { index: index as usize, lens, pose })
    };
    numbers.chunks_exact(NUMBERS).enumerate().map(calibration).collect()
}

/// The pictures of a camera that have color and depth.
fn pictures_of(
    place: &SourceFolder,
    camera: &MsrCamera,
    calibration: &Path,
    description: &mut Description,
) -> Result<Vec<PictureEntry>> {
    let name = format!("cam{}", camera.index);
    let folder = place.join(&name);
    let depths = pictures_in(&folder, &[".png"]);
    let [fx, _, cx, _, fy, cy, ..] = camera.lens;
    let mut pictures = Vec::new();
    let mut own_lens = None;
    for color in colors_in(&folder) {
        let Some(digits) = digits_between(&format!("color-{name}-f"), stem(&color), "") else { continue };
        let depth = format!("depth-{name}-f{digits}.png");
        if !depths.contains(&depth) {
            description.skip("without depth", format!("{name}/{color}"));
            continue;
        }
        if own_lens.is_none() {
            let path = folder.join(&color);
            let (_, height) = pictures::size(&path, &path.display().to_string())?;
            own_lens = Some(lens(fx, fy, cx, height as f64 - 1.0 - cy, 0.0));
        }
        let mut one =
            entry(format!("{name}/{color}"), Some(format!("{name}/{depth}")), &glam::DAffine3::IDENTITY);
        one.transform_matrix = camera.pose.chunks(4).map(<[f64]>::to_vec).collect();
        one.keys = Keys {
            camera: Some(name.clone()),
            frame: digits.parse().ok(),
            ..own_lens.clone().unwrap_or_default()
        };
        pictures.push(one);
    }
    if pictures.is_empty() {
        let what = format!(
            "camera {} has no pair {name}/color-{name}-f000.jpg and {name}/depth-{name}-f000.png; unpack its folder beside the file",
            camera.index
        );
        return Err(Error::invalid(calibration.display(), what));
    }
    Ok(pictures)
}
