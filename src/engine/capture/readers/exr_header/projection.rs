//! Headers with the matrix that takes points of the world to the picture: Arnold's `worldToScreen`, Karma's and `RenderMan`'s `worldToNDC`.
//!
//! Source: OpenEXR's standard attributes: points are rows before the matrix, and are divided by their fourth coordinate. `worldToNDC`
//! ends in 0 to 1 from the lower left corner, `worldToScreen` in −1 to 1; the vertical of the latter may be divided by the picture's
//! aspect. What differs: pose and lens are both taken from this one matrix, so that the handedness of a renderer's camera space does
//! not matter; the range under which pixels are square is the one that is meant.

use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};

use super::header_camera::{HeaderCamera, lacks};
use crate::capture::exr::HeaderAttributes;
use crate::error::{Error, Result};

const TO_UNIT: &str = "worldToNDC";
const TO_SCREEN: &str = "worldToScreen";
/// How far a pixel's sides may differ and it be square.
const SQUARE: f64 = 0.01;

pub(super) fn is_of(header: &HeaderAttributes) -> bool {
    [TO_UNIT, TO_SCREEN].iter().any(|name| header.matrix(name).is_some())
}

/// The camera of a header.
///
/// # Errors
/// `Invalid` for a missing matrix, and for one that is no camera's.
pub(super) fn camera(header: &HeaderAttributes, path: &Path) -> Result<HeaderCamera> {
    let (unit, screen) = (header.matrix(TO_UNIT), header.matrix(TO_SCREEN));
    let matrix = screen.or(unit).ok_or_else(|| lacks(path, "worldToScreen or worldToNDC"))?;
    let name = if screen.is_some() { TO_SCREEN } else { TO_UNIT };
    let refuse = |what: &str| {
        Error::invalid(path.display(), format!("{name} in the header {what}; write a transforms.json"))
    };
    let taken = Projection::of(&matrix).ok_or_else(|| refuse("is no perspective camera's"))?;
    if taken.mirrors {
        return Err(refuse("mirrors the world"));
    }
    let (width, height) = (header.size.0 as f64, header.size.1 as f64);
    let lenses = if screen.is_some() {
        let fx = 0.5 * taken.scale.0 * width;
        let cx = 0.5 * (taken.shift.0 + 1.0) * width;
        // Half of the height, or of the width, is 1.
        let lens = |half: f64| [fx, taken.scale.1 * half, cx, 0.5 * height - taken.shift.1 * half];
        vec![lens(0.5 * height), lens(0.5 * width)]
    } else {
        let (fx, fy) = (taken.scale.0 * width, taken.scale.1 * height);
        vec![[fx, fy, taken.shift.0 * width, (1.0 - taken.shift.1) * height]]
    };
    let is_square = |lens: &&[f64; 4]| (lens[0] / lens[1] - 1.0).abs() < SQUARE;
    let lens = *lenses.iter().find(is_square).ok_or_else(|| refuse("gives pixels that are not square"))?;
    Ok(HeaderCamera { world_from_camera: taken.world_from_camera, lens })
}

/// A projection taken apart.
struct Projection {
    /// x right, y down, z forward.
    world_from_camera: DAffine3,
    /// Where a step of x or up at distance 1 goes.
    scale: (f64, f64),
    /// Where the optical axis goes.
    shift: (f64, f64),
    mirrors: bool,
}

impl Projection {
    /// Takes apart a matrix that is multiplied by points as rows; `None` if it is no perspective.
    fn of(matrix: &[f64; 16]) -> Option<Self> {
        let normal = |column: usize| DVec3::new(matrix[column], matrix[4 + column], matrix[8 + column]);
        let distance = normal(3).length();
        let forward = normal(3).try_normalize()?;
        let part = |column: usize| {
            let along = normal(column) / distance;
            let shift = along.dot(forward);
            let across = along - shift * forward;
            Some((across.try_normalize()?, across.length(), shift))
        };
        let ((right, scale_x, shift_x), (up, scale_y, shift_y)) = (part(0)?, part(1)?);
        if right.dot(up).abs() > 1e-3 {
            return None;
        }
        // All that is seen at no distance: the camera.
        let rows = DMat3::from_cols(normal(0), normal(1), normal(3)).transpose();
        let eye = rows.inverse() * -DVec3::new(matrix[12], matrix[13], matrix[15]);
        let down = forward.cross(right);
        let rotation = DMat3::from_cols(right, down, forward);
        let is_finite = eye.is_finite() && rotation.is_finite();
        is_finite.then(|| Self {
            world_from_camera: DAffine3::from_mat3_translation(rotation, eye),
            scale: (scale_x, scale_y),
            shift: (shift_x, shift_y),
            mirrors: down.dot(up) > 0.0,
        })
    }
}
