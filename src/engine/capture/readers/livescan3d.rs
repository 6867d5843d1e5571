//! Takes of `LiveScan3D`: several Azure Kinects, each with a color and a depth camera of its own.
//!
//! Source: `LiveScan3D` (Kowalski, Naruniec, Daniluk, 3DV 2015; the fork of Building Volumes): `client_0/Color_0.jpg`,
//! `client_0/Depth_0.tiff` in millimeters, `client_0/Intrinsics_Calib_0.json` as the sensor gives it, and `Extrinsics_Open3D.log`
//! with `0`, serial number and index of each sensor before the 16 numbers of its color camera's pose, camera to world, in meters. The
//! calibration: Azure Kinect's SDK (`transformation/mode_specific_calibration.c`): lenses in shares of the sensor's sides; a mode
//! of the camera shows a part of the sensor.

use std::path::{Path, PathBuf};

use glam::DAffine3;
use serde::Deserialize;

use super::place::{SourceFolder, names_in};
use super::reader::{Description, ReadSource, Reader};
use super::text::TextFile;
use super::views::{
    OPENCV_POSES, colors_in, digits_between, entry, json, lens, pictures_in, pose_of_rows, rig_or_recording,
    stem,
};
use crate::capture::pictures;
use crate::capture::transforms::{DepthCameraKeys, Keys, LensKeys, PictureEntry, opengl_matrix};
use crate::error::{Error, Result};
use crate::plural::counted;

const POSES: &str = "Extrinsics_Open3D.log";
const COLOR: &str = "CALIBRATION_CameraPurposePhotoVideo";
const DEPTH: &str = "CALIBRATION_CameraPurposeDepth";

/// Takes of `LiveScan3D`.
pub(super) const LIVESCAN3D: Reader = Reader {
    source: "LiveScan3D",
    marks: "Extrinsics_Open3D.log beside client_0/ (LiveScan3D)",
    stands_for_folder: |file| file == POSES,
    is_here: |place| place.has(POSES) && place.names().any(|name| client(name).is_some()),
    poses: OPENCV_POSES,
    depth: "planar z in millimeters, 16-bit TIFF; 0 is no depth; carried into the color camera",
    lens: "of every sensor, color and depth apart",
    read,
};

#[derive(Deserialize)]
#[serde(rename_all = "PascalCase")]
struct SensorCalibration {
    calibration_information: CalibrationInformation,
}

#[derive(Deserialize)]
#[serde(rename_all = "PascalCase")]
struct CalibrationInformation {
    cameras: Vec<SensorCamera>,
}

#[derive(Deserialize)]
#[serde(rename_all = "PascalCase")]
struct SensorCamera {
    purpose: String,
    intrinsics: SensorLens,
    rt: FromDepth,
}

#[derive(Deserialize)]
#[serde(rename_all = "PascalCase")]
struct SensorLens {
    /// Principal point and focal lengths in shares of the sensor's sides; k1 to k6; the center of distortion; p2, p1.
    model_parameters: Vec<f64>,
}

/// From the depth camera's space, meters.
#[derive(Deserialize)]
#[serde(rename_all = "PascalCase")]
struct FromDepth {
    /// Row by row.
    rotation: [f64; 9],
    translation: [f64; 3],
}

/// A sensor's side and the part of it that a mode shows: pictures are the sensor, scaled to `scaled`, from `offset` on.
struct SensorMode {
    scaled: (f64, f64),
    offset: (f64, f64),
}

/// A lens in pixels from the corner of the first one.
struct ModeLens {
    focal_px: (f64, f64),
    center_px: (f64, f64),
    coefficients: LensKeys,
}

fn read(place: &SourceFolder, mut description: Description) -> Result<ReadSource> {
    let path = place.join(POSES);
    let poses = poses(&path)?;
    let mut inputs = vec![path.clone()];
    let mut frames = Vec::new();
    for name in names_in(&place.folder)? {
        let Some(index) = client(&name) else { continue };
        let Some((_, pose)) = poses.iter().find(|(of, _)| *of == index) else {
            let what = format!("there is no pose of sensor {index}, whose pictures are in {name}/");
            return Err(Error::invalid(path.display(), what));
        };
        let calibration = calibration_in(&place.join(&name))?;
        frames.extend(pictures_of(place, &name, pose, &calibration, &mut description)?);
        inputs.push(calibration);
    }
    let keys = Keys { depth_unit_scale_factor: Some(1e-3), noise_free: Some(false), ..Keys::default() };
    rig_or_recording(place, keys, frames, description, inputs)
}

