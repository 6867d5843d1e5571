//! From the manifest's numbers to a camera in our space, and back.
//!
//! OpenGL's camera space (x right, y up, z toward the viewer) and ours (x right, y down, z forward) differ by half a
//! turn about x, which is its own inverse.

use std::f64::consts::PI;

use glam::{DAffine3, DMat3, DVec3};

use super::manifest::Keys;
use crate::capture::camera::{Intrinsics, MAX_PIXELS, MAX_SIDE, is_believable_size};
use crate::capture::pose_convention::PoseConvention;
use crate::error::{Error, Result};

/// How far the axes of a pose may be from orthonormal: matrices are often written with six digits, or were `f32`.
const RIGID_TOLERANCE: f64 = 1e-3;
/// How far the last row of a pose may be from 0 0 0 1: programs that invert matrices leave rounding there.
const LAST_ROW_TOLERANCE: f64 = 1e-6;
/// Farthest camera that is believed: beyond it, `f32` world coordinates hold no detail, and sums overflow.
const MAX_DISTANCE: f64 = 1e9;
/// What is wrong with a pose that is a mirror image.
const MIRRORS: &str =
    "mirrors; where the axes of its camera space are left-handed, say where they point as \"camera_axes\"";
/// Focal lengths beyond this many pixels see less than a thousandth of a degree.
const MAX_FOCAL_PX: f64 = 1e9;

/// Our camera space from OpenGL's, and back.
const FLIP_Y_AND_Z: DVec3 = DVec3::new(1.0, -1.0, -1.0);

/// World from our camera space, from the manifest's matrix, which is meant as `convention` says. It mirrors where the file's world
/// is left-handed.
///
/// # Errors
/// `Invalid` where it is not 4×4 or 3×4, not finite, not rigid, or absurdly far away.
pub(super) fn world_from_camera(
    rows: &[Vec<f64>],
    convention: PoseConvention,
    place: &str,
) -> Result<DAffine3> {
    let refuse = |what: &str| Err(Error::invalid(place, format!("transform_matrix {what}")));
    let has_shape = (3..=4).contains(&rows.len()) && rows.iter().all(|row| row.len() == 4);
    if !has_shape {
        return refuse("is not 4×4; write it row by row");
    }
    if rows.iter().flatten().any(|value| !value.is_finite()) {
        return refuse("holds numbers that are not finite; export the camera again");
    }
    let mut last = rows.get(3).into_iter().flatten().zip([0.0, 0.0, 0.0, 1.0]);
    if last.any(|(value, expected)| (value - expected).abs() > LAST_ROW_TOLERANCE) {
        return refuse("does not end in 0 0 0 1; write it row by row");
    }
    let column = |index: usize| DVec3::new(rows[0][index], rows[1][index], rows[2][index]);
    let eye = column(3);
    if eye.abs().max_element() > MAX_DISTANCE {
        return refuse("puts the camera too far away; bring the scene near the origin");
    }
    let matrix = DMat3::from_cols(column(0), column(1), column(2));
    let product = matrix.transpose() * matrix;
    if !product.abs_diff_eq(DMat3::IDENTITY, RIGID_TOLERANCE) {
        return refuse("is not a rotation and a translation; export it without scale, shear or mirroring");
    }
    if matrix.determinant() < 0.0 && convention.axes.is_right_handed() {
        return refuse(MIRRORS);
    }
    Ok(convention.world_from_camera(&DAffine3::from_mat3_translation(orthonormal(matrix), eye)))
}

/// Whether the rows of a pose mirror.
pub(super) fn mirrors(rows: &[Vec<f64>]) -> bool {
    let at =
        |row: usize, column: usize| rows.get(row).and_then(|row| row.get(column)).copied().unwrap_or(0.0);
    let column = |column| DVec3::new(at(0, column), at(1, column), at(2, column));
    DMat3::from_cols(column(0), column(1), column(2)).determinant() < 0.0
}

/// The manifest's matrix of a camera, camera-to-world with OpenGL's axes.
pub(crate) fn opengl_matrix(world_from_camera: &DAffine3) -> Vec<Vec<f64>> {
    let matrix = world_from_camera.matrix3 * DMat3::from_diagonal(FLIP_Y_AND_Z);
    let eye = world_from_camera.translation;
    let mut rows: Vec<Vec<f64>> = (0..3)
        .map(|row| vec![matrix.x_axis[row], matrix.y_axis[row], matrix.z_axis[row], eye[row]])
        .collect();
    rows.push(vec![0.0, 0.0, 0.0, 1.0]);
    rows
}

