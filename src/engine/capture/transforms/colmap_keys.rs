//! The keys of a COLMAP camera.

use std::path::Path;

use super::lens::LensKeys;
use super::manifest::Keys;
use crate::capture::colmap::ColmapCamera;
use crate::error::{Error, Result};

/// Size, lens and distortion of a camera that `path` lists.
///
/// # Errors
/// `Unsupported` for a lens that no keys describe.
pub(crate) fn keys_of_colmap(camera: &ColmapCamera, path: &Path) -> Result<Keys> {
    if !camera.model.is_read() {
        let what = format!(
            "camera {} is of model {}, which is not undone; undistort the images (colmap image_undistorter), and open that folder",
            camera.id, camera.model.name
        );
        return Err(Error::unsupported(path.display(), what));
    }
    let named = || camera.model.parameters.iter().copied().zip(camera.parameters.iter().copied());
    let number = |names: [&str; 2]| named().find(|(name, _)| names.contains(name)).map(|(_, value)| value);
    let bent: Vec<(&str, f64)> = named().filter(|(name, _)| name.starts_with(['k', 'p', 'o'])).collect();
    Ok(Keys {
        w: Some(camera.width as f64),
        h: Some(camera.height as f64),
        camera_model: Some(camera.model.name.to_owned()),
        lens: LensKeys::of(&bent),
        fl_x: number(["f", "fx"]),
        fl_y: number(["f", "fy"]),
        cx: number(["cx", ""]),
        cy: number(["cy", ""]),
        pixel_center_offset: Some(0.5),
        ..Keys::default()
    })
}