/// The index of the sensor whose folder has this name.
fn client(name: &str) -> Option<u64> {
    digits_between("client_", name, "")?.parse().ok()
}

/// Poses of the color cameras by their sensors' indices.
fn poses(path: &Path) -> Result<Vec<(u64, DAffine3)>> {
    let file = TextFile::read(path)?;
    let mut found: Vec<(u64, DAffine3)> = Vec::new();
    let mut lines = file.lines();
    while let Some(head) = lines.next() {
        let index = head.fields.get(2).and_then(|field| field.parse::<u64>().ok());
        let Some(index) = index.filter(|_| head.fields.len() == 3) else {
            return Err(head.error("0, serial number and index of a sensor are expected"));
        };
        let mut rows = Vec::new();
        while rows.len() < 16 {
            let Some(line) = lines.next() else {
                return Err(
                    head.error(format!("its pose has {}; 16 are expected", counted(rows.len(), "number")))
                );
            };
            for field in &line.fields {
                rows.push(line.number_in(field)?);
            }
        }
        let Some(pose) = pose_of_rows(&rows).filter(|_| rows.len() == 16) else {
            return Err(head.error(format!("what follows is no rigid pose of 16 numbers, of sensor {index}")));
        };
        if found.iter().any(|(of, _)| *of == index) {
            return Err(head.error(format!("sensor {index} has two poses")));
        }
        found.push((index, pose));
    }
    Ok(found)
}

/// The file of calibration in a sensor's folder.
fn calibration_in(folder: &Path) -> Result<PathBuf> {
    let is_calibration =
        |name: &String| name.strip_suffix(".json").is_some_and(|stem| stem.starts_with("Intrinsics_Calib_"));
    let name = names_in(folder)?.into_iter().find(is_calibration);
    name.map(|name| folder.join(name)).ok_or_else(|| {
        let what = "there is no Intrinsics_Calib_*.json; record the take with its calibration saved (LiveScan3D writes it with raw frames)";
        Error::invalid(folder.display(), what)
    })
}

/// A camera's lens, of pictures in this mode.
fn lens_of(camera: &SensorCamera, mode: &SensorMode, path: &Path) -> Result<ModeLens> {
    let [cx, cy, fx, fy, k1, k2, k3, k4, k5, k6, away_x, away_y, p2, p1] =
        camera.intrinsics.model_parameters[..]
    else {
        let what = format!(
            "ModelParameters of {} are {}; 14 are expected",
            camera.purpose,
            camera.intrinsics.model_parameters.len()
        );
        return Err(Error::invalid(path.display(), what));
    };
    if [away_x, away_y] != [0.0; 2] {
        let what =
            format!("{} has a center of distortion apart from its axis, which is not read", camera.purpose);
        return Err(Error::unsupported(path.display(), what));
    }
    let coefficients =
        [("k1", k1), ("k2", k2), ("k3", k3), ("k4", k4), ("k5", k5), ("k6", k6), ("p1", p1), ("p2", p2)];
    Ok(ModeLens {
        focal_px: (fx * mode.scaled.0, fy * mode.scaled.1),
        center_px: (cx * mode.scaled.0 - mode.offset.0, cy * mode.scaled.1 - mode.offset.1),
        coefficients: LensKeys::of(&coefficients),
    })
}

/// Color: the whole width of a sensor of 4:3, and of pictures of 16:9 the middle of its rows.
fn color_mode(size: (usize, usize)) -> Option<SensorMode> {
    let (width, height) = (size.0 as f64, size.1 as f64);
    let all_rows = 0.75 * width;
    let is_known = height * 4.0 == width * 3.0 || height * 16.0 == width * 9.0;
    is_known.then_some(SensorMode { scaled: (width, all_rows), offset: (0.0, 0.5 * (all_rows - height)) })
}