/// The nearest rotation, for what is one up to rounding: Newton's iteration for the polar decomposition, which at
/// this distance is exact to `f64` after three steps and leaves a rotation as it is.
fn orthonormal(matrix: DMat3) -> DMat3 {
    (0..3).fold(matrix, |matrix, _| (matrix + matrix.inverse().transpose()) * 0.5)
}

/// Intrinsics from the manifest's keys; `size` is that of the picture, for manifests that do not give one, and `pixel_aspect` the
/// width of its pixels over their height, for those that give one focal length for both directions.
///
/// # Errors
/// `Invalid` for missing, absurd or non-finite numbers, `Unsupported` for too many pixels.
pub(super) fn intrinsics(
    keys: &Keys,
    size: impl FnOnce() -> Result<(usize, usize)>,
    pixel_aspect: impl FnOnce() -> f64,
    place: &str,
) -> Result<Intrinsics> {
    let (width, height) = picture_size(keys, size, place)?;
    let (w, h) = (f64::from(width), f64::from(height));
    let degrees = |value: Option<f64>| value.map(f64::to_radians);
    let fx = focal_px(keys.fl_x, "camera_angle_x", keys.camera_angle_x, w, place)?;
    let fx = focal_px(fx, "x_fov, in radians,", degrees(keys.x_fov), w, place)?;
    let fy = focal_px(keys.fl_y, "camera_angle_y", keys.camera_angle_y, h, place)?;
    let fy = focal_px(fy, "y_fov, in radians,", degrees(keys.y_fov), h, place)?;
    let (fx, fy) = match (fx, fy) {
        (Some(fx), Some(fy)) => (fx, fy),
        (Some(fx), None) => (fx, fx * pixel_aspect()),
        (None, Some(fy)) => (fy / pixel_aspect(), fy),
        (None, None) => {
            let what = "there is no focal length; give fl_x (pixels) or camera_angle_x";
            return Err(Error::invalid(place, what));
        }
    };
    for (name, focal) in [("fl_x", fx), ("fl_y", fy)] {
        if !(focal > 0.0 && focal < MAX_FOCAL_PX) {
            return Err(Error::invalid(place, format!("{name} is {focal} pixels, which is no focal length")));
        }
    }
    let offset = keys.pixel_center_offset.unwrap_or(0.5);
    if !(0.0..=1.0).contains(&offset) {
        let what =
            format!("pixel_center_offset is {offset}; it lies between 0 and 1, and is 0.5 or 0 as a rule");
        return Err(Error::invalid(place, what));
    }
    let shift = 0.5 - offset;
    let cx = keys.cx.map_or(w / 2.0, |cx| cx + shift);
    let cy = keys.cy.map_or(h / 2.0, |cy| cy + shift);
    for (name, center, side) in [("cx", cx, w), ("cy", cy, h)] {
        // Shifted lenses and crops put it outside the picture, but not this far.
        if center.is_nan() || (center - side / 2.0).abs() > 100.0 * side {
            return Err(Error::invalid(place, format!("{name} is {center} pixels, far outside the picture")));
        }
    }
    Ok(Intrinsics { width, height, fx, fy, cx, cy })
}

/// A focal length as it is given, or else from the angle of view over `side` pixels.
fn focal_px(
    focal: Option<f64>,
    name: &str,
    angle: Option<f64>,
    side: f64,
    place: &str,
) -> Result<Option<f64>> {
    match (focal, angle) {
        (None, Some(angle)) if !(angle > 0.0 && angle < PI) => {
            Err(Error::invalid(place, format!("{name} is {angle}; it is in radians, between 0 and π")))
        }
        (None, Some(angle)) => Ok(Some(0.5 * side / (0.5 * angle).tan())),
        _ => Ok(focal),
    }
}

