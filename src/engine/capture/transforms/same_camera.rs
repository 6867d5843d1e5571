//! Whether two entries of a manifest were recorded by one camera: equal but for rounding.

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
