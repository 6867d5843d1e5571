//! Unreal Engine's Movie Render Queue.
//!
//! Source: attributes that the engine writes: `unreal/camera/curPos/{x,y,z}` in centimeters, `unreal/camera/curRot/{yaw,pitch,roll}`
//! in degrees, `unreal/camera/FinalImage/{focalLength,sensorWidth}` in millimeters. The world is left-handed: x forward, y right,
//! z up. It becomes ours with x right, y down, z forward.

use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};

use super::header_camera::{HeaderCamera, lacks};
use crate::capture::exr::HeaderAttributes;
use crate::error::{Error, Result};

/// Up in the world that is read.
pub(super) const UP: [f64; 3] = [0.0, -1.0, 0.0];

const CAMERA: &str = "unreal/camera/";
/// The attributes of the lens, by versions of the engine.
const LENSES: [&str; 3] = ["unreal/camera/FinalImage/", "unreal/layerData/rgba/", "unreal/camera/"];

/// Our axes from the engine's: right, down, forward.
const OURS_FROM_UNREAL: DMat3 =
    DMat3::from_cols(DVec3::new(0.0, 0.0, 1.0), DVec3::new(1.0, 0.0, 0.0), DVec3::new(0.0, -1.0, 0.0));

pub(super) fn is_of(header: &HeaderAttributes) -> bool {
    header.has(CAMERA)
}

/// The camera of a header.
///
/// # Errors
/// `Invalid` where something is missing, `Unsupported` for overscan.
pub(super) fn camera(header: &HeaderAttributes, path: &Path) -> Result<HeaderCamera> {
    let number = |name: &str| {
        let name = format!("{CAMERA}{name}");
        header.number(&name).filter(|number| number.is_finite()).ok_or_else(|| lacks(path, &name))
    };
    let of_lens = |name: &str| LENSES.iter().find_map(|start| header.number(&format!("{start}{name}")));
    if of_lens("overscanPercentage").is_some_and(|overscan| overscan != 0.0) {
        return Err(Error::unsupported(path.display(), "the picture has overscan; render it without"));
    }
    let position = DVec3::new(number("curPos/x")?, number("curPos/y")?, number("curPos/z")?) * 0.01;
    let [yaw, pitch, roll] = ["yaw", "pitch", "roll"].map(|name| number(&format!("curRot/{name}")));
    let rotation = OURS_FROM_UNREAL
        * camera_from_world(yaw?.to_radians(), pitch?.to_radians(), roll?.to_radians()).transpose()
        * OURS_FROM_UNREAL.transpose();
    let (width, height) = (header.size.0 as f64, header.size.1 as f64);
    let focal = match (of_lens("focalLength"), of_lens("sensorWidth"), of_lens("fov")) {
        (Some(focal), Some(sensor), _) if focal > 0.0 && sensor > 0.0 => focal * width / sensor,
        (_, _, Some(degrees)) if degrees > 0.0 && degrees < 180.0 => {
            0.5 * width / (0.5 * degrees.to_radians()).tan()
        }
        _ => return Err(lacks(path, "unreal/camera/FinalImage/focalLength with sensorWidth")),
    };
    Ok(HeaderCamera {
        world_from_camera: DAffine3::from_mat3_translation(rotation, OURS_FROM_UNREAL * position),
        lens: [focal, focal, 0.5 * width, 0.5 * height],
    })
}

/// The engine's rotation of an `FRotator`, world to camera, x forward, y right, z up.
fn camera_from_world(yaw: f64, pitch: f64, roll: f64) -> DMat3 {
    let (sine, cosine) = yaw.sin_cos();
    let turn = DMat3::from_cols(DVec3::new(cosine, -sine, 0.0), DVec3::new(sine, cosine, 0.0), DVec3::Z);
    DMat3::from_rotation_x(roll) * DMat3::from_rotation_y(pitch) * turn
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn yaw_turns_right_and_pitch_up() {
        let (yaw, pitch) = (0.5_f64, 0.3_f64);
        let forward = camera_from_world(yaw, pitch, 0.2).transpose() * DVec3::X;
        let expected = DVec3::new(pitch.cos() * yaw.cos(), pitch.cos() * yaw.sin(), pitch.sin());
        assert!(forward.abs_diff_eq(expected, 1e-12));
        assert_eq!(OURS_FROM_UNREAL * DVec3::X, DVec3::Z, "forward");
        assert_eq!(OURS_FROM_UNREAL * DVec3::Y, DVec3::X, "right");
        assert_eq!(OURS_FROM_UNREAL * DVec3::Z, DVec3::NEG_Y, "up");
    }
}