/// Depth: the four modes of the sensor of 1024×1024.
fn depth_mode(size: (usize, usize)) -> Option<SensorMode> {
    let (side, offset) = match size {
        (640, 576) => (1024.0, (192.0, 180.0)),
        (320, 288) => (512.0, (96.0, 90.0)),
        (1024, 1024) => (1024.0, (0.0, 0.0)),
        (512, 512) => (512.0, (0.0, 0.0)),
        _ => return None,
    };
    Some(SensorMode { scaled: (side, side), offset })
}

/// Keys of a sensor's pictures: the lens of color, and the depth camera where depth is not on color's pixels already.
fn keys_of(path: &Path, sizes: [(usize, usize); 2], pose: &DAffine3) -> Result<Keys> {
    let SensorCalibration { calibration_information: CalibrationInformation { cameras } } = json(path)?;
    let camera = |purpose: &str| {
        cameras.iter().find(|camera| camera.purpose == purpose).ok_or_else(|| {
            Error::invalid(path.display(), format!("there is no camera whose Purpose is {purpose}"))
        })
    };
    let unknown = |what: &str, (width, height): (usize, usize)| {
        Error::invalid(
            path.display(),
            format!(
                "its {what} pictures are {width}×{height}, which is no mode of an Azure Kinect; the lens of another size is not known"
            ),
        )
    };
    let [color_size, depth_size] = sizes;
    let color = camera(COLOR)?;
    let mode = color_mode(color_size).ok_or_else(|| unknown("color", color_size))?;
    let ModeLens { focal_px, center_px, coefficients } = lens_of(color, &mode, path)?;
    let mut keys = lens(focal_px.0, focal_px.1, center_px.0, center_px.1, 0.5);
    keys.camera_model = Some("FULL_OPENCV".to_owned());
    keys.lens = coefficients;
    if depth_size == color_size {
        return Ok(keys);
    }
    let mode = depth_mode(depth_size).ok_or_else(|| unknown("depth", depth_size))?;
    let ModeLens { focal_px, center_px, coefficients } = lens_of(camera(DEPTH)?, &mode, path)?;
    let FromDepth { rotation, translation } = &color.rt;
    let [a, b, c, d, e, f, g, h, i] = *rotation;
    let [x, y, z] = *translation;
    let color_from_depth = pose_of_rows(&[a, b, c, x, d, e, f, y, g, h, i, z])
        .ok_or_else(|| Error::invalid(path.display(), format!("Rt of {COLOR} is no rigid transform")))?;
    keys.depth_camera = Some(Box::new(DepthCameraKeys {
        fl_x: Some(focal_px.0),
        fl_y: Some(focal_px.1),
        cx: Some(center_px.0),
        cy: Some(center_px.1),
        camera_model: Some("FULL_OPENCV".to_owned()),
        transform_matrix: Some(opengl_matrix(&(*pose * color_from_depth))),
        lens: coefficients,
        ..DepthCameraKeys::default()
    }));
    Ok(keys)
}

/// The pictures of a sensor that have color and depth.
fn pictures_of(
    place: &SourceFolder,
    client: &str,
    pose: &DAffine3,
    calibration: &Path,
    description: &mut Description,
) -> Result<Vec<PictureEntry>> {
    let folder = place.join(client);
    let depths = pictures_in(&folder, &[".tiff", ".tif", ".png"]);
    let mut keys = None;
    let mut pictures = Vec::new();
    for color in colors_in(&folder) {
        let Some(digits) = digits_between("Color_", stem(&color), "") else { continue };
        let Some(depth) =
            depths.iter().find(|depth| digits_between("Depth_", stem(depth), "") == Some(digits))
        else {
            description.skip("without depth", format!("{client}/{color}"));
            continue;
        };
        if keys.is_none() {
            let [color, depth] = [&color, depth].map(|name| folder.join(name));
            let place_of = |path: &Path| path.display().to_string();
            let sizes = [
                pictures::size(&color, &place_of(&color))?,
                pictures::depth_size(&depth, false, &place_of(&depth))?,
            ];
            keys = Some(keys_of(calibration, sizes, pose)?);
        }
        let mut one = entry(format!("{client}/{color}"), Some(format!("{client}/{depth}")), pose);
        one.keys = Keys {
            camera: Some(client.to_owned()),
            frame: digits.parse().ok(),
            ..keys.clone().unwrap_or_default()
        };
        pictures.push(one);
    }
    Ok(pictures)
}