/// Columns and rows as the manifest has them, or else the picture; where the manifest has one of them, the picture must agree.
fn picture_size(
    keys: &Keys,
    size: impl FnOnce() -> Result<(usize, usize)>,
    place: &str,
) -> Result<(u32, u32)> {
    let given = |name: &str, value: Option<f64>| value.map(|value| side(name, value, place)).transpose();
    let (width, height) = match (given("w", keys.w)?, given("h", keys.h)?) {
        (Some(width), Some(height)) => (width, height),
        (w, h) => {
            let (width, height) = size()?;
            let (width, height) = (width as u32, height as u32);
            for (name, given, found) in [("w", w, width), ("h", h, height)] {
                if let Some(given) = given
                    && given != found
                {
                    let what = format!(
                        "{name} is {given} but the picture is {width}×{height}; give both w and h, or neither, as the picture has them"
                    );
                    return Err(Error::invalid(place, what));
                }
            }
            (width, height)
        }
    };
    if !is_believable_size(width as usize, height as usize) {
        let what = format!("{width}×{height} pixels are too many; a picture has at most {MAX_PIXELS}");
        return Err(Error::unsupported(place, what));
    }
    Ok((width, height))
}

fn side(name: &str, value: f64, place: &str) -> Result<u32> {
    if value.fract() == 0.0 && (1.0..=MAX_SIDE as f64).contains(&value) {
        Ok(value as u32)
    } else {
        Err(Error::invalid(place, format!("{name} is {value}; a picture has 1 to {MAX_SIDE} pixels a side")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::camera::Camera;
    use crate::capture::transforms::lens::LensKeys;
    use glam::DVec2;

    const SIZE: (usize, usize) = (640, 480);

    #[test]
    fn an_opengl_camera_looks_along_minus_z_with_y_up() {
        // OpenGL's identity pose: x right, y up, looking along −z.
        let rows: Vec<Vec<f64>> =
            (0..4).map(|r| (0..4).map(|c| f64::from(u8::from(r == c))).collect()).collect();
        let pose = world_from_camera(&rows, PoseConvention::default(), "test").unwrap();
        assert_eq!(pose.transform_vector3(DVec3::Z), DVec3::NEG_Z);
        assert_eq!(pose.transform_vector3(DVec3::Y), DVec3::NEG_Y);
        assert_eq!(opengl_matrix(&pose), rows);
    }

    #[test]
    fn the_documented_unprojection_of_opengl_cameras_is_ours() {
        let (eye, target) = (DVec3::new(3.0, -4.0, 2.0), DVec3::new(0.0, 1.0, 0.5));
        let intrinsics = Intrinsics { width: 8, height: 6, fx: 7.0, fy: 9.0, cx: 3.5, cy: 3.25 };
        let camera = Camera::look_at("c", intrinsics, eye, target, DVec3::Z);
        let m = opengl_matrix(&camera.world_from_camera);
        let (i, j, z) = (2.0, 5.0, 4.0);
        // M · (z (i + ½ − cx)/fx, −z (j + ½ − cy)/fy, −z, 1)
        let local = [z * (i + 0.5 - 3.5) / 7.0, -z * (j + 0.5 - 3.25) / 9.0, -z, 1.0];
        let world = camera.unproject(DVec2::new(i + 0.5, j + 0.5), z);
        for row in 0..3 {
            let theirs: f64 = (0..4).map(|column| m[row][column] * local[column]).sum();
            assert!((theirs - world[row]).abs() < 1e-12);
        }
        let back = world_from_camera(&m, PoseConvention::default(), "test").unwrap();
        assert!(back.abs_diff_eq(camera.world_from_camera, 1e-12));
    }

    #[test]
    fn matrices_that_are_no_pose_are_refused() {
        let good = opengl_matrix(&DAffine3::IDENTITY);
        let change = |row: usize, column: usize, value: f64| {
            let mut rows = good.clone();
            rows[row][column] = value;
            rows
        };
        let scaled: Vec<Vec<f64>> = good.iter().map(|row| row.iter().map(|v| v * 2.0).collect()).collect();
        let bad = [
            change(0, 0, -1.0),
            change(0, 1, f64::NAN),
            change(1, 3, 1e12),
            change(3, 0, 1.0),
            scaled,
            vec![],
        ];
        for rows in bad {
            let error =
                world_from_camera(&rows, PoseConvention::default(), "frames[3]").unwrap_err().to_string();
            assert!(error.starts_with("frames[3]: transform_matrix"), "{error}");
        }
        assert!(world_from_camera(&change(0, 1, 1e-5), PoseConvention::default(), "").is_ok());
        assert!(
            world_from_camera(&change(3, 2, 1e-17), PoseConvention::default(), "").is_ok(),
            "what an inversion leaves"
        );
        assert!(world_from_camera(&change(3, 2, 1e-3), PoseConvention::default(), "").is_err());
        assert!(world_from_camera(&good[..3], PoseConvention::default(), "").is_ok());
    }

    #[test]
    fn angle_and_pixel_center_stand_in_for_focal_length_and_principal_point() {
        let keys = Keys { camera_angle_x: Some(std::f64::consts::FRAC_PI_2), ..Keys::default() };
        let found = intrinsics(&keys, || Ok(SIZE), || 1.0, "").unwrap();
        assert!((found.fx - 320.0).abs() < 1e-9 && found.fx == found.fy);
        assert_eq!((found.width, found.height, found.cx, found.cy), (640, 480, 320.0, 240.0));
        let keys = Keys {
            fl_x: Some(500.0),
            cx: Some(319.5),
            cy: Some(239.5),
            pixel_center_offset: Some(0.0),
            ..Keys::default()
        };
        let found = intrinsics(&keys, || Ok(SIZE), || 1.0, "").unwrap();
        assert_eq!((found.fy, found.cx, found.cy), (500.0, 320.0, 240.0));
    }

    #[test]
    fn an_angle_that_cannot_be_in_radians_is_refused_by_its_own_name() {
        for angle in [52.0, 0.0, -1.0, PI, f64::NAN] {
            let keys = Keys { camera_angle_x: Some(angle), ..Keys::default() };
            let error = intrinsics(&keys, || Ok(SIZE), || 1.0, "test").unwrap_err().to_string();
            let expected = format!("test: camera_angle_x is {angle}; it is in radians, between 0 and π");
            assert_eq!(error, expected);
            let keys = Keys { camera_angle_y: Some(angle), ..Keys::default() };
            let error = intrinsics(&keys, || Ok(SIZE), || 1.0, "test").unwrap_err().to_string();
            assert!(error.contains("camera_angle_y is"), "{error}");
            let unused = Keys { fl_x: Some(500.0), fl_y: Some(500.0), ..keys };
            assert!(intrinsics(&unused, || Ok(SIZE), || 1.0, "test").is_ok());
        }
    }

    #[test]
    fn lenses_that_bend_are_known_and_others_refused() {
        let with = |model: &str, key: &str, value: f64| {
            let lens = LensKeys::from(serde_json::Map::from_iter([(key.to_owned(), value.into())]));
            let camera_model = Some(model.to_owned());
            Keys { fl_x: Some(500.0), camera_model, lens, ..Keys::default() }.distortion("")
        };
        for model in ["PINHOLE", "OPENCV", "SIMPLE_RADIAL", "RADIAL", "FULL_OPENCV"] {
            assert_eq!(with(model, "k1", 0.0).unwrap(), None, "{model}");
            assert!(with(model, "k1", 0.01).unwrap().is_some(), "{model}");
        }
        assert!(with("OPENCV_FISHEYE", "k1", 0.0).unwrap().is_some());
        assert!(with("FOV", "omega", 0.9).unwrap().is_some());
        for (model, key) in
            [("OPENCV", "ftheta_p1"), ("THIN_PRISM_FISHEYE", "k1"), ("OPENCV", "k4"), ("PINHOLE", "p3")]
        {
            assert!(with(model, key, 0.01).is_err(), "{model} {key}");
        }
    }

    #[test]
    fn absurd_and_contradictory_numbers_are_refused() {
        let good = Keys { fl_x: Some(500.0), w: Some(64.0), h: Some(48.0), ..Keys::default() };
        assert!(intrinsics(&good, || Ok(SIZE), || 1.0, "").is_ok());
        let bad = [
            Keys { fl_x: Some(0.0), ..good.clone() },
            Keys { fl_y: Some(-1.0), ..good.clone() },
            Keys { w: Some(1e6), ..good.clone() },
            Keys { h: Some(0.0), ..good.clone() },
            Keys { w: Some(10.5), ..good.clone() },
            Keys { cx: Some(1e9), ..good.clone() },
            Keys { fl_x: None, ..good.clone() },
            Keys { pixel_center_offset: Some(-40.0), ..good.clone() },
            Keys { h: None, w: Some(64.0), ..good.clone() },
            Keys { w: Some(32_768.0), h: Some(32_768.0), ..good.clone() },
        ];
        for keys in bad {
            assert!(intrinsics(&keys, || Ok(SIZE), || 1.0, "").is_err(), "{keys:?}");
        }
        assert!(intrinsics(&Keys { w: None, h: Some(480.0), ..good }, || Ok(SIZE), || 1.0, "").is_ok());
    }
}
