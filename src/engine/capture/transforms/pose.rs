//! From the manifest's matrix to the pose of a camera in our space, and back.
//!
//! OpenGL's camera space (x right, y up, z toward the viewer) and ours (x right, y down, z forward) differ by half a
//! turn about x, which is its own inverse.

use glam::{DAffine3, DMat3, DVec3};

use super::manifest_file::ManifestOrigin;
use crate::capture::pose_convention::PoseConvention;
use crate::error::{Error, Result};

/// How far the axes of a pose may be from orthonormal: matrices are often written with six digits, or were `f32`.
const RIGID_TOLERANCE: f64 = 1e-3;
/// How far rounding to three digits takes them, and to two: by twice the half of the last digit, times the sum of an axis.
const RIGID_TOLERANCE_OF_DIGITS: [(f64, f64); 2] = [(1e3, 1.75e-3), (1e2, 1.75e-2)];
/// How far the last row of a pose may be from 0 0 0 1: programs that invert matrices leave rounding there.
const LAST_ROW_TOLERANCE: f64 = 1e-6;
/// Farthest camera that is believed: beyond it, `f32` world coordinates hold no detail, and sums overflow.
const MAX_DISTANCE: f64 = 1e9;
/// What is wrong with a pose that is a mirror image.
const MIRRORS: &str =
    "mirrors; where the axes of its camera space are left-handed, say where they point as \"camera_axes\"";

/// Our camera space from OpenGL's, and back.
const FLIP_Y_AND_Z: DVec3 = DVec3::new(1.0, -1.0, -1.0);

/// World from our camera space, from the manifest's matrix, which is meant in `convention`. It mirrors where the file's world
/// is left-handed.
///
/// # Errors
/// `Invalid` where it is not 4×4 or 3×4, not finite, not rigid, or absurdly far away.
pub(super) fn world_from_camera(
    rows: &[Vec<f64>],
    convention: PoseConvention,
    place: &str,
) -> Result<DAffine3> {
    checked(rows, convention).map_err(|what| refused(place, what))
}

/// The error of a pose; `what` as [`checked`] gives it.
pub(super) fn refused(place: &str, what: &str) -> Error {
    Error::invalid(place, format!("transform_matrix {what}"))
}

/// Where the pose of an entry is, for messages.
pub(super) fn place_of(origin: &ManifestOrigin, index: usize, file_path: &str) -> String {
    format!("{}, frames[{index}] ({file_path})", origin.path.display())
}

/// As [`world_from_camera`]; the error is what the matrix is or does, and advice behind a semicolon.
pub(super) fn checked(rows: &[Vec<f64>], convention: PoseConvention) -> Result<DAffine3, &'static str> {
    let refuse = |what: &'static str| Err(what);
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
    if !product.abs_diff_eq(DMat3::IDENTITY, rigid_tolerance(&matrix)) {
        return refuse("is not a rotation and a translation; export it without scale, shear or mirroring");
    }
    if matrix.determinant() < 0.0 && convention.axes.is_right_handed() {
        return refuse(MIRRORS);
    }
    Ok(convention.world_from_camera(&DAffine3::from_mat3_translation(orthonormal(matrix), eye)))
}

/// How far a matrix may be from a rotation: farther where it was written with few digits.
fn rigid_tolerance(matrix: &DMat3) -> f64 {
    // A single has seven digits.
    let is_whole = |value: f64| (value - value.round()).abs() < 1e-4;
    let is_of = |(scale, _): &&(f64, f64)| matrix.to_cols_array().iter().all(|value| is_whole(value * scale));
    RIGID_TOLERANCE_OF_DIGITS.iter().rev().find(is_of).map_or(RIGID_TOLERANCE, |(_, tolerance)| *tolerance)
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

/// The nearest rotation, for a matrix that is a rotation up to rounding: Newton's iteration for the polar decomposition, which at
/// this distance is exact to `f64` after three steps and leaves a rotation as it is.
fn orthonormal(matrix: DMat3) -> DMat3 {
    (0..3).fold(matrix, |matrix, _| (matrix + matrix.inverse().transpose()) * 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::camera::{Camera, Intrinsics};
    use glam::DVec2;

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
        let intrinsics = Intrinsics { fy: 9.0, cx: 3.5, cy: 3.25, ..Intrinsics::centered(8, 6, 7.0) };
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
    fn a_rotation_of_few_digits_becomes_the_nearest_one() {
        let turn = DMat3::from_rotation_z(0.6) * DMat3::from_rotation_x(1.1);
        let rounded = |digits: i32, by: f64| {
            let scale = 10_f64.powi(digits);
            let mut rows = opengl_matrix(&DAffine3::from_mat3(turn * by));
            for value in rows.iter_mut().flatten() {
                *value = (*value * scale).round() / scale;
            }
            world_from_camera(&rows, PoseConvention::default(), "")
        };
        for (digits, off) in [(2, 0.01), (3, 0.001), (7, 1e-6)] {
            let matrix = rounded(digits, 1.0).unwrap().matrix3;
            assert!((matrix.transpose() * matrix).abs_diff_eq(DMat3::IDENTITY, 1e-12), "{digits}");
            assert!(matrix.abs_diff_eq(turn, off), "{digits}");
        }
        assert!(rounded(7, 1.005).is_err() && rounded(3, 1.02).is_err(), "a scale is no rounding");
    }
}
